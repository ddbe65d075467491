# SPDX-License-Identifier: GPL-3.0-or-later
"""Reshape, and stop what is running."""

import bpy

from .. import landmarks, preflight, properties, runs, solve, units
from ..library import Wrong
from .base import NeedsTemplate, Runs


# How exact points usually are, in millimetres: about half a voxel of such an image, or a scanner's noise.
_SOURCES = {
    "BONE": ("CT, Bone", "Points on a bone in slices of a CT", 0.3),
    "ORGAN": ("CT, Organ", "Points on an organ's soft border in slices of a CT", 0.8),
    "MRI": ("MRI", "Points on slices of an MRI", 1.0),
    "LASER": ("Laser Scan", "Points of a surface scan", 0.1),
}


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


class MOULAGE_OT_tolerance_preset(NeedsTemplate, bpy.types.Operator):
    """Set the tolerances to what is usual for points of this origin"""

    bl_idname = "moulage.tolerance_preset"
    bl_label = "Tolerance"

    source: bpy.props.EnumProperty(
        name="Points from", description="Where the person's points come from", items=[
            (key, name, f"{description}: {size} mm") for key, (name, description, size) in _SOURCES.items()
        ],
    )

    def execute(self, context):
        data = properties.template_of(context).moulage
        _name, _description, size = _SOURCES[self.source]
        data.tolerance = size / units.millimetres(context.scene, 1.0)
        data.landmark_tolerance = 0.0
        return {"FINISHED"}


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


classes = (MOULAGE_OT_reshape, MOULAGE_OT_tolerance_preset, MOULAGE_OT_stop)
