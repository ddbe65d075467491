# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines, dots and areas drawn with the graphics card, in colours as they are seen (sRGB)."""

import bpy
import gpu
import numpy
from gpu_extras.batch import batch_for_shader

WHITE = (1.0, 1.0, 1.0, 1.0)


def shader(name):
    """A shader of Blender's; before Blender 4 they had other names."""
    return gpu.shader.from_builtin(name if bpy.app.version >= (4, 0, 0) else f"3D_{name}")


def to_display(colours):
    """sRGB of linear colours."""
    rgb = numpy.clip(colours[:, :3], 0, 1)
    rgb = numpy.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * rgb ** (1 / 2.4) - 0.055)
    return numpy.column_stack([rgb, colours[:, 3]])


def dots(points, colours):
    """A batch of points (n, 3), each of its colour (n, 4), to be drawn with the shader FLAT_COLOR."""
    content = {"pos": points.astype(numpy.float32), "color": colours.astype(numpy.float32)}
    return batch_for_shader(shader("FLAT_COLOR"), "POINTS", content)


def segments(ends, colour, width=1.0):
    """Draws lines in 3D, each between two of `ends` (2 n, 3)."""
    own = shader("UNIFORM_COLOR")
    batch = batch_for_shader(own, "LINES", {"pos": numpy.asarray(ends, dtype=numpy.float32)})
    own.uniform_float("color", colour)
    gpu.state.line_width_set(width)
    batch.draw(own)
    gpu.state.line_width_set(1.0)


def flat(kind, xs, ys, colours):
    """Draws LINES, TRIS or a TRI_STRIP in pixels of the region; one colour, or one for each point (n, 4)."""
    places = numpy.column_stack([xs, ys, numpy.zeros(len(xs))]).astype(numpy.float32)
    colours = numpy.broadcast_to(numpy.asarray(colours, dtype=numpy.float32), (len(xs), 4))
    own = shader("SMOOTH_COLOR")
    batch_for_shader(own, kind, {"pos": places, "color": numpy.ascontiguousarray(colours)}).draw(own)
