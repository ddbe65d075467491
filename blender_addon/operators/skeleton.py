# SPDX-License-Identifier: GPL-3.0-or-later
"""Skeletons: files in and out, soft tissues, registration, motions."""

import bpy
from bpy_extras.io_utils import ExportHelper

from .. import person, registering, rig, skeleton_files, skeleton_properties, views
from ..library import Wrong
from .base import DropsIntoView, Imports, Runs, poll_object_mode, tells
from .files import SCALE


class _NeedsSkeleton:
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if skeleton_properties.skeleton_of(context) is None:
            cls.poll_message_set("Pick a skeleton first")
            return False
        return poll_object_mode(cls, context.mode)


class MOULAGE_OT_import_skeleton(Imports, bpy.types.Operator):
    """Read a skeleton: an armature with joint limits, and a mesh on each bone"""

    bl_idname = "moulage.import_skeleton"
    bl_label = "Import Skeleton"

    filter_glob: bpy.props.StringProperty(default="*.json;*.osim", options={"HIDDEN"})
    scale: SCALE

    @classmethod
    def poll(cls, context):
        return poll_object_mode(cls, context.mode)

    @tells
    def execute(self, context):
        count, said = 0, []
        for path in self.paths():
            armature, notes = skeleton_files.load(context, path, self.scale)
            context.scene.moulage.skeleton = armature
            count += len(armature.data.bones)
            said += notes
        self.report({"INFO"}, " ".join([f"{count} bones read.", *said]))
        return {"FINISHED"}


class MOULAGE_OT_export_skeleton(_NeedsSkeleton, bpy.types.Operator, ExportHelper):
    """Write the skeleton: .skeleton.json with the bones beside it, or a .glb scene"""

    bl_idname = "moulage.export_skeleton"
    bl_label = "Export Skeleton"
    bl_options = {"REGISTER"}

    check_extension = None
    filename_ext = ".skeleton.json"
    person: bpy.props.BoolProperty(name="Person", description="Write the person's skeleton instead of the template")
    scale: SCALE

    def invoke(self, context, event):
        if not self.filepath:
            self.filepath = f"{skeleton_properties.skeleton_of(context).name}.skeleton.json"
        return ExportHelper.invoke(self, context, event)

    @tells
    def execute(self, context):
        armature = skeleton_properties.skeleton_of(context)
        if self.person:
            armature = armature.moulage_skeleton.person
            if armature is None:
                raise Wrong("There is no person yet: register first.")
        count = skeleton_files.save(context, armature, self.filepath, self.scale)
        self.report({"INFO"}, f"{count} bones written to {self.filepath}.")
        return {"FINISHED"}


class MOULAGE_OT_add_soft_tissue(_NeedsSkeleton, bpy.types.Operator):
    """Carry the selected meshes along with the bones: muscles, skin"""

    bl_idname = "moulage.add_soft_tissue"
    bl_label = "Carry Selected"

    @tells
    def execute(self, context):
        armature = skeleton_properties.skeleton_of(context)
        data = armature.moulage_skeleton
        there = {item.object for item in data.carried} | {data.target}
        others = [
            ob for ob in context.selected_objects
            if ob.type == "MESH" and ob not in there and not (ob.parent == armature and ob.parent_type == "BONE")
        ]
        if not others:
            raise Wrong("Select the muscles or the skin that are to move with the bones.")
        for ob in others:
            data.carried.add().object = ob
        data.active_carried = len(data.carried) - 1
        return {"FINISHED"}


class MOULAGE_OT_remove_soft_tissue(_NeedsSkeleton, bpy.types.Operator):
    """Carry this mesh no longer"""

    bl_idname = "moulage.remove_soft_tissue"
    bl_label = "Remove Soft Tissue"

    def execute(self, context):
        data = skeleton_properties.skeleton_of(context).moulage_skeleton
        data.carried.remove(data.active_carried)
        data.active_carried = max(0, data.active_carried - 1)
        return {"FINISHED"}


class MOULAGE_OT_register(Runs, _NeedsSkeleton, bpy.types.Operator):
    """Put the skeleton on the person's bones, its joints inside their limits. The person becomes an armature of its
    own; Blender stays free meanwhile; Stop, or Esc over a 3D view, keeps the best so far"""

    bl_idname = "moulage.register"
    bl_label = "Register"

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        missing = registering.missing(skeleton_properties.skeleton_of(context))
        if missing:
            cls.poll_message_set(missing)
        return not missing

    def begin(self, context):
        return registering.Registering(context, skeleton_properties.skeleton_of(context))


class MOULAGE_OT_show_action(_NeedsSkeleton, bpy.types.Operator):
    """Show the person in the pose of the scan, or moving as the template moves"""

    bl_idname = "moulage.show_action"
    bl_label = "Show Pose or Motion"

    kind: bpy.props.EnumProperty(
        name="Show", description="What moves the person's armature", items=[
            ("POSE", "Pose of the Scan", "As the bones lie in the scan"), ("MOTION", "Motion", "The template's action"),
        ],
    )

    @tells
    def execute(self, context):
        armature = skeleton_properties.skeleton_of(context)
        own = armature.moulage_skeleton.person or armature
        data = own.moulage_skeleton
        if data.motion is None:
            raise Wrong("The template had no action when it was registered.")
        rig.assign(own, data.pose if self.kind == "POSE" else data.motion)
        context.view_layer.update()
        return {"FINISHED"}


class MOULAGE_OT_show_part(_NeedsSkeleton, bpy.types.Operator):
    """Show or hide it"""

    bl_idname = "moulage.show_part"
    bl_label = "Show or Hide"

    part: bpy.props.EnumProperty(
        name="Part", description="What is shown or hidden", items=[
            ("TEMPLATE", "Template", "The skeleton that was registered"),
            ("TARGET", "Target", "The surface or the bones that it was registered to"),
            ("PERSON", "Person", "The result"),
        ],
    )

    def execute(self, context):
        objects = person.parts(skeleton_properties.skeleton_of(context), self.part)
        views.show(context, objects, not any(ob.visible_get() for ob in objects))
        return {"FINISHED"}


classes = (
    MOULAGE_OT_import_skeleton, MOULAGE_OT_export_skeleton, MOULAGE_OT_add_soft_tissue,
    MOULAGE_OT_remove_soft_tissue, MOULAGE_OT_register, MOULAGE_OT_show_action, MOULAGE_OT_show_part,
)

if bpy.app.version >= (4, 1, 0):

    class MOULAGE_FH_skeleton(DropsIntoView, bpy.types.FileHandler):
        """Skeleton files can be dropped into the 3D view."""

        bl_idname = "MOULAGE_FH_skeleton"
        bl_label = "Moulage skeleton"
        bl_import_operator = "moulage.import_skeleton"
        bl_file_extensions = ".json;.osim"

    classes += (MOULAGE_FH_skeleton,)
