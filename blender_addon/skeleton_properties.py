# SPDX-License-Identifier: GPL-3.0-or-later
"""What is saved in the .blend about skeletons: on the armature the target and the result, on each of its bones
the joint."""

import bpy
from bpy.props import (
    BoolProperty, CollectionProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty,
    StringProperty,
)

from . import blend, views


def _is_mesh(_self, ob):
    return ob.type == "MESH"


def _select_bone(self, context):
    if self.active_bone < len(self.bones) and self.bones[self.active_bone].object is not None:
        views.select_only(context, self.bones[self.active_bone].object)


def _show_share(self, _context):
    blend.show(self.id_data, self.share)


class MOULAGE_PG_joint(bpy.types.PropertyGroup):
    """The joint at a bone's head; its limits are the bone's Limit Rotation constraint."""

    joint: StringProperty(name="Joint", description="Name of the joint in files; empty: the bone's")
    shift: FloatProperty(
        name="Shift", subtype="DISTANCE", min=0.0,
        description="How far the two bones may move apart at the joint. 0: half a percent of the skeleton's diagonal",
    )
    label: IntProperty(name="Label", description="The bone's number in label maps; 0: none", min=0)
    coordinates: StringProperty(description="Named angles of the joint, as the file has them")
    widened: FloatVectorProperty(description="What the constraint allows beyond the limits, to hold the pose", size=6)


class MOULAGE_PG_loop(bpy.types.PropertyGroup):
    """A joint that only closes a loop: an armature has no place for it."""

    name: StringProperty(description="The joint's")
    parent: StringProperty(description="Name of one bone")
    child: StringProperty(description="Name of the other bone")
    parent_frame: FloatVectorProperty(description="The joint seen from one bone, row by row", size=16)
    child_frame: FloatVectorProperty(description="The joint seen from the other bone, row by row", size=16)
    negative: FloatVectorProperty(description="Radians; below 0: free", size=3)
    positive: FloatVectorProperty(description="Radians; below 0: free", size=3)
    shift: FloatProperty(description="How far the two bones may move apart; 0: the usual distance")


class MOULAGE_PG_soft(bpy.types.PropertyGroup):
    """A soft tissue that moves with the bones."""

    object: PointerProperty(name="Mesh", description="A muscle, or the skin", type=bpy.types.Object, poll=_is_mesh)


class MOULAGE_PG_joint_result(bpy.types.PropertyGroup):
    """How a joint of the person stands to its limits."""

    name: StringProperty(description="The joint's")
    usage: FloatProperty(description="Share of the allowed rotation that is used; 1: at the limit")
    rotation: FloatProperty(description="Rotation from the neutral position", subtype="ANGLE")
    excess: FloatProperty(description="Rotation beyond the limit", subtype="ANGLE")


class MOULAGE_PG_bone_verdict(bpy.types.PropertyGroup):
    """How far a bone of the person can be trusted; its length in the scene's units."""

    name: StringProperty(description="The bone's")
    object: PointerProperty(description="The bone's mesh", type=bpy.types.Object)
    verdict: StringProperty(description="good, doubtful or failed")
    reasons: StringProperty(description="Why it is not good, and what can be done about it, one sentence per line")
    mean_residual: FloatProperty(description="Its mean distance from the target", default=-1.0)


class MOULAGE_PG_registration(bpy.types.PropertyGroup):
    """What the run that made a person's skeleton said; lengths in the scene's units."""

    ending: StringProperty(description="How the run ended, one sentence")
    verdict: StringProperty(description="How far the whole can be trusted: good, doubtful, failed")
    warnings: StringProperty(description="What should be known about the result, one sentence per line")
    bones: CollectionProperty(type=MOULAGE_PG_bone_verdict, description="Failed ones first")
    active_bone: IntProperty(name="Bone", description="Choosing a bone selects it", update=_select_bone)
    mean_residual: FloatProperty(description="Mean distance between bones and target", default=-1.0)
    max_residual: FloatProperty(description="Largest distance between bones and target", default=-1.0)
    iterations: IntProperty(description="Steps of the run")
    seconds: FloatProperty(description="How long the run took")
    joints: CollectionProperty(type=MOULAGE_PG_joint_result, description="Those at their limits first")
    active_joint: IntProperty(name="Joint", description="Joints at their limits come first")
    share: FloatProperty(
        name="Template to Person", subtype="FACTOR", min=0.0, max=1.0, default=1.0, update=_show_share,
        description="0: the bones as the template has them, 1: as the person has them",
    )


