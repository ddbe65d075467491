"""The scan of the liver: slices by sliders, by moving and turning them; windows; the outline; markers clicked on a slice,
and from a label map."""

import tempfile
from pathlib import Path

import bpy
import numpy
from events import (
    area, choose_file, click, keys, look_at, on_screen, part, pause, picture, press, redo, region, scene, screenshot,
    select, template, undo, until,
)
from mathutils import Vector
from setting import LIVER, liver_label_map, surface_of_result, with_result
from sidebar import LEFT, choose_at, click_button, find, open_inner_panel, open_tab, show_panels, type_into, write_into


def slices():
    return part("scan").slices(bpy.context.scene)


def session():
    ob = with_result()
    yield from open_tab()
    yield from show_panels("Scan", "Markers")
    yield from click_button("moulage.load_scan")
    yield from choose_file(LIVER / "scan.nii.gz")
    yield from until(lambda: len(slices()) == 4, "the slices")
    for other in [ob, *(o for o in bpy.context.scene.objects if o.type == "MESH")]:
        other.hide_set(True)
    ob.moulage.show_markers = False
    yield from sliders()
    yield from move_in_3d()
    yield from windows()
    yield from oblique()
    yield from outline()
    yield from click_markers()
    yield from picture("scan")
    with tempfile.TemporaryDirectory() as folder:
        yield from label_map(Path(folder))
    for empty in slices().values():
        empty.hide_viewport = True
    ob.hide_set(False)


def sliders():
    for view, axis, value in (("axial", 2, 330), ("coronal", 1, 180), ("sagittal", 0, 70)):
        yield from type_into(f".moulage.{view}", str(value), LEFT)
        yield from until(lambda: abs(getattr(scene(), view) - value) < 1e-3, f"the number in the {view} slider")
        assert abs(slices()[view.upper()].matrix_world.translation[axis] - value) < 1e-3
    yield from look_at(list(slices().values())[:3])
    # Around by 45 degrees, and up by 30.
    yield from keys("NUMPAD_6", "NUMPAD_6", "NUMPAD_6", "NUMPAD_8", "NUMPAD_8")
    yield from picture("slices")


def move_in_3d():
    """The others are hidden, the axial slice is looked at and moved by G: its slider follows."""
    for view in ("CORONAL", "SAGITTAL"):
        yield from click_button(f'objects["{view.capitalize()}"].hide_viewport', (0.92, 0.86))
        yield from until(lambda: slices()[view].hide_viewport, f"the {view} slice to hide")
    yield from click_button("look_at_slice(view='AXIAL')", (0.8, 0.74))
    # From the feet.
    view = area().spaces.active.region_3d
    wanted = slices()["AXIAL"].matrix_world.to_quaternion()
    yield from until(lambda: view.view_rotation.rotation_difference(wanted).angle < 1e-3, "the view on the axial slice")
    select(slices()["AXIAL"])
    press("G")
    yield from keys("Z", "1", "2", "RET")
    yield from until(lambda: abs(scene().axial - 342) < 1e-3, "the slider after the slice was moved")


def pixels():
    image = slices()["AXIAL"].data
    flat = numpy.empty(4 * image.size[0] * image.size[1], numpy.float32)
    image.pixels.foreach_get(flat)
    return flat


def windows():
    """Presets by the menu, width and level by keys: the picture changes."""
    before = pixels()
    x, y = yield from find(".moulage.window_level", LEFT)
    for letter, width in (("B", 2000), ("L", None), ("S", 400)):
        yield from choose_at((x, y - 24), letter)
        if width is not None:
            yield from until(lambda: scene().window_width == width, f"the window {width}")
    yield from type_into(".moulage.window_level", "90", (0.75,))
    yield from until(lambda: scene().window_level == 90 and not numpy.array_equal(before, pixels()), "the level")
    yield from type_into(".moulage.window_level", "40", (0.75,))
    yield from until(lambda: scene().window_level == 40, "the level put back")


