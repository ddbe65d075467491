"""Live editing: a landmark of a ball is moved by G, X, 1; the shape follows, and comes back by undo."""

import bpy
import scenes
from events import has_result, keys, press, running, select, template, undo, until
from sidebar import click_button, open_tab, show_panels


def session():
    ball = scenes.ball_and_markers(tet_count=1500, iterations=15)
    ball.moulage.markers, ball.moulage.landmark_tolerance = None, 0.01
    for axis in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)):
        bpy.ops.moulage.add_landmark(template_point=axis, target=scenes.egg([axis])[0])
    bpy.context.view_layer.objects.active = ball
    yield from open_tab()
    yield from show_panels("Reshape", "Result")
    yield from click_button("moulage.reshape")
    yield from until(lambda: has_result() and ball.moulage.result.key != "" and not running(), "the result")
    before = length()
    yield from click_button(".live_edit")
    yield from until(live, "live editing")
    select(template().moulage.landmarks[0].target)
    press("G")
    yield from keys("X", "1", "RET")
    yield from until(lambda: length() > before + 0.5, "the shape that follows the landmark")
    yield from undo()
    yield from until(lambda: abs(length() - before) < 0.2, "the shape after undo")
    yield from click_button(".live_edit")
    yield from until(lambda: not live() and not running(), "the end of live editing")


def live():
    return bpy.context.window_manager.moulage.live_edit


def length():
    return max(p.co.x for p in template().data.shape_keys.key_blocks["Reshaped"].data)