class MOULAGE_PG_skeleton(bpy.types.PropertyGroup):
    """A skeleton: what it is registered to, and what came out."""

    uid: StringProperty(description="Stays the same when the object is renamed")
    loops: CollectionProperty(type=MOULAGE_PG_loop, description="Joints that close loops")
    carried: CollectionProperty(type=MOULAGE_PG_soft, description="Soft tissues that move along")
    active_carried: IntProperty(name="Soft tissue", description="The mesh that the button removes from the list")

    target_kind: EnumProperty(
        name="To", description="What shows where the person's bones are", items=[
            ("SURFACE", "Surface", "One surface of all the person's bones, which may be fused"),
            ("BONES", "Bones", "A collection with a surface per bone, named as the bone; other bones follow their joints"),
            ("LABELS", "Label map", "A segmentation of the person's bones"),
            ("IMAGE", "Image", "A CT or MRI near which the skeleton lies, by what the same kind of image shows around it"),
        ],
    )
    target: PointerProperty(
        name="Surface", description="The surface of all the person's bones", type=bpy.types.Object, poll=_is_mesh
    )
    target_bones: PointerProperty(
        name="Bones", description="The person's bones, named as the skeleton's", type=bpy.types.Collection
    )
    label_map: StringProperty(name="Label map", description="File of the segmentation", subtype="FILE_PATH")
    label: IntProperty(
        name="Label", description="The label of all bones together; 0: the only one, or each bone's own", min=0
    )
    image: StringProperty(name="Person", description="File of the person's image", subtype="FILE_PATH")
    reference: StringProperty(
        name="Template", description="File of an image of the same kind, in which the skeleton lies on the bones",
        subtype="FILE_PATH",
    )
    near: BoolProperty(
        name="Already in place", description="The skeleton lies near the person's bones: do not turn it"
    )
    as_is: BoolProperty(
        name="Meant as it is",
        description="Take the target even if it looks like a mirror image of the skeleton, or as if it were in another unit",
    )
    limits: EnumProperty(
        name="Limits",
        description="What the limits of the joints are",
        items=[
            ("soft", "Soft", "Where the data say so a joint turns up to 10 degrees further"),
            ("hard", "Hard", "No joint turns further"),
            ("none", "None", "Joints turn freely; the bones hang together all the same"),
        ],
    )
    max_iterations: IntProperty(name="Iterations", description="At most so many per level; 0: the usual number", min=0)
    live: BoolProperty(name="Live view", description="Show the bones while they are being found", default=True)
    keep: BoolProperty(
        name="Keep earlier results", description="Each run makes a person of its own instead of replacing the last"
    )

    person: PointerProperty(name="Person", description="The last result's armature", type=bpy.types.Object)
    result: PointerProperty(type=MOULAGE_PG_registration, description="What the run that made it said")
    pose: PointerProperty(description="The action that holds the pose of the scan", type=bpy.types.Action)
    motion: PointerProperty(description="The template's motion for this person", type=bpy.types.Action)


classes = (
    MOULAGE_PG_joint, MOULAGE_PG_loop, MOULAGE_PG_soft, MOULAGE_PG_joint_result, MOULAGE_PG_bone_verdict,
    MOULAGE_PG_registration, MOULAGE_PG_skeleton,
)


def register():
    bpy.types.Object.moulage_skeleton = PointerProperty(type=MOULAGE_PG_skeleton)
    bpy.types.PoseBone.moulage = PointerProperty(type=MOULAGE_PG_joint)


def unregister():
    del bpy.types.PoseBone.moulage
    del bpy.types.Object.moulage_skeleton


def skeleton_of(context):
    """The scene's skeleton, or None; also for one that was deleted but is still in the file."""
    ob = context.scene.moulage.skeleton
    return ob if ob is not None and ob.name in context.scene.objects else None
