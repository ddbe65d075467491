"""Landmarks: clicked in pairs, named, mirrored, removed, and read from a file."""

import bpy
from events import (
    choose_file, click, look_at, on_screen, part, pause, picture, press, redo, template, type_text, undo, until,
)
from mathutils import Vector
from setting import LIVER, with_markers
from sidebar import ICON, LEFT, click_button, find, open_tab, show_panels, type_into


def session():
    ob = with_markers()
    yield from open_tab()
    yield from show_panels("Landmarks", "Reshape")
    yield from look_at([ob])
    yield from click_pairs()
    yield from mirror_names()
    yield from click_button("moulage.remove_landmark(all=True)", ICON)
    yield from until(lambda: len(template().moulage.landmarks) == 0, "no landmarks")
    yield from click_button("moulage.import_landmarks", LEFT)
    yield from choose_file(LIVER / "landmarks.csv")
    yield from until(lambda: len(template().moulage.landmarks) == 4, "the landmarks of the file")
    yield from place()
    yield from type_into(".moulage.tolerance", "0.3")
    yield from type_into(".moulage.landmark_tolerance", "15")
    yield from until(lambda: abs(template().moulage.landmark_tolerance - 15) < 1e-4, "the tolerances")
    assert abs(template().moulage.tolerance - 0.3) < 1e-5
    yield from look_at([template()])
    yield from picture("landmarks")


def marks():
    return [Vector(p) for p in part("markers").points(template())]


def nearest_vertex_to_viewer(around):
    """The vertex nearest to the front view's camera around a place: it is visible."""
    near = sorted((v.co for v in template().data.vertices), key=lambda p: (p - around).length)[:30]
    return min(near, key=lambda p: p.y)


def click_pairs():
    """Two pairs: a vertex of the template, then a marker."""
    yield from click_button("moulage.pick_landmarks")
    for number, around in enumerate((Vector((60, 140, 380)), Vector((0, 140, 380)))):
        vertex = nearest_vertex_to_viewer(around)
        yield from click(*on_screen(vertex))
        yield from until(lambda: len(template().moulage.landmarks) == number + 1, "a landmark on the template")
        mark = min(marks(), key=lambda p: (p - vertex).length)
        yield from click(*on_screen(mark))
        yield from until(lambda: template().moulage.landmarks[number].target is not None, "its place on the person")
        pair = template().moulage.landmarks[number]
        bpy.context.view_layer.update()
        off = (pair.template.matrix_world.translation - vertex).length
        assert off < 8, f"the click met the template {off} mm beside the vertex"
        assert min((p - pair.target.location).length for p in marks()) < 1e-3, "the click did not take the marker"
    press("ESC")
    yield from pause()
    yield from undo()
    yield from until(lambda: template().moulage.landmarks[1].target is None, "undo of one click")
    yield from redo()
    yield from until(lambda: template().moulage.landmarks[1].target is not None, "redo of it")


def mirror_names():
    """The first is named lobe.L; its partner is made on the other side, and clicked on the person."""
    # The first row of the list is below the button that removes one.
    x, y = yield from find("moulage.remove_landmark(all=False)", (0.75,))
    yield from click(x - 70, y - 33, ctrl=True)
    yield from pause()
    press("A", ctrl=True)
    yield from type_text("lobe.L")
    press("RET")
    yield from until(lambda: template().moulage.landmarks[0].name == "lobe.L", "the name that was typed")
    yield from click_button("moulage.mirror_landmarks")
    yield from until(lambda: len(template().moulage.landmarks) == 3, "the mirrored landmark")
    partner = template().moulage.landmarks[2]
    assert partner.name == "lobe.R" and partner.template is not None and partner.target is None
    yield from click_button("moulage.pick_landmarks")
    mark = min(marks(), key=lambda p: p.x)
    yield from click(*on_screen(mark))
    yield from until(lambda: template().moulage.landmarks[2].target is not None, "the mirrored landmark's place")
    press("ESC")
    yield from pause()


def place():
    """The template is put on the landmarks, and back by undo."""
    before = template().matrix_world.copy()
    yield from click_button("moulage.place_template(scale=False)", LEFT)
    yield from until(lambda: template().matrix_world != before, "the template's new place")
    yield from undo()
    yield from until(lambda: template().matrix_world == before, "undo of placing")
