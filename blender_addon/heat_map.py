# SPDX-License-Identifier: GPL-3.0-or-later
"""Heat maps: values per vertex turned into a colour attribute, and the viewport that shows it."""

import numpy
from mathutils.kdtree import KDTree

from . import mesh_data, views

COLOUR = "moulage_heat"
SOURCES = {"DISTANCE": "moulage_distance", "STRETCH": "moulage_stretch"}
# How many markers around a vertex count.
_NEIGHBOURS = 4
# Farther from its nearest marker than so many times the markers' usual spacing, a vertex has no value.
_REACH = 3.0
# Vertices within so many spacings of each other share a value.
_CELL = 0.1
_NO_VALUE = (0.35, 0.35, 0.35)

# Linear colours at equal steps. Distance: dark blue (on the surface) to yellow (far off), after viridis.
_DISTANCE = numpy.array([
    (0.058, 0.0003, 0.089), (0.042, 0.085, 0.258), (0.0152, 0.279, 0.262), (0.109, 0.578, 0.127),
    (0.982, 0.799, 0.0185),
])
# Stretch: blue (pressed) over white (unchanged) to red (stretched).
_STRETCH = numpy.array([(0.02, 0.08, 0.45), (0.25, 0.45, 0.75), (0.85, 0.85, 0.85), (0.75, 0.25, 0.15), (0.4, 0.01, 0.02)])


def spread(points, markers, distances):
    """The distance of the nearest markers at each point (n,), weighted by nearness; -1 where no marker
    is near."""
    if len(markers) == 0 or len(points) == 0:
        return numpy.full(len(points), -1.0)
    tree = KDTree(len(markers))
    for index, place in enumerate(markers):
        tree.insert(place, index)
    tree.balance()
    gaps = [tree.find_n(place, 2)[-1][2] for place in markers[:: max(1, len(markers) // 500)]]
    spacing = max(float(numpy.median(gaps)), 1e-6 * float(numpy.ptp(points, axis=0).max()), 1e-30)
    places, cell_of_point = _cells(points, _CELL * spacing)
    return numpy.array([_near_value(tree, place, distances, spacing) for place in places])[cell_of_point]


def _cells(points, size):
    """One point of each cube of a grid that holds some, and the number of each point's cube: a fine mesh
    needs no value of its own at every vertex."""
    grid = numpy.floor((points - points.min(axis=0)) / size).astype(numpy.int64)
    counts = grid.max(axis=0) + 1
    number = (grid[:, 0] * counts[1] + grid[:, 1]) * counts[2] + grid[:, 2]
    _, first, cell_of_point = numpy.unique(number, return_index=True, return_inverse=True)
    return points[first], cell_of_point.ravel()


def _near_value(tree, place, distances, spacing):
    near = tree.find_n(place, _NEIGHBOURS)
    if near[0][2] > _REACH * spacing:
        return -1.0
    weights = [1.0 / (gap * gap + 0.01 * spacing * spacing) for _, _, gap in near]
    return sum(w * distances[n[1]] for w, n in zip(weights, near)) / sum(weights)


def _interpolate(table, share):
    place = numpy.clip(share, 0.0, 1.0) * (len(table) - 1)
    low = numpy.minimum(place.astype(int), len(table) - 2)
    rest = (place - low)[:, None]
    return table[low] * (1 - rest) + table[low + 1] * rest


def value_range(kind, values):
    """The values at the two ends of the scale."""
    known = values[values >= 0]
    if len(known) == 0:
        return 0.0, 1.0
    if kind == "STRETCH":
        # As far down as up, so that 1 is in the middle.
        factor = max(float(numpy.percentile(known, 99)), 1 / max(float(numpy.percentile(known, 1)), 1e-6), 1.01)
        return 1 / factor, factor
    return 0.0, max(float(numpy.percentile(known, 99)), 1e-12)


def colours(kind, values, low, high):
    """Linear RGBA (n, 4) of values."""
    values = numpy.asarray(values, dtype=numpy.float64)
    if kind == "STRETCH":
        share = numpy.log(numpy.maximum(values, 1e-6) / low) / numpy.log(high / low)
    else:
        share = (values - low) / (high - low)
    rgb = _interpolate(_STRETCH if kind == "STRETCH" else _DISTANCE, share)
    rgb[values < 0] = _NO_VALUE
    return numpy.column_stack([rgb, numpy.ones(len(rgb))])


def paint(template):
    """Writes the colour attribute for the chosen heat map and makes it the active one."""
    kind = template.moulage.heat
    values = mesh_data.attribute(template.data, SOURCES.get(kind, ""))
    if values is None:
        return
    low, high = value_range(kind, values)
    template.moulage.result.heat_range = (low, high)
    mesh_data.set_attribute(template.data, COLOUR, "FLOAT_COLOR", colours(kind, values, low, high))
    attributes = template.data.color_attributes
    attributes.active_color = attributes[COLOUR]
    template.data.update()


def show(context, template, kind):
    """Chooses a heat map and sets the viewports; "NONE" puts the viewports back."""
    template.moulage.heat = kind
    paint(template)
    for _window, _area, space in views.spaces(context):
        _set_shading(template, space.shading, kind != "NONE")


def _set_shading(template, shading, on):
    if on and shading.color_type != "VERTEX":
        template["moulage_shading"] = shading.color_type
        shading.color_type = "VERTEX"
    elif not on and shading.color_type == "VERTEX":
        shading.color_type = template.get("moulage_shading", "MATERIAL")
