# SPDX-License-Identifier: GPL-3.0-or-later
"""What a separation is told, and what it said, saved on the scene; and which meshes take part."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from .properties import METHODS


class MOULAGE_PG_separate(bpy.types.PropertyGroup):
    """Settings of Separate; lengths in the scene's units."""

    bones: PointerProperty(
        name="Bones", description="A collection of bones or other meshes that push the selected ones and do not move",
        type=bpy.types.Collection,
    )
    gap: FloatProperty(
        name="Gap", subtype="DISTANCE", min=0.0, precision=3,
        description="Distance that is aimed at between surfaces that overlapped. 0: the meshes' usual diagonal / 2000",
    )
    rings: IntProperty(
        name="Rings", description="Vertices up to so many edges away from an overlap may move", default=5, min=1, soft_max=20
    )
    method: EnumProperty(name="Tets", description="What fills the meshes with tets", items=METHODS)
    tet_count: IntProperty(
        name="Number", description="About how many tets a mesh is filled with that was not reshaped here", default=15000,
        min=24, max=10_000_000, soft_max=100_000,
    )
    live: BoolProperty(name="Live view", description="Show the shapes while they are being pushed apart", default=True)

    report: StringProperty(description="What the last separation said, one sentence per line")
    clear: BoolProperty(description="Whether nothing overlapped any more")


def chosen(context):
    """The meshes that may move and those that stay: (selected, in the collection)."""
    collection = context.scene.moulage_separate.bones
    hard = [ob for ob in collection.all_objects if ob.type == "MESH"] if collection else []
    soft = [ob for ob in context.selected_objects if ob.type == "MESH" and ob not in hard]
    return sorted(soft, key=lambda ob: ob.name), sorted(hard, key=lambda ob: ob.name)


classes = (MOULAGE_PG_separate,)


def register():
    bpy.types.Scene.moulage_separate = PointerProperty(type=MOULAGE_PG_separate)


def unregister():
    del bpy.types.Scene.moulage_separate
