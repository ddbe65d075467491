# SPDX-License-Identifier: GPL-3.0-or-later
"""What is drawn over the 3D view: markers as dots, landmark pairs as lines, the legend of a heat map."""

import blf
import bpy
import gpu
import mathutils
import numpy
from gpu_extras.batch import batch_for_shader

from . import heat_map, landmarks, library, markers, mesh_data, properties, result, scan, units

_LIMIT = 100_000
# How far dots are drawn in front of their place, as a share of the markers' extent.
_LIFT = 0.01
_PLAIN = (1.0, 0.55, 0.1, 1.0)
_LINE = (1.0, 0.85, 0.2, 1.0)
_CONTOUR = (0.2, 1.0, 0.4, 1.0)
_LEGEND_WIDTH, _LEGEND_HEIGHT = 220, 14

_handles = []
# The template's outline on the slices drawn last, and what it was made from.
_cuts = {"stamp": None, "ends": None}
# The markers drawn last, and what they were made from.
_dots = {"stamp": None, "batch": None}


def _shader(name):
    return gpu.shader.from_builtin(name if bpy.app.version >= (4, 0, 0) else f"3D_{name}")


def to_display(colours):
    """sRGB of linear colours, for drawing."""
    rgb = numpy.clip(colours[:, :3], 0, 1)
    rgb = numpy.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * rgb ** (1 / 2.4) - 0.055)
    return numpy.column_stack([rgb, colours[:, 3]])


def _marker_colours(template, count):
    distances = template.get(result.MARKER_DISTANCES)
    if distances is None or len(distances) != count:
        return numpy.tile(_PLAIN, (count, 1))
    values = numpy.array(distances)
    low, high = heat_map.value_range("DISTANCE", values)
    return to_display(heat_map.colours("DISTANCE", values, low, high))


def _draw_markers(template):
    points = markers.points(template)
    if len(points) == 0 or len(points) > _LIMIT:
        return
    colours = _marker_colours(template, len(points))
    shader = _shader("FLAT_COLOR")
    stamp = hash((points.tobytes(), colours.tobytes()))
    if stamp != _dots["stamp"]:
        content = {"pos": points.astype(numpy.float32), "color": colours.astype(numpy.float32)}
        _dots["batch"] = batch_for_shader(shader, "POINTS", content)
        _dots["stamp"] = stamp
    gpu.state.point_size_set(6.0)
    gpu.state.depth_test_set("LESS_EQUAL")
    with gpu.matrix.push_pop():
        # A little towards the viewer: dots that lie on the surface are not cut in half by it.
        size = float(numpy.ptp(points, axis=0).max())
        gpu.matrix.translate(bpy.context.region_data.view_rotation @ mathutils.Vector((0, 0, _LIFT * size)))
        _dots["batch"].draw(shader)
    gpu.state.depth_test_set("NONE")


def _draw_pairs(template):
    ends = []
    for landmark in template.moulage.landmarks:
        if landmark.use and landmarks.is_whole(landmark):
            start = landmark.moved if landmark.residual >= 0 else landmarks.position(landmark.template)
            ends += [tuple(start), landmarks.position(landmark.target)]
    if ends:
        shader = _shader("UNIFORM_COLOR")
        batch = batch_for_shader(shader, "LINES", {"pos": numpy.array(ends, dtype=numpy.float32)})
        shader.uniform_float("color", _LINE)
        batch.draw(shader)


def _shown_points(template):
    """The template as the result's slider shows it, in world coordinates (n, 3)."""
    keys, name = template.data.shape_keys, template.moulage.result.key
    points = mesh_data.rest_points(template.data)
    key = keys.key_blocks.get(name) if keys and name else None
    if key is not None and key.value > 0:
        points = points + key.value * (mesh_data.key_points(key) - points)
    return mesh_data.transform(mesh_data.matrix(template), points.astype(numpy.float64))


