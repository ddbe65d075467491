# SPDX-License-Identifier: GPL-3.0-or-later
"""Live editing: while it is on, the shape follows landmarks, markers and attachments as they are moved. Each time
the run starts from the result before, which takes a fraction of a whole one."""

import bpy

from . import landmarks, markers, mesh_data, runs, solve, views
from .library import Wrong

# Seconds between two looks at the scene.
_INTERVAL = 0.15

# The run that is going on, and what the last one was made from.
_state = {"run": None, "stamp": None}


def changed(data, context):
    """For the toggle: begins to look; it stops by itself. The result that is there counts as made from what is
    there now, so that a move that follows at once is seen."""
    template = context.scene.moulage.template
    _state["stamp"] = _stamp(template) if data.live_edit and template is not None else None
    if data.live_edit and not bpy.app.background and not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=_INTERVAL)


def _tick():
    return _INTERVAL if step(bpy.context) else None


def step(context):
    """Goes on with the run, or starts one if something was moved. False: live editing is off."""
    template = context.scene.moulage.template
    if template is not None and template.name not in context.scene.objects:
        template = None
    current = _state["run"]
    if current is not None and current.closed:
        current = _state["run"] = None
    if template is None or not context.window_manager.moulage.live_edit:
        if current is not None:
            current.abandon()
            _state["run"] = None
        return False
    if current is not None:
        _go_on(context, template, current)
    elif not runs.is_running() and template.mode == "OBJECT" and solve.can_go_on(template):
        _start(context, template)
    return True


def _start(context, template):
    stamp = _stamp(template)
    if _state["stamp"] is None:
        # The result that is there was made from what is there.
        _state["stamp"] = stamp
    if stamp == _state["stamp"]:
        return
    _state["stamp"] = stamp
    try:
        _state["run"] = solve.Solve(context, template, again=True)
    except Wrong as wrong:
        template.moulage.result.ending = str(wrong)


def _go_on(context, template, current):
    if current.tick():
        return
    _state["run"] = None
    if current.waits_for_object_mode:
        current.close()
        return
    try:
        current.finish(context)
    except Wrong as wrong:
        template.moulage.result.ending = str(wrong)
    for _window, area, _space in views.spaces(context):
        area.tag_redraw()


def _stamp(template):
    """Where everything is that the shape follows."""
    arrays = [*landmarks.pairs(template), markers.points(template)]
    bones = [ob for a in template.moulage.attachments for ob in (a.bone, a.target) if ob is not None]
    arrays += [mesh_data.matrix(ob) for ob in (template, *bones)]
    return hash(tuple(a.tobytes() for a in arrays))


def shut_down():
    _state.update(run=None, stamp=None)
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
