# SPDX-License-Identifier: GPL-3.0-or-later
"""Looking at one slice of the scan: all else is hidden until it is left, except what is drawn near the slice."""

from dataclasses import dataclass

import numpy

from . import landmarks, mesh_data, properties, scan, views
from .library import Wrong

# Marks objects that are hidden meanwhile; the value says whether they were selected.
_HIDDEN = "moulage_hidden"


@dataclass(frozen=True)
class Slab:
    """What counts as near a slice."""

    place: tuple
    normal: tuple
    half: float

    def holds(self, points):
        """Whether points (n, 3) lie in it (n,)."""
        return numpy.abs((points - self.place) @ self.normal) <= self.half


def looked_at(scene):
    """The slice's empty that is looked at, or None."""
    return scan.slices(scene).get(scene.moulage.looking_at)


def slab(scene):
    """The neighbourhood of the slice that is looked at, a voxel to each side, or None."""
    empty = looked_at(scene)
    if empty is None:
        return None
    try:
        _volume, info = scan.volume(scene)
    except Wrong:
        return None
    frame = mesh_data.matrix(empty)
    return Slab(tuple(frame[:3, 3]), tuple(frame[:3, 2]), float(info["spacing"].max()) * scan.unit(scene))


def enter(context, view):
    """Hides all but a slice and the landmarks near it."""
    leave(context)
    scene = context.scene
    empty = scan.slices(scene)[view]
    empty.hide_viewport = False
    scene.moulage.looking_at = view
    kept = {empty, *_landmarks_near(context)}
    for ob in context.view_layer.objects:
        if ob not in kept and ob.visible_get():
            ob[_HIDDEN] = ob.select_get()
            views.show(context, [ob], False)
    context.view_layer.objects.active = empty


def leave(context):
    """Shows again what was hidden."""
    context.scene.moulage.looking_at = ""
    for ob in context.view_layer.objects:
        if _HIDDEN in ob:
            views.show(context, [ob], True)
            ob.select_set(ob[_HIDDEN])
            del ob[_HIDDEN]


def _landmarks_near(context):
    """The empties on the person that lie near the slice."""
    template, near = properties.template_of(context), slab(context.scene)
    if template is None or near is None:
        return []
    empties = [landmark.target for landmark in template.moulage.landmarks if landmark.target is not None]
    return [empty for empty in empties if near.holds(landmarks.position(empty)[None])[0]]
