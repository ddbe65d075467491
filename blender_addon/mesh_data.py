# SPDX-License-Identifier: GPL-3.0-or-later
"""Points and triangles between Blender and numpy. Points leave Blender in world coordinates and
double precision, and come back in the object's own."""

import numpy


def matrix(ob):
    """World from object (4, 4)."""
    return numpy.array(ob.matrix_world, dtype=numpy.float64)


def transform(frame, points):
    """Points (n, 3) moved by a 4x4 matrix."""
    return points @ frame[:3, :3].T + frame[:3, 3]


def rest_points(mesh):
    """The vertices at rest (n, 3), float32: the first shape key where there are any."""
    keys = mesh.shape_keys
    return key_points(keys.reference_key) if keys else _get(mesh.vertices, "co")


def shown_points(ob):
    """The vertices of a mesh as its shape keys show them, in world coordinates (n, 3)."""
    points = rest_points(ob.data)
    keys = ob.data.shape_keys
    for key in keys.key_blocks[1:] if keys else ():
        if key.value != 0 and not key.mute:
            points = points + key.value * (key_points(key) - key_points(key.relative_key))
    return transform(matrix(ob), points.astype(numpy.float64))


def key_points(key):
    # Fast, but only since Blender 4.1.
    return _get(key.points if hasattr(key, "points") else key.data, "co")


def set_key_points(key, points):
    flat = numpy.ascontiguousarray(points, numpy.float32).ravel()
    (key.points if hasattr(key, "points") else key.data).foreach_set("co", flat)


def _get(collection, name):
    flat = numpy.empty(3 * len(collection), numpy.float32)
    collection.foreach_get(name, flat)
    return flat.reshape(-1, 3)


def world_points(ob):
    """All points of a mesh at rest or of a point cloud, in world coordinates (n, 3)."""
    if ob.type == "POINTCLOUD":
        position = ob.data.attributes.get("position")
        points = _get(position.data, "vector") if position else numpy.zeros((0, 3), numpy.float32)
    else:
        points = rest_points(ob.data)
    return transform(matrix(ob), points.astype(numpy.float64))


def triangles(ob):
    """The triangles of a mesh (m, 3), counter-clockwise seen from outside also when the object is
    mirrored by its scale."""
    mesh = ob.data
    mesh.calc_loop_triangles()
    flat = numpy.empty(3 * len(mesh.loop_triangles), numpy.int32)
    mesh.loop_triangles.foreach_get("vertices", flat)
    found = flat.reshape(-1, 3)
    if numpy.linalg.det(matrix(ob)[:3, :3]) < 0:
        found = found[:, ::-1]
    return found


def group_weights(ob, name):
    """The weight of each vertex in a vertex group (n,); zeros outside; None without that group."""
    group = ob.vertex_groups.get(name)
    if group is None:
        return None
    weights = numpy.zeros(len(ob.data.vertices))
    for vertex in ob.data.vertices:
        for element in vertex.groups:
            if element.group == group.index:
                weights[vertex.index] = element.weight
    return weights


def set_attribute(mesh, name, kind, values):
    """Writes one value or colour per vertex, making the attribute where it is not there."""
    attribute = mesh.attributes.get(name)
    if attribute is not None and (attribute.data_type != kind or attribute.domain != "POINT"):
        mesh.attributes.remove(attribute)
        attribute = None
    if attribute is None:
        attribute = mesh.attributes.new(name, kind, "POINT")
    flat = numpy.ascontiguousarray(values, numpy.float32).ravel()
    attribute.data.foreach_set("color" if kind == "FLOAT_COLOR" else "value", flat)


def attribute(mesh, name):
    """The values of a float attribute (n,), or None."""
    found = mesh.attributes.get(name)
    if found is None or found.data_type != "FLOAT" or found.domain != "POINT":
        return None
    values = numpy.empty(len(found.data), numpy.float32)
    found.data.foreach_get("value", values)
    return values
