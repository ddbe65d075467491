"""Reshape: live view, Esc and undo; a whole run with what it is to keep; slider, heat maps, copy."""

import bpy
import numpy
from events import has_result, look_at, part, picture, press, running, template, undo, until
from setting import stopped_run, with_landmarks
from sidebar import click_button, open_tab, show_panels, type_into


def session():
    ob = with_landmarks()
    yield from open_tab()
    yield from show_panels("Markers", "Landmarks", "Reshape", "Result")
    yield from look_at([ob])
    bpy.ops.ed.undo_push(message="ready")
    yield from stopped_run(lambda: click_button("moulage.reshape"), stop_by_esc)
    # Esc has kept the best; undo takes it away.
    yield from undo()
    yield from until(lambda: not has_result(), "undo")
    assert template().moulage.result.key == ""
    yield from whole_run()
    # Without the others above it nothing of the panel is out of sight.
    yield from show_panels("Result")
    yield from slider()
    yield from heat_maps()
    yield from click_button("moulage.copy_result")
    yield from until(lambda: "template reshaped" in bpy.data.objects, "the copy")
    yield from undo()
    yield from until(lambda: "template reshaped" not in bpy.data.objects, "undo of the copy")


def stop_by_esc():
    yield from until(has_moved, "a shape in the live view")
    yield from picture("running")
    press("ESC")


def has_moved():
    """Whether the live view shows a shape that has gone 10 mm somewhere."""
    if not has_result():
        return False
    mesh_data, data = part("mesh_data"), template().data
    moved = mesh_data.key_points(data.shape_keys.key_blocks["Reshaped"]) - mesh_data.rest_points(data)
    return numpy.linalg.norm(moved, axis=1).max() > 10


def whole_run():
    template().moulage.tet_count, template().moulage.max_iterations = 2000, 20
    bpy.ops.ed.undo_push(message="a short run")
    yield from click_button("moulage.reshape")
    # It may be over before anyone looks.
    yield from until(lambda: template().moulage.result.key != "" and not running(), "the end of the second run")
    result = template().moulage.result
    assert result.mean_distance < 1.0, result.mean_distance
    for item in template().moulage.carried:
        assert item.object.data.shape_keys.key_blocks["Reshaped"].value == 1
    yield from picture("result")


def slider():
    """Half way to the person, by keys; and back."""
    key = template().data.shape_keys.key_blocks["Reshaped"]
    for text, value in (("0.5", 0.5), ("1", 1.0)):
        yield from type_into('Reshaped"].value', text)
        yield from until(lambda: abs(key.value - value) < 1e-4, f"the slider at {value}")


def heat_maps():
    for kind in ("DISTANCE", "STRETCH", "SURE", "NONE"):
        yield from click_button(f"show_heat_map(kind='{kind}')", (0.25, 0.75))
        yield from until(lambda: template().moulage.heat == kind, f"the heat map {kind}")
        if kind != "NONE":
            yield from picture(f"heat_map_{kind.lower()}")
