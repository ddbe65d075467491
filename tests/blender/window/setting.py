"""What is there before a chapter begins, as an artist would have brought it along: the liver, a vessel, bones."""

from pathlib import Path

import bpy
import numpy
from events import has_result, in_view, part, pause, running, scene, template, undo, until
from mathutils import Vector
from mathutils.bvhtree import BVHTree

LIVER, HAND = (Path(__file__).resolve().parents[3] / "examples" / name for name in ("liver", "hand"))


def load_liver(forward="Y", up="Z"):
    """The liver alone in the scene, selected; by Blender's importer with these axes."""
    clear()
    bpy.context.scene.unit_settings.scale_length = 1.0
    with in_view():
        bpy.ops.wm.obj_import(filepath=str(LIVER / "template.obj"), forward_axis=forward, up_axis=up)
    ob = bpy.context.selected_objects[0]
    bpy.context.view_layer.objects.active = ob
    return ob


def clear():
    for ob in list(bpy.data.objects):
        bpy.data.objects.remove(ob)
    for collection in list(bpy.data.collections):
        bpy.data.collections.remove(collection)


def with_template():
    """The liver as template, in millimetres; loaded where the chapters before have not."""
    if template() is None or template().name not in bpy.context.scene.objects:
        scene().template = load_liver()
        bpy.ops.moulage.use_millimetres()
        scene().template.moulage.tet_count = 2000
    return template()


def with_markers():
    """The template and its 308 markers."""
    ob = with_template()
    if ob.moulage.markers is None:
        bpy.ops.moulage.import_markers(filepath=str(LIVER / "markers.csv"))
    return template()


def with_landmarks():
    """The template, its markers and landmarks, and how exact they are."""
    ob = with_markers()
    if not ob.moulage.landmarks:
        bpy.ops.moulage.import_landmarks(filepath=str(LIVER / "landmarks.csv"))
    ob.moulage.tolerance, ob.moulage.landmark_tolerance = 0.3, 15.0
    return ob


def with_result():
    """The liver in the person's shape, by a short run."""
    ob = with_landmarks()
    if not has_result():
        ob.moulage.tet_count, ob.moulage.max_iterations = 2000, 20
        bpy.ops.moulage.reshape("EXEC_DEFAULT")
    return template()


def stopped_run(start, stop):
    """A run that is stopped before its end. One that ends by itself before it is reached is followed by one of twice
    the tets: machines differ."""
    for tet_count in (10000, 20000, 40000, 80000):
        template().moulage.tet_count, template().moulage.max_iterations = tet_count, 0
        bpy.ops.ed.undo_push(message="a long run")
        yield from start()
        yield from until(running, f"the run of {tet_count} tets")
        yield from stop()
        yield from until(lambda: not running(), "the end after it was stopped")
        if template().moulage.result.ending.startswith("Stopped"):
            return
        yield from undo()
        yield from pause()
    raise AssertionError(template().moulage.result.ending)


def surface_of_result():
    mesh_data, ob = part("mesh_data"), template()
    points = mesh_data.key_points(ob.data.shape_keys.key_blocks["Reshaped"])
    return BVHTree.FromPolygons(points.tolist(), mesh_data.triangles(ob).tolist())


def liver_label_map(path, spacing=3.0):
    """The result as a segmentation of the scan would show it: label 5 inside, on a grid of 3 mm."""
    mesh_data, ob = part("mesh_data"), template()
    points = mesh_data.key_points(ob.data.shape_keys.key_blocks["Reshaped"])
    tree, low = surface_of_result(), points.min(axis=0) - 2 * spacing
    size = numpy.ceil((points.max(axis=0) + 2 * spacing - low) / spacing).astype(int)
    labels = numpy.zeros(size[::-1], "<i2")
    for i in range(size[0]):
        for j in range(size[1]):
            start, inside = Vector((low + (i * spacing, j * spacing, 0)).tolist()), False
            while (hit := tree.ray_cast(start, Vector((0, 0, 1)))[0]) is not None:
                inside = not inside
                first = int(numpy.ceil((hit.z - low[2]) / spacing))
                labels[first:, j, i] = 5 if inside else 0
                start = hit + Vector((0, 0, 1e-3))
    directions = " ".join(f"({','.join(str(spacing * (a == b)) for b in range(3))})" for a in range(3))
    head = (
        f"NRRD0004\ntype: short\ndimension: 3\nspace: right-anterior-superior\nsizes: {size[0]} {size[1]} {size[2]}\n"
        f"space directions: {directions}\nspace origin: ({low[0]},{low[1]},{low[2]})\nencoding: raw\nendian: little\n\n"
    )
    path.write_bytes(head.encode() + labels.tobytes())
    return path
