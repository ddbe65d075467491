"""A session in a real window, by clicks and keys: the liver from template to heat map, and what may
happen in between. Writes screenshots.

    blender --factory-startup --enable-event-simulate --window-geometry 0 0 1400 1000 \
        --python tests/blender/window.py -- DIST SCREENSHOTS
"""

import os
import sys
import time
import traceback
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))

import run  # noqa: E402

DIST, PICTURES = (Path(a).resolve() for a in sys.argv[sys.argv.index("--") + 1 :][:2])
LIVER = Path(__file__).resolve().parents[2] / "examples" / "liver"
# Seconds for a step, and for a run.
LIMIT, RUN_LIMIT = 90, 600


def window():
    return bpy.context.window_manager.windows[0]


def area():
    return max((a for a in window().screen.areas if a.type == "VIEW_3D"), key=lambda a: a.width)


def region(kind="WINDOW"):
    return next(r for r in area().regions if r.type == kind)


def press(key, x=None, y=None, **modifiers):
    if x is None:
        # Left of the middle: the side bar covers the right.
        x, y = region().x + region().width // 3, region().y + region().height // 2
    event = window().event_simulate
    event(type=key, value="PRESS", x=int(x), y=int(y), **modifiers)
    event(type=key, value="RELEASE", x=int(x), y=int(y), **modifiers)


def move(x, y):
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=int(x), y=int(y))


def click(x, y):
    """Moves there and clicks."""
    move(x, y)
    yield
    press("LEFTMOUSE", x, y)
    yield


def type_text(text):
    for letter in text:
        kind = "SPACE" if letter == " " else letter.upper()
        window().event_simulate(type=kind, value="PRESS", unicode=letter, x=10, y=10)
        window().event_simulate(type=kind, value="RELEASE", x=10, y=10)
        yield


def search(name):
    """Runs an operator as a user does who does not know where its button is: F3, its name, Enter."""
    press("F3")
    yield from pause(0.5)
    yield from type_text(name.lower())
    yield from pause(0.5)
    press("RET")
    yield from pause(0.3)


def pause(seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        yield


def until(condition, what, limit=LIMIT):
    """Waits for something; a session on a slow machine must not count on times."""
    end = time.monotonic() + limit
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"waited in vain for: {what}")
        yield


def screenshot(name):
    path = PICTURES / f"{name}.png"
    with bpy.context.temp_override(window=window(), area=area(), region=region()):
        bpy.ops.screen.screenshot(filepath=str(path))
    assert path.is_file(), path


def picture(name):
    area().tag_redraw()
    yield from pause(0.6)
    screenshot(name)
    yield


def template():
    return bpy.context.scene.moulage.template


def running():
    return run_part("runs").is_running()


def has_result():
    keys = template().data.shape_keys
    return keys is not None and "Reshaped" in keys.key_blocks


def on_screen(point):
    from bpy_extras.view3d_utils import location_3d_to_region_2d

    place = location_3d_to_region_2d(region(), area().spaces.active.region_3d, point)
    return region().x + place.x, region().y + place.y


def look_at_everything():
    override = {"window": window(), "area": area(), "region": region()}
    with bpy.context.temp_override(**override):
        bpy.ops.object.select_all(action="DESELECT")
        template().select_set(True)
        bpy.context.view_layer.objects.active = template()
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    yield from pause(0.5)


def open_sidebar():
    area().spaces.active.show_region_ui = True
    yield from pause(0.5)
    side = region("UI")
    # The fourth tab, below Item, Tool and View.
    yield from click(side.x + side.width - 12, side.y + side.height - 167)
    yield from pause(0.5)


def nearest_vertex_to_viewer(points, around):
    """The vertex nearest to the front view's camera around a place: it is visible."""
    near = sorted(points, key=lambda p: (p - around).length)[:30]
    return min(near, key=lambda p: p.y)


