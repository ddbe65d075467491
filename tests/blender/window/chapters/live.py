"""Live editing: a landmark of a ball is moved by G, X, 1; the shape meets it although markers contradict, and comes back
by undo."""

import time

import bpy
import scenes
from events import has_result, keys, picture, press, running, select, template, undo, until
from sidebar import click_button, open_tab, show_panels

# Turns of Blender's loop, of 20 ms or more, in which live editing looks several times.
_LOOKS = 50


def session():
    ball = scenes.ball_and_markers(tet_count=1500, iterations=15)
    tip = max(tuple(v.co) for v in ball.data.vertices)
    bpy.ops.moulage.add_landmark(template_point=tip, target=scenes.egg([tip])[0])
    for axis in ((-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)):
        bpy.ops.moulage.add_landmark(template_point=axis, target=scenes.egg([axis])[0])
    bpy.context.view_layer.objects.active = ball
    yield from open_tab()
    yield from show_panels("Landmarks", "Reshape", "Result")
    yield from click_button("moulage.reshape")
    yield from until(lambda: has_result() and ball.moulage.result.key != "" and not running(), "the result")
    before = length()
    yield from click_button(".live_edit")
    yield from until(live, "live editing")
    select(template().moulage.landmarks[0].target)
    target = template().moulage.landmarks[0].target
    press("G")
    yield from keys("X", "0", ".", "2", "RET")
    yield from until(lambda: abs(length() - target.matrix_world.translation.x) < 0.005, "the shape at the landmark")
    yield from quiet()
    assert length() > before + 0.15 and template().moulage.landmarks[0].hold == "EXACT"
    yield from picture("pin")
    yield from undo()
    yield from until(lambda: abs(length() - before) < 0.05, "the shape after undo")
    yield from quiet()
    assert abs(length() - before) < 0.05 and template().moulage.landmarks[0].hold == "HINT"
    yield from click_button(".live_edit")
    yield from until(lambda: not live() and not running(), "the end of live editing")


def quiet():
    """Waits until no run begins any more: live editing has looked at the scene since what was done last. The side bar then
    stays as it is."""
    turns = 0
    while turns < _LOOKS:
        turns = 0 if running() else turns + 1
        time.sleep(0.02)
        yield


def live():
    return bpy.context.window_manager.moulage.live_edit


def length():
    return max(p.co.x for p in template().data.shape_keys.key_blocks["Reshaped"].data)
