"""Clicks and keys in Blender's window, and waiting for what they bring about. Steps are generators: Blender goes on
at each `yield`. A step waits for its result or for turns of Blender's loop, never for a time: machines differ."""

import importlib
import os
import time
from pathlib import Path

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d

# Turns of Blender's loop after which nothing more is waited for, where no run goes on.
_PATIENCE = 3000
_TURNS = 4
# What was clicked so far, or entered in the file browser: a file, and its button.
CLICKS = []
_DIGITS = dict(zip("0123456789", ("ZERO", "ONE", "TWO", "THREE", "FOUR", "FIVE", "SIX", "SEVEN", "EIGHT", "NINE")))
_SIGNS = {" ": "SPACE", ".": "PERIOD", "/": "SLASH", "-": "MINUS", "_": "MINUS"}


def part(name):
    """A module of the installed add-on, such as `scan`."""
    return importlib.import_module(f"{os.environ['MOULAGE_MODULE']}.{name}")


def window():
    return bpy.context.window_manager.windows[0]


def area():
    return max((a for a in window().screen.areas if a.type == "VIEW_3D"), key=lambda a: a.width)


def region(kind="WINDOW"):
    return next(r for r in area().regions if r.type == kind)


def in_view(kind="WINDOW"):
    """The context of the 3D view, for what a script sets up."""
    return bpy.context.temp_override(window=window(), area=area(), region=region(kind))


def event(kind, value, place=None, text=None, **modifiers):
    if place is None:
        # Left of the middle: the side bar covers the right.
        place = region().x + region().width // 3, region().y + region().height // 2
    x, y = (int(v) for v in place)
    window().event_simulate(type=kind, value=value, x=x, y=y, unicode=text, **modifiers)


def press(kind, place=None, text=None, **modifiers):
    event(kind, "PRESS", place, text, **modifiers)
    event(kind, "RELEASE", place, **modifiers)


def click(x, y, **modifiers):
    """Moves there and clicks."""
    CLICKS.append("a button")
    event("MOUSEMOVE", "NOTHING", (x, y))
    yield from pause()
    press("LEFTMOUSE", (x, y), **modifiers)
    yield from pause()


def type_text(text):
    for letter in text:
        press(_DIGITS.get(letter) or _SIGNS.get(letter) or letter.upper(), text=letter)
        yield


def keys(*names):
    """Presses keys one after the other; what is no key's name is typed."""
    for name in names:
        if name in _DIGITS or name in _SIGNS:
            yield from type_text(name)
        else:
            press(name)
        yield from pause()


def search(name):
    """Runs an operator as a user does who does not know where its button is: F3, its name, Enter."""
    press("F3")
    yield from pause()
    yield from type_text(name.lower())
    yield from pause()
    press("RET")
    yield from pause()


def undo():
    press("Z", ctrl=True)
    yield


def redo():
    press("Z", ctrl=True, shift=True)
    yield


def choose_file(path, **options):
    """In the file browser that was asked for: the file, Enter."""
    found = []

    def browser():
        found[:] = [(w, a) for w in bpy.context.window_manager.windows for a in w.screen.areas if a.type == "FILE_BROWSER"]
        return bool(found) and found[0][1].spaces.active.params is not None

    CLICKS.extend([path.name, "the file browser's button"])
    yield from until(browser, f"the file browser for {path.name}")
    own, place = found[0]
    space = place.spaces.active
    space.params.directory, space.params.filename = str(path.parent).encode(), path.name
    for name, value in options.items():
        setattr(space.active_operator, name, value)
    yield from pause()
    listing = next(r for r in place.regions if r.type == "WINDOW")
    middle = listing.x + listing.width // 2, listing.y + listing.height // 2
    for value in ("PRESS", "RELEASE"):
        own.event_simulate(type="RET", value=value, x=middle[0], y=middle[1])
    yield from until(lambda: not browser(), f"the end of the file browser for {path.name}")
    yield from pause()


def pause():
    """A few turns of Blender's loop, in which it takes events and draws."""
    for _ in range(_TURNS):
        yield


def until(condition, what):
    """Waits for something, however long a run goes on: tests/watchdog.py ends a session that hangs."""
    print(f"  {what}", flush=True)
    turns = 0
    while not condition():
        turns = 0 if running() else turns + 1
        if turns > _PATIENCE:
            raise AssertionError(f"waited in vain for: {what}")
        # While events are simulated Blender's loop never rests: leaves the processor to the run.
        time.sleep(0.02)
        yield


def on_screen(point):
    """Where a point of the scene is in the window."""
    place = location_3d_to_region_2d(region(), area().spaces.active.region_3d, point)
    return region().x + place.x, region().y + place.y


def select(*objects):
    with in_view():
        bpy.ops.object.select_all(action="DESELECT")
        for ob in objects:
            ob.select_set(True)
        bpy.context.view_layer.objects.active = objects[0]


def look_at(objects, axis="FRONT"):
    """Fits the view to objects, and takes them out of the selection."""
    with in_view():
        select(*objects)
        bpy.ops.view3d.view_axis(type=axis)
        bpy.ops.view3d.view_selected()
        bpy.ops.object.select_all(action="DESELECT")
    yield from pause()


def screenshot(path):
    with in_view():
        bpy.ops.screen.screenshot(filepath=str(path))
    assert path.is_file(), path


def picture(name):
    """A screenshot of the whole window, without a tooltip."""
    event("MOUSEMOVE", "NOTHING")
    area().tag_redraw()
    yield from pause()
    screenshot(Path(os.environ["MOULAGE_PICTURES"]) / f"{name}.png")
    yield


def scene():
    return bpy.context.scene.moulage


def template():
    return scene().template


def running():
    return part("runs").is_running()


def has_result():
    keys = template().data.shape_keys
    return keys is not None and "Reshaped" in keys.key_blocks
