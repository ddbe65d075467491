# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels for skeletons."""

import math

import bpy

from . import once, person, registering, runs, skeleton, skeleton_properties, units
from .library import Wrong
from .panels import Panel, draw_run, field, write


class MOULAGE_PT_skeleton(Panel, bpy.types.Panel):
    bl_label = "Skeleton"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        column = layout.column()
        column.enabled = not runs.is_running()
        column.prop(context.scene.moulage, "skeleton", text="", icon="ARMATURE_DATA")
        row = column.row(align=True)
        row.operator("moulage.import_skeleton", text="Import", icon="IMPORT")
        row.operator("moulage.export_skeleton", text="Export", icon="EXPORT")
        armature = skeleton_properties.skeleton_of(context)
        if armature is None:
            write(layout, context, "Pick an armature whose bones carry meshes, or import a skeleton.", "INFO")
            return
        self._count(context, layout, armature)
        _draw_carried(layout, armature)

    def _count(self, context, layout, armature):
        counted, remark = once.found("bones", armature.name, lambda: _counted(armature))
        if counted:
            layout.label(text=counted)
        if remark:
            write(layout, context, remark, "INFO" if counted else "ERROR")


def _counted(armature):
    """How many bones and joints there are, and a remark; nothing and what is wrong where that cannot be said."""
    try:
        carrying = skeleton.meshes(armature)
    except Wrong as wrong:
        return "", str(wrong)
    bones = [armature.data.bones[name] for name in carrying]
    joints = [b for b in bones if skeleton.ancestor(b, carrying) is not None]
    free = sum(1 for b in joints if _is_free(armature.pose.bones[b.name]))
    remark = f"{free} joints without limits: give them a Limit Rotation constraint (local)." if free else ""
    return f"{len(bones)} bones, {len(joints) + len(armature.moulage_skeleton.loops)} joints", remark


def _is_free(pose):
    return all(math.isinf(v) for side in skeleton.limits(pose) for v in side)


def _draw_carried(layout, armature):
    data = armature.moulage_skeleton
    if data.carried:
        row = layout.row()
        row.template_list("MOULAGE_UL_carried", "soft", data, "carried", data, "active_carried", rows=2)
        row.operator("moulage.remove_soft_tissue", text="", icon="REMOVE")
    layout.operator("moulage.add_soft_tissue", icon="ADD")


class _NeedsSkeleton(Panel):
    bl_parent_id = "MOULAGE_PT_skeleton"

    @classmethod
    def poll(cls, context):
        return skeleton_properties.skeleton_of(context) is not None


class MOULAGE_PT_register(_NeedsSkeleton, bpy.types.Panel):
    bl_label = "Register"

    def draw(self, context):
        layout = self.layout
        if runs.is_running():
            draw_run(context, layout)
            return
        armature = skeleton_properties.skeleton_of(context)
        data = armature.moulage_skeleton
        field(layout, data, "target_kind")
        names = {
            "SURFACE": ("target",), "BONES": ("target_bones",), "LABELS": ("label_map", "label"),
            "IMAGE": ("image", "reference"),
        }
        for name in names[data.target_kind]:
            if name == "label":
                layout.prop(data, name)
            else:
                field(layout, data, name)
        settings = layout.column()
        if data.target_kind != "IMAGE":
            settings.prop(data, "near")
            settings.prop(data, "as_is")
        field(settings, data, "limits")
        settings.prop(data, "live")
        settings.prop(data, "keep")
        missing = registering.missing(armature)
        if missing:
            write(layout, context, missing + ".", "INFO")
        row = layout.row()
        row.scale_y = 1.5
        row.operator("moulage.register", icon="PLAY")


class MOULAGE_UL_joints(bpy.types.UIList):
    def draw_item(self, _context, layout, _data, item, _icon, _active, _property):
        at_limit = item.usage >= person.AT_LIMIT
        # The share of the limits would leave no room for the name; the line below the list has it.
        layout.label(text=item.name, icon="ERROR" if at_limit else "NONE")


_VERDICT_ICONS = {"good": "CHECKMARK", "doubtful": "QUESTION", "failed": "CANCEL"}


