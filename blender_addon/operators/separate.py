# SPDX-License-Identifier: GPL-3.0-or-later
"""Separate: meshes that overlap are pushed apart."""

import bpy

from .. import separating
from .base import Runs, poll_object_mode


class MOULAGE_OT_separate(Runs, bpy.types.Operator):
    """Push the selected meshes apart where they overlap each other or what stays. Only what is near an overlap moves.
    Blender stays free meanwhile; Stop, or Esc over a 3D view, keeps the shapes with the least overlap"""

    bl_idname = "moulage.separate"
    bl_label = "Separate"

    @classmethod
    def poll(cls, context):
        return poll_object_mode(cls, context.mode)

    def begin(self, context):
        return separating.Separating(context)


classes = (MOULAGE_OT_separate,)
