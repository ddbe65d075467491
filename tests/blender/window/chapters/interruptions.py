"""What may happen during a run: it is stopped by the button, its template is deleted, the add-on is disabled."""

import os

import bpy
from events import has_result, pause, picture, press, running, search, select, template, undo, until
from setting import with_landmarks
from sidebar import click_button, open_tab, show_panels


def session():
    ob = with_landmarks()
    ob.hide_set(False)
    yield from open_tab()
    yield from show_panels("Reshape")
    # Long enough to be interrupted on any machine.
    ob.moulage.tet_count, ob.moulage.max_iterations = 15000, 100
    bpy.ops.ed.undo_push(message="before the interruptions")
    yield from stop_by_button()
    yield from delete_template()
    yield from disable()


def start():
    yield from search("Moulage Reshape")
    yield from until(running, "the run")


def stop_by_button():
    yield from start()
    yield from until(has_result, "the live view")
    yield from click_button("moulage.stop")
    yield from until(lambda: not running(), "the end after Stop")
    assert template().moulage.result.ending.startswith("Stopped"), template().moulage.result.ending


def delete_template():
    yield from start()
    select(template())
    press("DEL")
    yield from until(lambda: not running(), "the end after deleting")
    yield from undo()
    yield from until(lambda: template() is not None and template().name in bpy.context.scene.objects, "undo of deleting")


def disable():
    yield from start()
    module = os.environ["MOULAGE_MODULE"]
    bpy.ops.preferences.addon_disable(module=module)
    yield from until(lambda: not hasattr(bpy.types.Scene, "moulage"), "the add-on to be gone")
    bpy.ops.preferences.addon_enable(module=module)
    yield from until(lambda: hasattr(bpy.types.Scene, "moulage"), "the add-on to be back")
    yield from pause()
    assert not running() and template() is not None
    yield from picture("enabled_again")
