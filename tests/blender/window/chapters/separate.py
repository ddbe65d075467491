"""Two balls that overlap: live view, Esc, undo, the whole separation, the slider."""

import bpy
from events import look_at, picture, press, running, select, undo, until
from scenes import ball
from setting import clear
from sidebar import click_button, open_tab, show_panels


def settings():
    return bpy.context.scene.moulage_separate


def keys(name):
    return bpy.data.objects[name].data.shape_keys


def session():
    yield from open_tab()
    clear()
    left, right = ball("left", 4), ball("right", 4)
    right.location = (1.7, 0.1, 0.05)
    settings().tet_count = 20_000
    yield from look_at([left, right])
    select(left, right)
    yield from show_panels("Separate")
    bpy.ops.ed.undo_push(message="ready")
    yield from stop_by_esc()
    yield from whole_separation()


def stop_by_esc():
    yield from click_button("moulage.separate")
    yield from until(running, "the separation")
    press("ESC")
    yield from until(lambda: not running(), "the end after Esc")
    # On a fast machine the meshes are filled already, and what was reached is kept.
    for name in ("left", "right"):
        bpy.data.objects[name].shape_key_clear()


def whole_separation():
    select(bpy.data.objects["left"], bpy.data.objects["right"])
    settings().tet_count = 3000
    bpy.ops.ed.undo_push(message="fewer tets")
    # What was said of the run that Esc ended stands until the next one ends.
    said_before = settings().report
    yield from click_button("moulage.separate")
    yield from until(lambda: keys("left") is not None, "the live view")
    yield from until(lambda: not running(), "the end of the separation")
    assert settings().clear, settings().report
    yield from picture("separate")
    yield from undo()
    yield from until(lambda: keys("left") is None and settings().report == said_before, "undo")
