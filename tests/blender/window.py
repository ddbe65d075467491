"""A session in a real window, by clicks and keys: the liver from template to heat map, what may
happen in between, and the hand's skeleton. Writes screenshots.

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
LIVER, HAND = (Path(__file__).resolve().parents[2] / "examples" / name for name in ("liver", "hand"))
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


def choose_file(name, path):
    """Opens a file by an importer: F3, its name, the file, Enter."""
    yield from search(name)
    found = []

    def browser():
        found[:] = [(w, a) for w in bpy.context.window_manager.windows for a in w.screen.areas if a.type == "FILE_BROWSER"]
        return bool(found) and found[0][1].spaces.active.params is not None

    yield from until(browser, f"the file browser of {name}")
    own, place = found[0]
    parameters = place.spaces.active.params
    parameters.directory, parameters.filename = str(path.parent).encode(), path.name
    yield from pause(0.5)
    listing = next(r for r in place.regions if r.type == "WINDOW")
    x, y = listing.x + listing.width // 2, listing.y + listing.height // 2
    for value in ("PRESS", "RELEASE"):
        own.event_simulate(type="RET", value=value, x=x, y=y)
    yield from until(lambda: not browser(), f"the end of {name}")
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


def keys(*names):
    """Presses keys one after the other; digits are typed."""
    digits = {"ONE": "1", "TWO": "2", "THREE": "3", "FOUR": "4", "ZERO": "0"}
    for key in names:
        for value in ("PRESS", "RELEASE"):
            window().event_simulate(type=key, value=value, unicode=digits.get(key) if value == "PRESS" else None, x=600, y=500)
        yield from pause(0.2)


def slider_by_keys(scene, slices):
    """A click on the axial slider of the panel, a number, Enter."""
    side = region("UI")
    yield from click(side.x + 80, side.y + side.height - 182)
    yield from pause(0.3)
    yield from keys("THREE", "THREE", "ZERO", "RET")
    yield from until(lambda: abs(scene.moulage.axial - 330) < 1e-3, "the typed number in the slider")
    assert abs(slices["AXIAL"].matrix_world.translation.z - 330) < 1e-3
    scene.moulage.axial = 342


def oblique_by_keys(slices):
    """The oblique slice, turned by R, X, 30."""
    slice_ = slices["OBLIQUE"]
    slice_.hide_viewport = False
    select(slice_)
    yield from until(lambda: slice_.data is not None, "the oblique slice")
    before = slice_.data.pixels[:]
    press("R")
    yield from keys("X", "THREE", "ZERO", "RET")
    yield from until(lambda: abs(abs(slice_.rotation_euler[0]) - 0.5236) < 1e-3, "the turn of the oblique slice")
    yield from until(lambda: slice_.data.pixels[:] != before, "the oblique slice after it was turned")
    slice_.hide_viewport = True
    select(slices["AXIAL"])


def select(ob):
    with bpy.context.temp_override(window=window(), area=area(), region=region()):
        bpy.ops.object.select_all(action="DESELECT")
        ob.select_set(True)
        bpy.context.view_layer.objects.active = ob


def scan_by_clicks():
    """The scan with the result's outline; slices scrubbed by moving them; markers clicked on a slice."""
    from mathutils import Vector

    scene = bpy.context.scene
    yield from choose_file("Import Moulage Scan", LIVER / "scan.nii.gz")
    scan = run_part("scan")
    yield from until(lambda: len(scan.slices(scene)) == 4, "the slices")
    slices = scan.slices(scene)
    slices["CORONAL"].hide_viewport = slices["SAGITTAL"].hide_viewport = True
    scene.moulage.axial = 340
    template().hide_set(True)
    bpy.data.objects["vessel"].hide_set(True)
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
    yield from search("Window of the Scan Bone")
    yield from until(lambda: scene.moulage.window_width == 2000, "the window for bone")
    yield from search("Window of the Scan Soft Tissue")
    yield from until(lambda: scene.moulage.window_width == 400, "the window for soft tissue")
    yield from slider_by_keys(scene, slices)
    yield from oblique_by_keys(slices)

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


def attach_and_carry():
    """A vessel that is carried, and an attachment that is taken back."""
    bpy.ops.mesh.primitive_uv_sphere_add(radius=8, location=(60, 170, 380))
    vessel = bpy.context.object
    vessel.name = "vessel"
    yield from search("Moulage Carry Selected")
    yield from until(lambda: len(template().moulage.carried) == 1, "the carried mesh")
    yield from search("Add Attachment")
    yield from until(lambda: len(template().moulage.attachments) == 1, "the attachment")
    assert template().moulage.attachments[0].bone == vessel
    press("Z", ctrl=True)
    yield from until(lambda: len(template().moulage.attachments) == 0, "undo of the attachment")