def oblique():
    """The oblique slice is shown, turned by R, X, 30, and hidden."""
    slice_ = slices()["OBLIQUE"]
    yield from click_button('objects["Oblique"].hide_viewport', (0.92, 0.86))
    yield from until(lambda: slice_.data is not None and not slice_.hide_viewport, "the oblique slice")
    select(slice_)
    before = slice_.data.pixels[:]
    press("R")
    yield from keys("X", "3", "0", "RET")
    yield from until(lambda: abs(abs(slice_.rotation_euler[0]) - 0.5236) < 1e-3, "the turn of the oblique slice")
    yield from until(lambda: slice_.data.pixels[:] != before, "the oblique slice after it was turned")
    yield from click_button('objects["Oblique"].hide_viewport', (0.92, 0.86))
    yield from until(lambda: slice_.hide_viewport, "the oblique slice to hide")
    select(slices()["AXIAL"])


def outline():
    """The green line is there, and away once it is switched off."""
    with tempfile.TemporaryDirectory() as folder:
        for wanted in (False, True):
            yield from click_button(".moulage.show_contour")
            yield from until(lambda: scene().show_contour == wanted, "the switch of the outline")
            yield from pause()
            count = yield from green_pixels(Path(folder) / "view.png")
            assert (count > 300) == wanted, f"{count} green pixels with the outline {'on' if wanted else 'off'}"


def green_pixels(path):
    screenshot(path)
    image = bpy.data.images.load(str(path))
    flat = numpy.empty(len(image.pixels), numpy.float32)
    image.pixels.foreach_get(flat)
    colours = flat.reshape(image.size[1], image.size[0], 4)
    view = colours[region().y + 60 : region().y + region().height - 120, region().x + 80 : region().x + region().width - 260]
    bpy.data.images.remove(image)
    yield
    return int(((view[..., 1] > 0.8) & (view[..., 0] < 0.4) & (view[..., 2] < 0.6)).sum())


def click_markers():
    """On the outline of the result; undo takes one click back."""
    template().moulage.markers = None
    yield from click_button("moulage.click_markers")
    frame = slices()["AXIAL"].matrix_world
    line = part("overlay")._contour(bpy.context, [(tuple(frame.translation), tuple(frame.col[2].xyz))])
    places = [Vector(line[len(line) * i // 5].tolist()) for i in range(5)]
    for number, place in enumerate(places):
        yield from click(*on_screen(place))
        yield from until(lambda: len(markers()) == number + 1, "a marker")
    press("ESC")
    for place, mark in zip(places, markers()):
        assert (place - Vector(mark)).length < 1.0, (place, mark)
    yield from undo()
    yield from until(lambda: len(markers()) == 4, "undo of one click")
    yield from redo()
    yield from until(lambda: len(markers()) == 5, "redo of it")
    template().moulage.show_markers = True


def markers():
    return part("markers").points(template())


def label_map(folder):
    """A label map of the result becomes markers on it, on sagittal slices."""
    path = liver_label_map(folder / "liver.nrrd")
    yield from open_inner_panel("moulage.click_markers", "moulage.markers_from_label", gap=22)
    yield from write_into(".moulage.label_map", str(path))
    yield from until(lambda: scene().label_map == str(path), "the label map")
    yield from click_button(".moulage.label_planes", (0.85,))
    yield from until(lambda: scene().label_planes == {"SAGITTAL"}, "the kinds of slices")
    yield from type_into(".moulage.label_every", "18", LEFT)
    yield from until(lambda: abs(scene().label_every - 18) < 1e-3, "the distance of the slices")
    yield from click_button("moulage.markers_from_label")
    yield from until(lambda: len(markers()) > 50, "the markers of the label map")
    tree = surface_of_result()
    off = [tree.find_nearest(Vector(mark))[3] for mark in markers()]
    assert numpy.mean(off) < 2.5, numpy.mean(off)
    yield from look_at([template().moulage.markers], "RIGHT")
    yield from picture("label_map")
