# SPDX-License-Identifier: GPL-3.0-or-later
"""Markers: points of the person's surface, from the points of a mesh or point cloud, and from empties."""

import bpy
import numpy

from . import landmarks, mesh_data


def empties(collection):
    """The empties of a collection and those inside it, in a fixed order."""
    return sorted((ob for ob in collection.all_objects if ob.type == "EMPTY"), key=lambda ob: ob.name)


def points(template):
    """All markers of a template in world coordinates (n, 3): first those of the object."""
    data = template.moulage
    found = [numpy.zeros((0, 3))]
    if data.markers is not None and data.markers != template:
        found.append(mesh_data.world_points(data.markers))
    if data.marker_empties is not None:
        own = {e for l in data.landmarks for e in (l.template, l.target) if e is not None}
        places = [landmarks.position(e) for e in empties(data.marker_empties) if e not in own]
        found.append(numpy.array(places).reshape(-1, 3))
    return numpy.vstack(found)


def add_point(context, template, place):
    """A marker more, on the template's marker object; one is made where there is none."""
    ob = template.moulage.markers
    if ob is None or ob.type != "MESH" or len(ob.data.polygons) > 0:
        ob = template.moulage.markers = add_object(context, f"Markers of {template.name}", numpy.zeros((0, 3)))
    mesh = ob.data
    mesh.vertices.add(1)
    mesh.vertices[len(mesh.vertices) - 1].co = ob.matrix_world.inverted_safe() @ place
    mesh.update()


def add_object(context, name, positions):
    """A mesh of loose points; the template's markers."""
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(positions))
    mesh.vertices.foreach_set("co", numpy.ascontiguousarray(positions, numpy.float32).ravel())
    mesh.update()
    ob = bpy.data.objects.new(name, mesh)
    context.scene.collection.objects.link(ob)
    return ob


def add_empties(context, name, positions, size):
    """A collection of empties, one per marker."""
    collection = bpy.data.collections.new(name)
    context.scene.collection.children.link(collection)
    for number, place in enumerate(positions):
        empty = bpy.data.objects.new(f"{name} {number:04d}", None)
        empty.empty_display_type = "SPHERE"
        empty.empty_display_size = size
        empty.location = place
        collection.objects.link(empty)
    return collection
