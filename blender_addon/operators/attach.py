# SPDX-License-Identifier: GPL-3.0-or-later
"""Lists on the template: attachments to bones, and meshes that are carried along."""

import bpy

from .. import properties
from ..library import Wrong
from .base import NeedsTemplate, tells


class MOULAGE_OT_add_attachment(NeedsTemplate, bpy.types.Operator):
    """Attach the template to a bone; the selected mesh beside the template is taken, if there is one"""

    bl_idname = "moulage.add_attachment"
    bl_label = "Add Attachment"

    def execute(self, context):
        template = properties.template_of(context)
        data = template.moulage
        item = data.attachments.add()
        others = [ob for ob in context.selected_objects if ob.type == "MESH" and ob != template]
        item.bone = others[0] if others else None
        item.name = item.bone.name if item.bone else "Bone"
        data.active_attachment = len(data.attachments) - 1
        return {"FINISHED"}


class MOULAGE_OT_remove_attachment(NeedsTemplate, bpy.types.Operator):
    """Remove the attachment; the bone stays"""

    bl_idname = "moulage.remove_attachment"
    bl_label = "Remove Attachment"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and len(properties.template_of(context).moulage.attachments) > 0

    def execute(self, context):
        data = properties.template_of(context).moulage
        data.attachments.remove(data.active_attachment)
        data.active_attachment = max(0, data.active_attachment - 1)
        return {"FINISHED"}


class MOULAGE_OT_add_carried(NeedsTemplate, bpy.types.Operator):
    """Carry the selected meshes along with the template: vessels inside, a finer version of it"""

    bl_idname = "moulage.add_carried"
    bl_label = "Carry Selected"

    @tells
    def execute(self, context):
        template = properties.template_of(context)
        data = template.moulage
        there = {item.object for item in data.carried} | {template, data.markers}
        others = [ob for ob in context.selected_objects if ob.type == "MESH" and ob not in there]
        if not others:
            raise Wrong("Select the meshes that are to move with the template.")
        for ob in others:
            data.carried.add().object = ob
        data.active_carried = len(data.carried) - 1
        return {"FINISHED"}


class MOULAGE_OT_remove_carried(NeedsTemplate, bpy.types.Operator):
    """Carry this mesh no longer; it keeps the shape it has"""

    bl_idname = "moulage.remove_carried"
    bl_label = "Remove Carried Mesh"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and len(properties.template_of(context).moulage.carried) > 0

    def execute(self, context):
        data = properties.template_of(context).moulage
        data.carried.remove(data.active_carried)
        data.active_carried = max(0, data.active_carried - 1)
        return {"FINISHED"}


classes = (
    MOULAGE_OT_add_attachment, MOULAGE_OT_remove_attachment, MOULAGE_OT_add_carried, MOULAGE_OT_remove_carried,
)
