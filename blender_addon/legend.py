# SPDX-License-Identifier: GPL-3.0-or-later
"""The legend of a heat map, over the 3D view: the colours, ticks, and where the largest value lies."""

import math

import blf
import bpy
import numpy

from . import drawing, heat_map, mesh_data, once, properties, units

_WIDTH, _HEIGHT = 260, 14
# Above the panel of the last operation and below the figure.
_BOTTOM = 64
_STEPS = 64
_TICKS = 4
_TITLES = {"DISTANCE": "Distance of the markers", "STRETCH": "Stretch (1: unchanged)", "SURE": "Standard deviation"}


def draw():
    """For Blender's handler of 2D drawing."""
    context = bpy.context
    template = properties.template_of(context)
    if template is None or template.moulage.heat == "NONE":
        return
    kind, (low, high) = template.moulage.heat, template.moulage.result.heat_range
    largest = once.found("largest value", (template.name, kind), lambda: largest_value(template, kind))
    if high <= low or largest is None:
        return
    scale = context.preferences.system.ui_scale
    left = (_free_width(context) - _WIDTH * scale) / 2
    box = (left, _BOTTOM * scale, _WIDTH * scale, _HEIGHT * scale)
    _draw_bar(kind, low, high, box)
    size, unit = (1.0, "") if kind == "STRETCH" else units.unit(context.scene, high)
    _write(f"{_TITLES[kind]}{', ' + unit if unit else ''}", left, box[1] + box[3] + 8 * scale, scale)
    for value in ticks(kind, low / size, high / size):
        _mark(value, share(kind, value * size, low, high), box, scale)
    _mark_largest(largest / size, share(kind, largest, low, high), box, scale)


def share(kind, value, low, high):
    """Where a value lies between the ends of the scale, 0 to 1."""
    if kind == "STRETCH":
        value, low, high = (math.log(max(v, 1e-6)) for v in (value, low, high))
    return min(max((value - low) / (high - low), 0.0), 1.0)


def ticks(kind, low, high):
    """Round values from one end of the scale to the other; a stretch and its inverse are as far from 1."""
    if kind == "STRETCH":
        above = [1.0 + step for step in ticks("DISTANCE", 0.0, high - 1.0)[1:]]
        return [1.0, *above, *(1.0 / value for value in above)]
    step = 10.0 ** math.floor(math.log10((high - low) / _TICKS))
    step *= next(factor for factor in (1, 2, 5, 10) if (high - low) / (factor * step) <= _TICKS + 1e-9)
    return [step * number for number in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def largest_value(template, kind):
    """The largest value of a heat map: of a distance that of the markers themselves, if it is known."""
    values = heat_map.marker_distances(template) if kind == "DISTANCE" else None
    if values is None:
        values = mesh_data.attribute(template.data, heat_map.SOURCES[kind])
    return float(values.max()) if values is not None and len(values) and values.max() >= 0 else None


def _free_width(context):
    """The view's width beside the side bar, which lies over it."""
    bars = [region.width for region in context.area.regions if region.type == "UI" and region.width > 1]
    return context.region.width - (bars[0] if bars else 0)


def _draw_bar(kind, low, high, box):
    left, bottom, width, height = box
    shares = numpy.linspace(0, 1, _STEPS)
    values = low * (high / low) ** shares if kind == "STRETCH" else low + (high - low) * shares
    xs = (left + width * shares).repeat(2)
    ys = numpy.tile([bottom, bottom + height], _STEPS)
    drawing.flat("TRI_STRIP", xs, ys, drawing.to_display(heat_map.colours(kind, values, low, high)).repeat(2, axis=0))


def _mark(value, where, box, scale):
    """A tick below the bar, and its value."""
    left, bottom, width, _height = box
    x = left + width * where
    drawing.flat("LINES", [x, x], [bottom, bottom - 4 * scale], drawing.WHITE)
    _write(units.number(round(value, 6)), x, bottom - 18 * scale, scale, centred=True)


def _mark_largest(value, where, box, scale):
    """A pointer above the bar, and the value beside the bar."""
    left, bottom, width, height = box
    x, y, half = left + width * where, bottom + height, 4 * scale
    drawing.flat("TRIS", [x, x - half, x + half], [y, y + 2 * half, y + 2 * half], drawing.WHITE)
    _write(f"largest {units.number(value)}", left + width + 10 * scale, bottom + 1 * scale, scale)


def _write(text, x, y, scale, centred=False):
    font = 0
    size = 12 * scale
    blf.size(font, size) if bpy.app.version >= (4, 0, 0) else blf.size(font, size, 72)
    blf.color(font, 1, 1, 1, 1)
    blf.position(font, x - (blf.dimensions(font, text)[0] / 2 if centred else 0), y, 0)
    blf.draw(font, text)
