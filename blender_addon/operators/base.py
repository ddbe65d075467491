# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators share: when they can run, how they tell what is wrong, runs that leave Blender free."""

import functools
import time
from pathlib import Path

import bpy
from bpy_extras.io_utils import ImportHelper

from .. import properties, runs, units, views
from ..library import Wrong

_INTERVAL = 0.1


def poll_idle(cls):
    """For `poll`: no run is going on."""
    if runs.is_running():
        cls.poll_message_set("A run is going on: stop it or wait for its end")
        return False
    return True


def poll_object_mode(cls, mode):
    """For `poll`: the scene's or an object's mode says that nothing is edited, and no run is going on."""
    if not poll_idle(cls):
        return False
    if mode != "OBJECT":
        cls.poll_message_set("Go back to Object Mode")
        return False
    return True


def poll_template(cls, context):
    """For `poll`: there is a template, in Object Mode, and no run is going on."""
    template = properties.template_of(context)
    if template is None:
        cls.poll_message_set("Pick a template first")
        return False
    return poll_object_mode(cls, template.mode)


class NeedsTemplate:
    """For operators that change the template's data in one step of undo."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return poll_template(cls, context)


def tells(execute):
    """Lets an operator tell in one sentence what the user has to put right."""

    @functools.wraps(execute)
    def wrapped(self, context):
        try:
            return execute(self, context)
        except Wrong as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}

    return wrapped


class Imports(ImportHelper):
    """For operators that read files: chosen in the file browser, or dropped into the 3D view, which tells their folder
    and names."""

    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ""
    files: bpy.props.CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    directory: bpy.props.StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context, event):
        return self.execute(context) if self._dropped() else ImportHelper.invoke(self, context, event)

    def paths(self):
        return self._dropped() or [Path(self.filepath)]

    def _dropped(self):
        return [Path(self.directory) / f.name for f in self.files if f.name]


class DropsIntoView:
    """For file handlers (Blender 4.1 and newer)."""

    @classmethod
    def poll_drop(cls, context):
        return context.area is not None and context.area.type == "VIEW_3D"


def publish(context, current):
    """Copies where a run stands to where the panels read it."""
    state, progress = context.window_manager.moulage, current.progress
    if progress is None:
        state.fraction, state.stage, state.details = 0.0, "Filling with tets", ""
        return
    state.fraction, state.stage = progress.fraction, progress.stage.capitalize()
    state.details = ""
    if progress.mean_error == progress.mean_error:
        errors = (progress.mean_error, progress.max_error)
        words = units.texts(context.scene, *(e * current.unit for e in errors if e == e))
        names = ("mean", "largest")
        state.details = f"Step {progress.iteration}: " + ", ".join(f"{n} {w}" for n, w in zip(names, words))


def redraw(context, view=True):
    """All of each 3D view, or its side bar alone: a heavy scene is not drawn again for each number."""
    for _window, area, _space in views.spaces(context):
        for region in area.regions:
            if view or region.type == "UI":
                region.tag_redraw()


class Runs:
    """An operator that starts a run: in a window without blocking it, in a script from start to end.
    Subclasses have `begin(context)`, which makes the run."""

    bl_options = {"REGISTER", "UNDO"}

    _timer = None
    _current = None

    @tells
    def execute(self, context):
        current = self.begin(context)
        try:
            while current.tick():
                time.sleep(0.02)
            said = current.finish(context)
            self.report({current.severity}, said)
        finally:
            current.close()
        return {"FINISHED"}

    def invoke(self, context, _event):
        if bpy.app.background:
            return self.execute(context)
        return self._go(context)

    @tells
    def _go(self, context):
        self._current = self.begin(context)
        self._timer = context.window_manager.event_timer_add(_INTERVAL, window=context.window)
        context.window_manager.modal_handler_add(self)
        publish(context, self._current)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        current = self._current
        if current.closed:
            # The add-on was disabled, or another file is opened.
            return self._end(context, {"CANCELLED"})
        if event.type == "ESC" and event.value == "PRESS" and _over_3d_view(context, event):
            current.stop()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if current.tick():
            shown = current.show()
            publish(context, current)
            redraw(context, view=shown)
            return {"PASS_THROUGH"}
        if current.waits_for_object_mode:
            context.window_manager.moulage.stage = "Leave Edit Mode to receive the result"
            redraw(context)
            return {"PASS_THROUGH"}
        try:
            said = current.finish(context)
            self.report({current.severity}, said)
        except Wrong as error:
            self.report({"WARNING"}, str(error))
            return self._end(context, {"CANCELLED"})
        return self._end(context, {"FINISHED"})

    def cancel(self, context):
        # Another file is opened, or Blender is closed.
        self._current.close()
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
