# SPDX-License-Identifier: GPL-3.0-or-later
"""Landmarks: add, remove, mirror names, place the template by them."""

import bpy
import mathutils
import numpy

from .. import landmarks, markers, preflight, problem, properties, units
from ..library import Wrong, calls
from .base import NeedsTemplate, tells


class MOULAGE_OT_add_landmark(NeedsTemplate, bpy.types.Operator):
    """Add a landmark from two world positions; for scripts (in the 3D view, use Click Pairs)"""

    bl_idname = "moulage.add_landmark"
    bl_label = "Add Landmark"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    name: bpy.props.StringProperty(name="Name", description="Empty: the next number")
    template_point: bpy.props.FloatVectorProperty(
        name="On the template", description="World position on the template at rest", subtype="XYZ"
    )
    target: bpy.props.FloatVectorProperty(name="On the person", description="World position", subtype="XYZ")

    def execute(self, context):
        landmarks.add(context, properties.template_of(context), self.name, self.template_point, self.target)
        return {"FINISHED"}


class MOULAGE_OT_remove_landmark(NeedsTemplate, bpy.types.Operator):
    """Remove the landmark and its two empties"""

    bl_idname = "moulage.remove_landmark"
    bl_label = "Remove Landmark"

    all: bpy.props.BoolProperty(name="All", description="Remove all landmarks")

    @classmethod
    def poll(cls, context):
        return super().poll(context) and len(properties.template_of(context).moulage.landmarks) > 0

    def execute(self, context):
        template = properties.template_of(context)
        data = template.moulage
        for index in reversed(range(len(data.landmarks))) if self.all else [data.active_landmark]:
            if index < len(data.landmarks):
                landmarks.remove(template, index)
        return {"FINISHED"}


class MOULAGE_OT_mirror_landmarks(NeedsTemplate, bpy.types.Operator):
    """Make the partners of landmarks that are named with a side, such as hip.L, on the template's other side; then
    click their places on the person"""

    bl_idname = "moulage.mirror_landmarks"
    bl_label = "Mirror Names (.L / .R)"

    @tells
    def execute(self, context):
        template = properties.template_of(context)
        context.view_layer.update()
        inputs = problem.gather_shape(context, template)
        with calls() as library:
            made = landmarks.mirror(context, template, library.TriMesh(inputs.points, inputs.triangles))
        if not made:
            raise Wrong("No landmark waits for its partner: name them with a side, such as hip.L.")
        self.report({"INFO"}, f"Made {', '.join(made)}.")
        return {"FINISHED"}


class MOULAGE_OT_place_template(NeedsTemplate, bpy.types.Operator):
    """Turn and move the template to where the person is: by three or more landmarks, else by the markers"""

    bl_idname = "moulage.place_template"
    bl_label = "Place Template"

    scale: bpy.props.BoolProperty(name="Change the size", description="Scale the template as well")

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        template = properties.template_of(context)
        data = template.moulage
        if data.markers is None and data.marker_empties is None and len(landmarks.used(template)) < 3:
            cls.poll_message_set("Add markers, or click three landmark pairs, first")
            return False
        return True

    @tells
    def execute(self, context):
        template = properties.template_of(context)
        inputs = problem.gather_shape(context, template)
        points, targets, _weights = landmarks.pairs(template)
        freedom = "similarity" if self.scale else "rigid"
        with calls() as library:
            surface = library.TriMesh(inputs.points, inputs.triangles)
            motion = surface.align(markers.points(template), points, targets, freedom)
        template.matrix_world = mathutils.Matrix(motion.tolist()) @ template.matrix_world
        context.view_layer.update()
        preflight.look(context, template)
        gaps = numpy.linalg.norm(landmarks.pairs(template)[0] - targets, axis=1)
        off = f" The landmarks are {units.text(context.scene, gaps.mean())} off on average." if len(gaps) else ""
        self.report({"INFO"}, f"The template was placed.{off}")
        return {"FINISHED"}


classes = (MOULAGE_OT_add_landmark, MOULAGE_OT_remove_landmark, MOULAGE_OT_mirror_landmarks, MOULAGE_OT_place_template)