def landmarks_by_clicks():
    """Two pairs: a vertex of the template, then a marker."""
    from mathutils import Vector

    ob = template()
    front = [v.co for v in ob.data.vertices]
    marks = [Vector(p) for p in run_part("markers").points(ob)]
    for number, place in enumerate((Vector((60, 140, 380)), Vector((0, 140, 380)))):
        yield from search("Click Landmark Pairs")
        vertex = nearest_vertex_to_viewer(front, place)
        yield from click(*on_screen(vertex))
        yield from until(lambda: len(ob.moulage.landmarks) == number + 1, "a landmark on the template")
        mark = min(marks, key=lambda p: (p - vertex).length)
        yield from click(*on_screen(mark))
        yield from until(lambda: ob.moulage.landmarks[number].target is not None, "its place on the person")
        press("ESC")
        yield from pause(0.3)
        pair = ob.moulage.landmarks[number]
        bpy.context.view_layer.update()
        off = (pair.template.matrix_world.translation - vertex).length
        assert off < 8, f"the click met the template {off} mm beside the vertex"
        hit = min((p - pair.target.location).length for p in marks)
        assert hit < 1e-3, "the click did not take the marker"


def scan_by_clicks():
    """The scan with the result's outline; slices scrubbed by moving them; markers clicked on a slice."""
    from mathutils import Vector

    scene = bpy.context.scene
    bpy.ops.moulage.load_scan(filepath=str(LIVER / "scan.nii.gz"))
    scan = run_part("scan")
    slices = scan.slices(scene)
    slices["CORONAL"].hide_viewport = slices["SAGITTAL"].hide_viewport = True
    scene.moulage.axial = 340
    template().hide_set(True)
    bpy.data.objects["markers"].hide_set(True)
    template().moulage.show_markers = False
    with bpy.context.temp_override(window=window(), area=area(), region=region()):
        bpy.ops.object.select_all(action="DESELECT")
        slices["AXIAL"].select_set(True)
        bpy.context.view_layer.objects.active = slices["AXIAL"]
        bpy.ops.moulage.look_at_slice(view="AXIAL")
    yield from pause(1)
    press("G")
    for key in ("Z", "TWO", "RET"):
        window().event_simulate(type=key, value="PRESS", unicode="2" if key == "TWO" else None, x=600, y=500)
        window().event_simulate(type=key, value="RELEASE", x=600, y=500)
        yield from pause(0.3)
    yield from until(lambda: abs(scene.moulage.axial - 342) < 1e-3, "the slider after the slice was moved")

    template().moulage.markers = None
    yield from search("Click Markers on Slices")
    # On the outline of the result, which is drawn there.
    outline = run_part("overlay")._contour(scene, template())
    places = [Vector(outline[len(outline) * i // 5].tolist()) for i in range(5)]
    for number, place in enumerate(places):
        yield from click(*on_screen(place))
        yield from until(lambda: len(run_part("markers").points(template())) == number + 1, "a marker")
    press("ESC")
    for place, mark in zip(places, run_part("markers").points(template())):
        assert (place - Vector(mark)).length < 1.0, (place, mark)
    press("Z", ctrl=True)
    yield from until(lambda: len(run_part("markers").points(template())) == 4, "undo of one click")
    press("Z", ctrl=True, shift=True)
    yield from until(lambda: len(run_part("markers").points(template())) == 5, "redo of it")
    template().moulage.show_markers = True
    yield from picture("scan")
    for empty in scan.slices(bpy.context.scene).values():
        empty.hide_viewport = True
    template().hide_set(False)


def run_part(name):
    import importlib

    return importlib.import_module(f"{MODULE}.{name}")


def session():
    yield from pause(1)
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    bpy.ops.wm.obj_import(filepath=str(LIVER / "template.obj"), forward_axis="Y", up_axis="Z")
    bpy.context.view_layer.objects.active = bpy.context.selected_objects[0]
    bpy.context.preferences.view.show_splash = False
    press("ESC")
    yield from pause(0.5)
    yield from open_sidebar()
    yield from picture("start")

    yield from search("Active Mesh as Template")
    yield from until(lambda: template() is not None, "the template")
    yield from search("Coordinates Are Millimetres")
    yield from until(lambda: bpy.context.scene.unit_settings.scale_length < 0.01, "millimetres")
    press("N")
    press("N")
    yield from search("Check Template")
    yield from until(lambda: template().moulage.checked, "the check")
    yield from look_at_everything()
    bpy.ops.moulage.import_markers(filepath=str(LIVER / "markers.csv"))
    assert len(template().moulage.markers.data.vertices) == 308
    yield from picture("template_and_markers")

    yield from landmarks_by_clicks()
    bpy.ops.moulage.remove_landmark(all=True)
    bpy.ops.moulage.import_landmarks(filepath=str(LIVER / "landmarks.csv"))
    template().moulage.tolerance, template().moulage.landmark_tolerance = 0.3, 15.0
    # Fewer tets than usual: the session is about the window.
    template().moulage.tet_count = 5000
    yield from look_at_everything()
    yield from picture("landmarks")
    bpy.ops.ed.undo_push(message="ready")

    # Esc keeps the best; undo takes it away.
    yield from search("Moulage Reshape")
    yield from until(running, "the run")
    yield from until(has_result, "the live view")
    yield from picture("running")
    press("ESC")
    yield from until(lambda: not running(), "the end after Esc")
    assert template().moulage.result.ending.startswith("Stopped"), template().moulage.result.ending
    press("Z", ctrl=True)
    yield from until(lambda: not has_result(), "undo")
    assert template().moulage.result.key == ""

    # A whole run.
    template().moulage.max_iterations = 20
    yield from search("Moulage Reshape")
    yield from until(running, "the second run")
    yield from until(lambda: not running(), "the end of the second run", RUN_LIMIT)
    assert template().moulage.result.mean_distance < 1.0, template().moulage.result.mean_distance
    yield from picture("result")
    bpy.ops.moulage.show_heat_map(kind="DISTANCE")
    yield from picture("heat_map_distance")
    bpy.ops.moulage.show_heat_map(kind="STRETCH")
    yield from picture("heat_map_stretch")
    bpy.ops.moulage.show_heat_map(kind="NONE")

    yield from scan_by_clicks()
    template().moulage.markers = bpy.data.objects["markers"]

    # The template is deleted during a run.
    bpy.ops.ed.undo_push(message="before deleting")
    template().moulage.max_iterations = 60
    yield from search("Moulage Reshape")
    yield from until(running, "the third run")
    bpy.ops.object.select_all(action="DESELECT")
    template().select_set(True)
    press("DEL")
    yield from until(lambda: not running(), "the end after deleting")
    press("Z", ctrl=True)
    yield from until(lambda: template() is not None and template().name in bpy.context.scene.objects, "undo of deleting")

    # The add-on is disabled during a run, and enabled again.
    yield from search("Moulage Reshape")
    yield from until(running, "the fourth run")
    yield from pause(1)
    bpy.ops.preferences.addon_disable(module=MODULE)
    yield from pause(1)
    assert not hasattr(bpy.types.Scene, "moulage")
    bpy.ops.preferences.addon_enable(module=MODULE)
    yield from pause(1)
    assert not running() and template() is not None
    yield from picture("enabled_again")


MODULE = ""


def main():
    global MODULE
    MODULE = os.environ["MOULAGE_MODULE"] = run.install(DIST)
    PICTURES.mkdir(parents=True, exist_ok=True)
    steps = session()
    began = time.monotonic()

    def go_on():
        try:
            next(steps)
        except StopIteration:
            print(f"the session went well, {time.monotonic() - began:.0f} s", flush=True)
            os._exit(0)
        except BaseException:
            traceback.print_exc()
            screenshot("failed")
            sys.stderr.flush()
            os._exit(1)
        return 0.05

    bpy.app.timers.register(go_on, first_interval=1.0, persistent=True)


main()
