# SPDX-License-Identifier: GPL-3.0-or-later
"""The result: heat maps, keep as a new object."""

import bpy
import numpy

from .. import heat_map, legend, mesh_data, properties
from ..library import Wrong
from .base import NeedsTemplate, tells


class _NeedsResult(NeedsTemplate):
    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        if not properties.template_of(context).moulage.result.key:
            cls.poll_message_set("There is no result yet: reshape first")
            return False
        return True


class MOULAGE_OT_show_heat_map(_NeedsResult, bpy.types.Operator):
    """Colour the template by how far its markers are off, how much it was stretched, or how sure its shape is"""

    bl_idname = "moulage.show_heat_map"
    bl_label = "Show Heat Map"

    kind: bpy.props.EnumProperty(
        name="Heat map", description="What the template's colours tell", items=properties.HEAT_MAPS
    )

    @tells
    def execute(self, context):
        template = properties.template_of(context)
        if self.kind == "SURE" and legend.largest_value(template, self.kind) is None:
            raise Wrong("How sure the shape is is known after a whole run: reshape once more.")
        heat_map.show(context, template, self.kind)
        return {"FINISHED"}


class MOULAGE_OT_copy_result(_NeedsResult, bpy.types.Operator):
    """Make a new object in the person's shape, without shape keys; textures, groups and materials are kept"""

    bl_idname = "moulage.copy_result"
    bl_label = "Copy as New Object"

    @tells
    def execute(self, context):
        template = properties.template_of(context)
        keys = template.data.shape_keys
        key = keys.key_blocks.get(template.moulage.result.key) if keys else None
        if key is None:
            raise Wrong("The result's shape key was removed: reshape again.")
        points = mesh_data.key_points(key)
        copy = template.copy()
        copy.data = template.data.copy()
        copy.name = f"{template.name} reshaped"
        copy.property_unset("moulage")
        copy.shape_key_clear()
        copy.data.vertices.foreach_set("co", numpy.ascontiguousarray(points).ravel())
        copy.data.update()
        (template.users_collection or (context.scene.collection,))[0].objects.link(copy)
        return {"FINISHED"}


classes = (MOULAGE_OT_show_heat_map, MOULAGE_OT_copy_result)
