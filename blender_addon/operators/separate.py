# SPDX-License-Identifier: GPL-3.0-or-later
"""Separate: meshes that overlap are pushed apart."""

import bpy

from .. import separating
from .base import Runs, poll_idle


class MOULAGE_OT_separate(Runs, bpy.types.Operator):
    """Push the selected meshes apart where they overlap each other or what stays. Only what is near an overlap moves.
    Blender stays free meanwhile; Stop, or Esc over a 3D view, keeps the shapes with the least overlap"""

    bl_idname = "moulage.separate"
    bl_label = "Separate"

    @classmethod
    def poll(cls, context):
        if not poll_idle(cls):
            return False
        if context.mode != "OBJECT":
            cls.poll_message_set("Go back to Object Mode")
            return False
        return True

    def begin(self, context):
        return separating.Separating(context)


classes = (MOULAGE_OT_separate,)
