# SPDX-License-Identifier: GPL-3.0-or-later
"""Landmarks: pairs of empties in a collection, one on the template and one on the person.

The empty on the template is its child and marks a place on the template at rest."""

import bpy
import mathutils
import numpy

from . import mesh_data, views

# An empty's size as a share of the template's diagonal.
_EMPTY_SIZE = 0.012
# What the circle on the person had for a size when it was made.
_USUAL_SIZE = "moulage_size"


def collection_of(context, template):
    """The collection for the template's landmarks, made where it is not there."""
    for landmark in template.moulage.landmarks:
        for empty in (landmark.template, landmark.target):
            if empty is not None and empty.users_collection:
                return empty.users_collection[0]
    name = f"Landmarks of {template.name}"
    found = context.scene.collection.children.get(name)
    if found is None:
        found = bpy.data.collections.new(name)
        context.scene.collection.children.link(found)
    return found


def free_name(template, wish=""):
    """The wished name, or the next number, or the wish with a number: not used yet."""
    used = {landmark.name for landmark in template.moulage.landmarks}
    if wish and wish not in used:
        return wish
    number = 1
    while (f"{wish}.{number:03d}" if wish else str(number)) in used:
        number += 1
    return f"{wish}.{number:03d}" if wish else str(number)


def flipped(name):
    """The name of the same place on the other side (hip.L and hip.R, left_hip and right_hip), or None."""
    other = bpy.utils.flip_name(name)
    return other if other != name else None


def without_partner(template):
    """The landmarks with a side whose partner on the other side is not there."""
    there = {landmark.name for landmark in template.moulage.landmarks}
    return [
        landmark for landmark in template.moulage.landmarks
        if landmark.template is not None and flipped(landmark.name) not in {None, *there}
    ]


def mirror(context, template, surface):
    """For each landmark with a side, its partner on the other side of the template's own x = 0, where there is
    none; at the place of `surface`, the library's of the template at rest, that is nearest to the mirrored one.
    Returns their names."""
    waiting = without_partner(template)
    if not waiting:
        return []
    own = mesh_data.matrix(template)
    places = numpy.array([position(landmark.template) for landmark in waiting])
    mirrored = mesh_data.transform(numpy.linalg.inv(own), places) * (-1, 1, 1)
    nearest = surface.closest_points(mesh_data.transform(own, mirrored))
    names = [flipped(landmark.name) for landmark in waiting]
    for name, place in zip(names, nearest):
        add(context, template, name, template_point=place)
    return names


def _empty(context, template, name, shape):
    size = numpy.ptp(mesh_data.world_points(template), axis=0)
    empty = bpy.data.objects.new(name, None)
    empty.empty_display_type = shape
    empty.empty_display_size = _EMPTY_SIZE * float(numpy.linalg.norm(size))
    empty.show_name = shape == "SPHERE"
    empty.show_in_front = True
    collection_of(context, template).objects.link(empty)
    return empty


def show_hold(landmark):
    """Lets the circle on the person be as large as the distance that is allowed."""
    empty = landmark.target
    if empty is None:
        return
    usual = empty.get(_USUAL_SIZE, empty.empty_display_size)
    empty[_USUAL_SIZE] = usual
    sizes = {"EXACT": 0.5 * usual, "WITHIN": landmark.within or 0.5 * usual, "HINT": usual}
    empty.empty_display_size = sizes[landmark.hold]


def within(template):
    """How far each landmark that is used may end from its target, whatever the markers say (n,); below 0 where the
    markers may say otherwise."""
    return numpy.array([{"EXACT": 0.0, "WITHIN": l.within, "HINT": -1.0}[l.hold] for l in used(template)])


def set_template_point(context, template, landmark, point):
    """Puts the landmark's empty at a world position on the template at rest."""
    empty = landmark.template
    if empty is None:
        empty = _empty(context, template, f"{landmark.name} (template)", "PLAIN_AXES")
        landmark.template = empty
        empty.parent = template
    # The size of the display follows the parent's scale; undo that.
    scale = max(abs(s) for s in template.matrix_world.to_scale()) or 1.0
    empty.scale = (1.0 / scale,) * 3
    empty.location = template.matrix_world.inverted_safe() @ mathutils.Vector(point)


def set_target(context, template, landmark, point):
    """Puts the landmark's other empty at a world position on the person."""
    empty = landmark.target
    if empty is None:
        empty = _empty(context, template, landmark.name, "SPHERE")
        landmark.target = empty
    empty.parent = None
    empty.location = point


def add(context, template, name="", template_point=None, target=None):
    """A new landmark; either of its points may come later."""
    landmark = template.moulage.landmarks.add()
    landmark.name = free_name(template, name)
    template.moulage.active_landmark = len(template.moulage.landmarks) - 1
    if template_point is not None:
        set_template_point(context, template, landmark, template_point)
    if target is not None:
        set_target(context, template, landmark, target)
    return landmark


def remove(template, index):
    """Removes a landmark with its empties."""
    landmark = template.moulage.landmarks[index]
    for empty in (landmark.template, landmark.target):
        if empty is not None:
            bpy.data.objects.remove(empty)
    template.moulage.landmarks.remove(index)
    template.moulage.active_landmark = max(0, min(index, len(template.moulage.landmarks) - 1))


def is_whole(landmark):
    return landmark.template is not None and landmark.target is not None


def incomplete(template):
    """The landmark that waits for its point on the person, or None."""
    for landmark in template.moulage.landmarks:
        if landmark.template is not None and landmark.target is None:
            return landmark
    return None


def used(template):
    """Landmarks that take part: they have both points."""
    return [l for l in template.moulage.landmarks if l.use and is_whole(l)]


def hide_parent_lines(context):
    """The dashed lines from each landmark to the template's origin only confuse."""
    for _window, _area, space in views.spaces(context):
        space.overlay.show_relationship_lines = False


def position(empty):
    return numpy.array(empty.matrix_world.translation, dtype=numpy.float64)


def pairs(template):
    """Template points and targets in world coordinates (n, 3), and weights (n,)."""
    found = used(template)
    points = [position(l.template) for l in found]
    targets = [position(l.target) for l in found]
    return (
        numpy.array(points).reshape(-1, 3),
        numpy.array(targets).reshape(-1, 3),
        numpy.array([l.weight for l in found]),
    )
