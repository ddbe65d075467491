# SPDX-License-Identifier: GPL-3.0-or-later
"""Reshape: in a window without blocking it, in a script from start to end."""

import time

import bpy

from .. import landmarks, properties, solve, units
from ..library import Wrong
from .template import fail, poll_template

_INTERVAL = 0.1


def _has_data(cls, template):
    data = template.moulage
    if landmarks.used(template) or data.attachments or data.markers or data.marker_empties:
        return True
    cls.poll_message_set("Add markers or landmarks of the person first")
    return False


def publish(context, current):
    """Copies where a run stands to where the panels read it."""
    state, progress = context.window_manager.moulage, current.progress
    if progress is None:
        state.fraction, state.stage, state.details = 0.0, "Filling with tets", ""
        return
    state.fraction, state.stage = progress.fraction, progress.stage.capitalize()
    state.details = ""
    if progress.mean_error == progress.mean_error:
        mean, largest = (units.text(context.scene, e) for e in (progress.mean_error, progress.max_error))
        state.details = f"Step {progress.iteration}: mean {mean}, largest {largest}"


def redraw(context):
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


class MOULAGE_OT_reshape(bpy.types.Operator):
    """Put the template into the person's shape. Blender stays free meanwhile; Stop, or Esc over a 3D view,
    keeps the best shape so far"""

    bl_idname = "moulage.reshape"
    bl_label = "Reshape"
    bl_options = {"REGISTER", "UNDO"}

    _timer = None
    _solve = None

    @classmethod
    def poll(cls, context):
        return poll_template(cls, context) and _has_data(cls, properties.template_of(context))

    def execute(self, context):
        try:
            current = solve.Solve(context, properties.template_of(context))
        except Wrong as error:
            return fail(self, error)
        try:
            while current.tick():
                time.sleep(0.02)
            self.report({"INFO"}, current.finish(context))
        except Wrong as error:
            return fail(self, error)
        finally:
            current.close()
        return {"FINISHED"}

    def invoke(self, context, _event):
        if bpy.app.background:
            return self.execute(context)
        try:
            self._solve = solve.Solve(context, properties.template_of(context))
        except Wrong as error:
            return fail(self, error)
        self._timer = context.window_manager.event_timer_add(_INTERVAL, window=context.window)
        context.window_manager.modal_handler_add(self)
        publish(context, self._solve)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        current = self._solve
        if current.closed:
            # The add-on was disabled, or another file is opened.
            return self._end(context, {"CANCELLED"})
        if event.type == "ESC" and event.value == "PRESS" and _over_3d_view(context, event):
            current.stop()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if current.tick():
            current.show()
            publish(context, current)
            redraw(context)
            return {"PASS_THROUGH"}
        if current.waits_for_object_mode:
            context.window_manager.moulage.stage = "Leave Edit Mode to receive the result"
            redraw(context)
            return {"PASS_THROUGH"}
        try:
            self.report({"INFO"}, current.finish(context))
        except Wrong as error:
            self.report({"WARNING"}, str(error))
            return self._end(context, {"CANCELLED"})
        return self._end(context, {"FINISHED"})

    def cancel(self, context):
        # Another file is opened, or Blender is closed.
        self._solve.close()
        self._end(context, {"CANCELLED"})

    def _end(self, context, how):
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        redraw(context)
        return how


def _over_3d_view(context, event):
    return any(
        area.type == "VIEW_3D"
        and area.x <= event.mouse_x < area.x + area.width
        and area.y <= event.mouse_y < area.y + area.height
        for area in context.window.screen.areas
    )


class MOULAGE_OT_stop(bpy.types.Operator):
    """Stop the run and keep the best shape so far"""

    bl_idname = "moulage.stop"
    bl_label = "Stop"

    @classmethod
    def poll(cls, context):
        return solve.is_running()

    def execute(self, _context):
        solve.stop_all()
        return {"FINISHED"}


classes = (MOULAGE_OT_reshape, MOULAGE_OT_stop)
