"""Markers: empties, the vertices of another mesh, a file in and a file out."""

import tempfile
from pathlib import Path

import bpy
from events import choose_file, keys, look_at, part, picture, press, select, template, until
from setting import LIVER, with_template
from sidebar import LEFT, click_button, empty_field, open_tab, pick, show_panels

COUNT = 308


def points():
    return part("markers").points(template())


def session():
    ob = with_template()
    yield from open_tab()
    yield from show_panels("Markers")
    yield from look_at([ob])
    with tempfile.TemporaryDirectory() as folder:
        yield from empties(Path(folder))
        yield from other_mesh()
        yield from file_in_and_out(Path(folder))
    yield from picture("template_and_markers")


def empties(folder):
    """Imported as empties, moved by G, and picked as a collection."""
    few = folder / "few.csv"
    few.write_text("\n".join((LIVER / "markers.csv").read_text().splitlines()[:12]) + "\n")
    yield from click_button("moulage.import_markers", LEFT)
    yield from choose_file(few, as_empties=True)
    yield from until(lambda: template().moulage.marker_empties is not None, "the collection of empties")
    collection = template().moulage.marker_empties
    count = len(collection.objects)
    assert count in (11, 12) and len(points()) == count
    first = collection.objects[0]
    x = first.location.x
    select(first)
    press("G")
    yield from keys("X", "5", "RET")
    yield from until(lambda: abs(points()[:, 0] - x - 5).min() < 1e-3, "the marker that moved with its empty")
    yield from empty_field(".moulage.marker_empties")
    yield from until(lambda: len(points()) == 0, "no markers")
    yield from pick(".moulage.marker_empties", collection.name)
    yield from until(lambda: len(points()) == count, "the markers of the collection that was picked")
    yield from empty_field(".moulage.marker_empties")
    yield from until(lambda: len(points()) == 0, "no markers once more")
    for empty in list(collection.objects):
        bpy.data.objects.remove(empty)
    bpy.data.collections.remove(collection)


def other_mesh():
    """The vertices of a mesh that lies in the scene."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=60, location=(60, 170, 380))
    bpy.context.object.name = "surface"
    yield from pick(".moulage.markers", "surface")
    yield from until(lambda: len(points()) == 42, "the markers of the mesh")
    yield from empty_field(".moulage.markers")
    yield from until(lambda: len(points()) == 0, "no markers after the mesh")
    bpy.data.objects.remove(bpy.data.objects["surface"])


def file_in_and_out(folder):
    yield from click_button("moulage.import_markers", LEFT)
    yield from choose_file(LIVER / "markers.csv", as_empties=False)
    yield from until(lambda: len(points()) == COUNT, "the markers of the file")
    out = folder / "markers.mrk.json"
    yield from click_button("moulage.export_markers")
    yield from choose_file(out)
    yield from until(out.is_file, "the exported markers")
    assert out.read_text().count('"position"') == COUNT
