"""What may happen during a run: it is stopped by the button, something is undone, its template is deleted, the add-on is
disabled."""

import os

import bpy
from events import has_result, pause, picture, press, running, search, select, template, undo, until
from setting import stopped_run, with_landmarks
from sidebar import click_button, open_tab, show_panels


def session():
    ob = with_landmarks()
    ob.hide_set(False)
    yield from open_tab()
    yield from show_panels("Reshape")
    yield from stopped_run(lambda: search("Moulage Reshape"), stop_by_button)
    yield from undo_something()
    yield from delete_template()
    yield from disable()


def start():
    yield from search("Moulage Reshape")
    yield from until(running, "the run")


def stop_by_button():
    yield from until(has_result, "the live view")
    try:
        yield from click_button("moulage.stop")
    except AssertionError:
        # Without a run there is no such button.
        if running():
            raise


def undo_something():
    """Ctrl+Z during a run undoes what was done before it, and the run goes on to its result."""
    template().moulage.tet_count, template().moulage.max_iterations = 6000, 8
    bpy.ops.ed.undo_push(message="ready")
    bpy.ops.moulage.add_landmark("EXEC_DEFAULT", True, name="undone", template_point=(0, 0, 0), target=(0, 0, 0))
    template().moulage.landmarks["undone"].use = False
    bpy.ops.ed.undo_push(message="one more")
    yield from start()
    yield from until(lambda: bpy.context.window_manager.moulage.fraction > 0.1, "the first steps")
    for _ in range(2):
        yield from undo()
        yield from pause()
    yield from until(lambda: "undone" not in template().moulage.landmarks, "undo during the run")
    assert running(), "undo ended the run"
    yield from until(lambda: not running(), "the end of the run")
    ending = template().moulage.result.ending
    assert has_result() and ending.startswith(("Done", "The iterations")), ending
    yield from picture("undone_meanwhile")
    yield from undo()
    yield from until(lambda: "undone" not in template().moulage.landmarks and not running(), "undo of the run")


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