class MOULAGE_UL_bones(bpy.types.UIList):
    def draw_item(self, _context, layout, _data, item, _icon, _active, _property):
        layout.label(text=item.name, icon=_VERDICT_ICONS[item.verdict])


class MOULAGE_PT_person(_NeedsSkeleton, bpy.types.Panel):
    bl_label = "Person"

    def draw(self, context):
        layout = self.layout
        armature = skeleton_properties.skeleton_of(context)
        own = armature.moulage_skeleton.person or armature
        kept = own.moulage_skeleton.result
        if not kept.ending:
            write(layout, context, "No person yet: register first.", "INFO")
            return
        write(layout, context, kept.ending)
        column = layout.column(align=True)
        column.scale_y = 0.8
        mean, largest = units.texts(context.scene, kept.mean_residual, kept.max_residual)
        column.label(text=f"Bones: mean {mean},")
        column.label(text=f"largest {largest}")
        column.label(text=f"{kept.iterations} step{'s' if kept.iterations != 1 else ''}, {kept.seconds:.0f} s")
        if kept.warnings:
            write(layout, context, kept.warnings, "ERROR")
        self._share(context, layout, armature, own)
        self._bones(context, layout, kept)
        tight = len(person.at_limit(kept))
        layout.label(text=f"Joints: {tight} at {'their' if tight != 1 else 'its'} limit" + ("s" if tight != 1 else ""))
        layout.template_list("MOULAGE_UL_joints", "", kept, "joints", kept, "active_joint", rows=4)
        if kept.active_joint < len(kept.joints):
            joint = kept.joints[kept.active_joint]
            turned, share = f"turned by {math.degrees(joint.rotation):.0f}°", f"{100 * joint.usage:.0f} % of its limits"
            beyond = f", {math.degrees(joint.excess):.0f}° beyond them" if joint.excess > 0.01 else ""
            write(layout, context, f"{joint.name}: {turned}, {share}{beyond}")
        if own.moulage_skeleton.motion is not None:
            row = layout.row(align=True)
            shown = own.animation_data.action if own.animation_data else None
            for kind, action in (("POSE", own.moulage_skeleton.pose), ("MOTION", own.moulage_skeleton.motion)):
                name = "Pose of the Scan" if kind == "POSE" else "Motion"
                row.operator("moulage.show_action", text=name, depress=shown == action).kind = kind


    def _share(self, context, layout, armature, own):
        """The slider, and what is shown beside it."""
        data = own.moulage_skeleton
        row = layout.row()
        row.enabled = data.motion is None or own.animation_data.action != data.motion
        row.prop(data.result, "share", slider=True)
        row = layout.row(align=True)
        for which, shown in once.found("parts", armature.name, lambda: _parts(armature)):
            row.operator("moulage.show_part", text=which.capitalize(), depress=shown).part = which

    def _bones(self, context, layout, kept):
        doubtful = sum(row.verdict != "good" for row in kept.bones)
        layout.label(text=f"Bones in doubt: {doubtful} of {len(kept.bones)}")
        layout.template_list("MOULAGE_UL_bones", "", kept, "bones", kept, "active_bone", rows=3)
        if kept.active_bone < len(kept.bones):
            chosen = kept.bones[kept.active_bone]
            off = units.text(context.scene, chosen.mean_residual)
            write(layout, context, f"{chosen.name} is {chosen.verdict}, {off} off on average.\n{chosen.reasons}")


def _parts(armature):
    """What there is to look at, and whether it is shown."""
    found = ((which, person.parts(armature, which)) for which in ("TEMPLATE", "TARGET", "PERSON"))
    return [(which, there[0].visible_get()) for which, there in found if there]


class MOULAGE_PT_joint(bpy.types.Panel):
    bl_label = "Moulage"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "bone"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.active_pose_bone is not None

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        for name in ("joint", "shift", "label"):
            column.prop(context.active_pose_bone.moulage, name)


classes = (
    MOULAGE_UL_joints, MOULAGE_UL_bones, MOULAGE_PT_skeleton, MOULAGE_PT_register, MOULAGE_PT_person, MOULAGE_PT_joint,
)