def session():
    yield from pause(1)
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    bpy.ops.wm.obj_import(filepath=str(LIVER / "template.obj"), forward_axis="Y", up_axis="Z")
    bpy.context.view_layer.objects.active = bpy.context.selected_objects[0]
    bpy.context.preferences.view.show_splash = False
    # The file browser is to be in this window.
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
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
    assert template().moulage.findings == "", template().moulage.findings
    yield from search("Fill with Tets")
    yield from until(lambda: "tets by" in template().moulage.tets_text, "the tets")
    yield from look_at_everything()
    yield from attach_and_carry()
    yield from choose_file("Import Moulage Markers", LIVER / "markers.csv")
    yield from until(lambda: template().moulage.markers is not None, "the markers")
    assert len(template().moulage.markers.data.vertices) == 308
    yield from picture("template_and_markers")

    yield from landmarks_by_clicks()
    bpy.ops.moulage.remove_landmark(all=True)
    yield from choose_file("Import Moulage Landmarks", LIVER / "landmarks.csv")
    yield from until(lambda: len(template().moulage.landmarks) == 4, "the landmarks")
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
    assert bpy.data.objects["vessel"].data.shape_keys.key_blocks["Reshaped"].value == 1
    for kind in ("DISTANCE", "STRETCH", "NONE"):
        yield from search(f"Show Heat Map {kind}")
        yield from until(lambda: template().moulage.heat == kind, f"the heat map {kind}")
        if kind != "NONE":
            yield from picture(f"heat_map_{kind.lower()}")
    yield from search("Copy Result")
    yield from until(lambda: "template reshaped" in bpy.data.objects, "the copy")
    press("Z", ctrl=True)
    yield from until(lambda: "template reshaped" not in bpy.data.objects, "undo of the copy")

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
    yield from live_by_keys()
    yield from skeleton_by_clicks()


def live_by_keys():
    """Live editing: a landmark of a ball moved by G, X, 1; the shape follows, and comes back by undo."""
    import scenes

    ball = scenes.ball_and_markers(tet_count=1500, iterations=15)
    ball.moulage.markers, ball.moulage.landmark_tolerance = None, 0.01
    for axis in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)):
        bpy.ops.moulage.add_landmark(template_point=axis, target=scenes.egg([axis])[0])
    bpy.context.view_layer.objects.active = ball
    yield from search("Moulage Reshape")
    yield from until(lambda: has_result() and not running(), "the ball's result", RUN_LIMIT)

    def length():
        return max(p.co.x for p in template().data.shape_keys.key_blocks["Reshaped"].data)

    before = length()
    bpy.context.window_manager.moulage.live_edit = True
    yield from pause(1)
    select(ball.moulage.landmarks[0].target)
    press("G")
    yield from keys("X", "ONE", "RET")
    yield from until(lambda: length() > before + 0.5, "the shape that follows the landmark", RUN_LIMIT)
    press("Z", ctrl=True)
    yield from until(lambda: abs(length() - before) < 0.2, "the shape after undo", RUN_LIMIT)
    bpy.context.window_manager.moulage.live_edit = False
    yield from until(lambda: not running(), "the end of live editing")


def skeleton():
    return bpy.context.scene.moulage.skeleton


def look_at(objects):
    with bpy.context.temp_override(window=window(), area=area(), region=region()):
        bpy.ops.object.select_all(action="DESELECT")
        for ob in objects:
            ob.select_set(True)
        bpy.ops.view3d.view_axis(type="RIGHT")
        bpy.ops.view3d.view_selected()
        bpy.ops.object.select_all(action="DESELECT")
    yield from pause(0.5)


def skeleton_by_clicks():
    """The hand: file, panel, registration with live view, stop, undo, the person's armature."""
    for ob in list(bpy.data.objects):
        bpy.data.objects.remove(ob)
    for collection in list(bpy.data.collections):
        bpy.data.collections.remove(collection)
    yield from pause(0.5)
    yield from search("Coordinates Are Millimetres")
    yield from until(lambda: bpy.context.scene.unit_settings.scale_length < 0.01, "millimetres")
    yield from choose_file("Import Moulage Skeleton", HAND / "skeleton.json")
    yield from until(lambda: skeleton() is not None, "the skeleton")
    bpy.ops.import_mesh.ply(filepath=str(HAND / "target_surface.ply"))
    skeleton().moulage_skeleton.target = bpy.context.object
    side = region("UI")
    # The tab, and below the panels Template and Scan the header of the panel.
    yield from click(side.x + side.width - 12, side.y + side.height - 167)
    yield from pause(0.5)
    yield from click(side.x + 55, side.y + side.height - 259)
    yield from look_at(bpy.data.objects)
    yield from picture("skeleton_start")
    bpy.ops.ed.undo_push(message="ready")

    yield from search("Register Skeleton")
    yield from until(running, "the registration")
    yield from until(lambda: any("(so far)" in ob.name for ob in bpy.data.objects), "the live view")
    skeleton().moulage_skeleton.target.hide_set(True)
    yield from picture("skeleton_running")
    press("ESC")
    yield from until(lambda: not running(), "the end after Esc")
    own = skeleton().moulage_skeleton.person
    assert own.moulage_skeleton.result.ending.startswith("Stopped"), own.moulage_skeleton.result.ending
    press("Z", ctrl=True)
    yield from until(lambda: skeleton().moulage_skeleton.person is None, "undo")
    assert not any("person" in ob.name for ob in bpy.data.objects)

    yield from search("Register Skeleton")
    yield from until(running, "the second registration")
    yield from until(lambda: not running(), "the end of the registration", RUN_LIMIT)
    own = skeleton().moulage_skeleton.person
    assert own.moulage_skeleton.result.mean_residual < 0.05
    bpy.context.view_layer.update()
    for ob in [skeleton(), *skeleton().children, skeleton().moulage_skeleton.target]:
        ob.hide_set(True)
    yield from look_at(own.children)
    yield from picture("skeleton")


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
