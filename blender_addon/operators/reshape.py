# SPDX-License-Identifier: GPL-3.0-or-later
"""Reshape, and stop what is running."""

import bpy

from .. import landmarks, properties, runs, solve
from .base import NeedsTemplate, Runs


def _has_data(cls, template):
    data = template.moulage
    if landmarks.used(template) or data.attachments or data.markers or data.marker_empties:
        return True
    cls.poll_message_set("Add markers or landmarks of the person first")
    return False


class MOULAGE_OT_reshape(Runs, NeedsTemplate, bpy.types.Operator):
    """Put the template into the person's shape. Blender stays free meanwhile; Stop, or Esc over a 3D view,
    keeps the best shape so far"""

    bl_idname = "moulage.reshape"
    bl_label = "Reshape"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and _has_data(cls, properties.template_of(context))

    def begin(self, context):
        return solve.Solve(context, properties.template_of(context))


class MOULAGE_OT_stop(bpy.types.Operator):
    """Stop the run and keep the best so far"""

    bl_idname = "moulage.stop"
    bl_label = "Stop"

    @classmethod
    def poll(cls, context):
        return runs.is_running()

    def execute(self, _context):
        runs.stop_all()
        return {"FINISHED"}


classes = (MOULAGE_OT_reshape, MOULAGE_OT_stop)
