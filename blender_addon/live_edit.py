# SPDX-License-Identifier: GPL-3.0-or-later
"""Live editing: while it is on, the shape follows landmarks, markers and attachments as they are moved. Each time
the run starts from the result before, which takes a fraction of a whole one."""

import bpy

from . import landmarks, markers, mesh_data, runs, solve, views
from .library import Wrong

# Seconds between two looks at the scene.
_INTERVAL = 0.15

# What is moved by less than this share of the template's size was not moved.
_MOVED = 1e-5

# The run that is going on, what the last one was made from, and where the landmarks' targets were.
_state = {"run": None, "stamp": None, "targets": {}}


def changed(data, context):
    """For the toggle: begins to look; it stops by itself. The result that is there counts as made from what is
    there now, so that a move that follows at once is seen."""
    template = context.scene.moulage.template
    on = data.live_edit and template is not None
    _state["stamp"] = _stamp(template) if on else None
    _state["targets"] = _targets(template) if on else {}
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
    elif not runs.is_running() and template.mode == "OBJECT":
        _start(context, template)
    return True


def _start(context, template):
    goes_on = solve.can_go_on(template)
    if not goes_on and not template.moulage.result.key:
        return
    _pin_what_was_moved(template)
    stamp = _stamp(template)
    if _state["stamp"] is None:
        # The result that is there was made from what is there.
        _state["stamp"] = stamp
    if stamp == _state["stamp"] and goes_on:
        return
    _state["stamp"] = stamp
    try:
        # A result that came with the file is found once more: what a run goes on from is not kept there.
        _state["run"] = solve.Solve(context, template, again=goes_on)
    except Wrong as wrong:
        _tell(context, template, wrong)


def _tell(context, template, wrong):
    """Says what went wrong; without a result to go on from there is nothing more to do."""
    template.moulage.result.ending = str(wrong)
    if not solve.can_go_on(template):
        context.window_manager.moulage.live_edit = False


def after_undo(context):
    """What undo has moved was not dragged."""
    template = context.scene.moulage.template
    if template is not None and context.window_manager.moulage.live_edit:
        context.view_layer.update()
        _state["targets"] = _targets(template)


def _targets(template):
    return {landmark.name: landmarks.position(landmark.target) for landmark in landmarks.used(template)}


def _pin_what_was_moved(template):
    """A hint that is dragged is meant: it becomes a pin that holds."""
    before, _state["targets"] = _state["targets"], _targets(template)
    least = _MOVED * max(template.dimensions)
    for landmark in landmarks.used(template):
        old = before.get(landmark.name)
        moved = old is not None and abs(_state["targets"][landmark.name] - old).max() > least
        if moved and landmark.hold == "HINT":
            landmark.hold = "EXACT"


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
        _tell(context, template, wrong)
    for _window, area, _space in views.spaces(context):
        area.tag_redraw()


def _stamp(template):
    """Where everything is that the shape follows."""
    arrays = [*landmarks.pairs(template), landmarks.within(template), markers.points(template)]
    bones = [ob for a in template.moulage.attachments for ob in (a.bone, a.target) if ob is not None]
    arrays += [mesh_data.matrix(ob) for ob in (template, *bones)]
    return hash(tuple(a.tobytes() for a in arrays))


def shut_down():
    _state.update(run=None, stamp=None, targets={})
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
