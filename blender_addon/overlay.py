# SPDX-License-Identifier: GPL-3.0-or-later
"""What is drawn over the 3D view: markers as dots, landmark pairs as lines, outlines on slices. While one slice is
looked at, only what is near it."""

import bpy
import gpu
import mathutils
import numpy

from . import (
    drawing, heat_map, landmarks, legend, library, markers, mesh_data, once, properties, scan, skeleton_properties, slice_view,
)

_LIMIT = 100_000
# How far dots are drawn in front of their place, as a share of the markers' extent.
_LIFT = 0.01
_DOT, _RIM = 6.0, 11.0
_PLAIN = (1.0, 0.55, 0.1, 1.0)
_LINE = (1.0, 0.85, 0.2, 1.0)
_CONTOUR = (0.2, 1.0, 0.4, 1.0)

_handles = []


def _marker_colours(template, count):
    """A colour for each marker (n, 4), and the number of the one that is farthest off, or None."""
    values = heat_map.marker_distances(template)
    if values is None or len(values) != count:
        return numpy.tile(_PLAIN, (count, 1)), None
    ends = heat_map.value_range("DISTANCE", values, template.moulage.heat_limit)
    return drawing.to_display(heat_map.colours("DISTANCE", values, *ends)), int(values.argmax())


def _dots(template, slab):
    """A batch of the markers near the slice that is looked at, or of all, two for the one that is farthest off, its rim
    and itself, and the markers' extent; None where there are none."""
    points = markers.points(template)
    if not 0 < len(points) <= _LIMIT:
        return None
    colours, farthest = _marker_colours(template, len(points))
    near = numpy.ones(len(points), dtype=bool) if slab is None else slab.holds(points)
    if not near.any():
        return None
    largest = ()
    if farthest is not None and near[farthest]:
        place = points[[farthest]]
        largest = drawing.dots(place, numpy.array([drawing.WHITE])), drawing.dots(place, colours[[farthest]])
    return drawing.dots(points[near], colours[near]), largest, float(numpy.ptp(points, axis=0).max())


def _draw_markers(context, template, slab):
    dots = once.found("dots", (template.name, slab), lambda: _dots(template, slab))
    if dots is None:
        return
    batch, largest, size = dots
    gpu.state.depth_test_set("LESS_EQUAL")
    with gpu.matrix.push_pop():
        # A little towards the viewer: dots that lie on the surface are not cut in half by it.
        gpu.matrix.translate(context.region_data.view_rotation @ mathutils.Vector((0, 0, _LIFT * size)))
        gpu.state.point_size_set(_DOT)
        batch.draw(drawing.shader("FLAT_COLOR"))
    gpu.state.depth_test_set("NONE")
    # Seen also where the template hides it.
    for dot, width in zip(largest, (_RIM, _DOT)):
        gpu.state.point_size_set(width)
        dot.draw(drawing.shader("FLAT_COLOR"))


def _draw_pairs(template, slab):
    ends = []
    for landmark in template.moulage.landmarks:
        if landmark.use and landmarks.is_whole(landmark):
            start = landmark.moved if landmark.residual >= 0 else landmarks.position(landmark.template)
            pair = numpy.array([tuple(start), landmarks.position(landmark.target)])
            if slab is None or slab.holds(pair).any():
                ends.append(pair)
    if ends:
        drawing.segments(numpy.vstack(ends), _LINE)


def _outlined(context):
    """The surfaces whose outlines are shown: the template, or the person's bones after a registration."""
    template = properties.template_of(context)
    armature = skeleton_properties.skeleton_of(context)
    person = armature.moulage_skeleton.person if armature is not None else None
    bones = [ob for ob in person.children if ob.type == "MESH"] if person is not None else []
    found = ([template] if template is not None else []) + bones
    return found if sum(len(ob.data.vertices) for ob in found) <= _LIMIT and context.mode == "OBJECT" else []


def _contour(context, places):
    """Line segments in which the slices cut what is outlined, as pairs of points (2 n, 3)."""
    ends = [numpy.zeros((0, 3))]
    try:
        with library.calls() as package:
            for ob in _outlined(context):
                surface = package.TriMesh(mesh_data.shown_points(ob), mesh_data.triangles(ob))
                for place, normal in places:
                    for line in package.section(surface, place, normal):
                        ends.append(numpy.stack([line[:-1], line[1:]], axis=1).reshape(-1, 3))
    except library.Wrong:
        # Reshape says what is wrong with the mesh.
        pass
    return numpy.vstack(ends)


def _draw_contour(context):
    shown = [empty.matrix_world for empty in scan.slices(context.scene).values() if empty.visible_get()]
    places = tuple((tuple(frame.translation), tuple(frame.col[2].xyz)) for frame in shown)
    if places:
        ends = once.found("contour", places, lambda: _contour(context, places))
        if len(ends):
            drawing.segments(ends, _CONTOUR, width=2.0)


def _draw_view():
    context = bpy.context
    template = properties.template_of(context)
    if template is not None:
        # It asks for the scan's file.
        slab = once.found("slab", context.scene.name, lambda: slice_view.slab(context.scene))
        if template.moulage.show_markers:
            _draw_markers(context, template, slab)
        _draw_pairs(template, slab)
    if context.scene.moulage.show_contour:
        _draw_contour(context)


def register():
    add = bpy.types.SpaceView3D.draw_handler_add
    _handles.append(add(_draw_view, (), "WINDOW", "POST_VIEW"))
    _handles.append(add(legend.draw, (), "WINDOW", "POST_PIXEL"))


def unregister():
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
