# SPDX-License-Identifier: GPL-3.0-or-later
"""Reshape, and stop what is running."""

import bpy

from .. import landmarks, preflight, properties, runs, solve
from ..library import Wrong
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

    anyway: bpy.props.BoolProperty(
        name="Meant as it is", description="Reshape also where the result would probably be nonsense",
        options={"SKIP_SAVE"},
    )

    _looked = False

    @classmethod
    def poll(cls, context):
        return super().poll(context) and _has_data(cls, properties.template_of(context))

    def invoke(self, context, event):
        if bpy.app.background:
            return super().invoke(context, event)
        template = properties.template_of(context)
        preflight.look(context, template)
        self._looked = True
        if preflight.serious(template) and not self.anyway:
            bpy.ops.moulage.reshape_anyway("INVOKE_DEFAULT")
            return {"CANCELLED"}
        return super().invoke(context, event)

    def begin(self, context):
        template = properties.template_of(context)
        if not self._looked:
            preflight.look(context, template)
        serious = preflight.serious(template)
        if serious and not self.anyway:
            raise Wrong(serious[0].text)
        return solve.Solve(context, template)


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