def _contour(scene, template):
    """Line segments in which the visible slices cut the template, as pairs of points."""
    places = [(e.matrix_world.translation, e.matrix_world.col[2].xyz) for e in scan.slices(scene).values()
              if e.visible_get()]
    if not places:
        return None
    points, faces = _shown_points(template), mesh_data.triangles(template)
    stamp = hash((points.tobytes(), faces.tobytes(), str(places)))
    if stamp != _cuts["stamp"]:
        ends = []
        with library.calls() as package:
            surface = package.TriMesh(points, faces)
            for place, normal in places:
                for line in package.section(surface, place, normal):
                    ends.append(numpy.stack([line[:-1], line[1:]], axis=1).reshape(-1, 3))
        _cuts.update(stamp=stamp, ends=numpy.vstack(ends).astype(numpy.float32) if ends else None)
    return _cuts["ends"]


def _draw_contour(context, template):
    if not context.scene.moulage.show_contour or len(template.data.vertices) > _LIMIT or template.mode != "OBJECT":
        return
    try:
        ends = _contour(context.scene, template)
    except library.Wrong:
        return
    if ends is not None:
        shader = _shader("UNIFORM_COLOR")
        batch = batch_for_shader(shader, "LINES", {"pos": ends})
        shader.uniform_float("color", _CONTOUR)
        gpu.state.line_width_set(2.0)
        batch.draw(shader)
        gpu.state.line_width_set(1.0)


def _draw_view():
    template = properties.template_of(bpy.context)
    if template is None:
        return
    if template.moulage.show_markers:
        _draw_markers(template)
    _draw_pairs(template)
    _draw_contour(bpy.context, template)


def _draw_legend():
    context = bpy.context
    template = properties.template_of(context)
    if template is None or template.moulage.heat == "NONE":
        return
    kind, (low, high) = template.moulage.heat, template.moulage.result.heat_range
    if high <= low:
        return
    scale = context.preferences.system.ui_scale
    width, height = _LEGEND_WIDTH * scale, _LEGEND_HEIGHT * scale
    left, bottom = 30 * scale, 50 * scale
    steps = 64
    shares = numpy.linspace(0, 1, steps)
    values = low * (high / low) ** shares if kind == "STRETCH" else low + (high - low) * shares
    colours = to_display(heat_map.colours(kind, values, low, high)).repeat(2, axis=0)
    xs = (left + width * shares).repeat(2)
    ys = numpy.tile([bottom, bottom + height], steps)
    content = {
        "pos": numpy.column_stack([xs, ys, numpy.zeros_like(xs)]).astype(numpy.float32),
        "color": colours.astype(numpy.float32),
    }
    shader = _shader("SMOOTH_COLOR")
    batch_for_shader(shader, "TRI_STRIP", content).draw(shader)
    _write_texts(context.scene, kind, low, high, (left, bottom, width, height), scale)


def _write_texts(scene, kind, low, high, box, scale):
    left, bottom, width, height = box
    if kind == "STRETCH":
        title, ends = "Stretch (1: unchanged)", (f"{low:.2f}", f"{high:.2f}")
    else:
        title, ends = "Distance of the markers", (units.text(scene, low), units.text(scene, high))
    font = 0
    size = 12 * scale
    blf.size(font, size) if bpy.app.version >= (4, 0, 0) else blf.size(font, size, 72)
    blf.color(font, 1, 1, 1, 1)
    places = ((title, left), (ends[0], left), (ends[1], left + width - blf.dimensions(font, ends[1])[0]))
    for (text, x), y in zip(places, (bottom + height + 6 * scale, bottom - 16 * scale, bottom - 16 * scale)):
        blf.position(font, x, y, 0)
        blf.draw(font, text)


def register():
    add = bpy.types.SpaceView3D.draw_handler_add
    _handles.append(add(_draw_view, (), "WINDOW", "POST_VIEW"))
    _handles.append(add(_draw_legend, (), "WINDOW", "POST_PIXEL"))


def unregister():
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    _dots.update(stamp=None, batch=None)
    _cuts.update(stamp=None, ends=None)
