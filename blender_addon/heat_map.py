# SPDX-License-Identifier: GPL-3.0-or-later
"""Heat maps: values per vertex turned into a colour attribute, and the viewport that shows it."""

import numpy

from . import mesh_data, views
from .library import calls

COLOUR = "moulage_heat"
# The distance of each marker, on the template object.
_MARKER_DISTANCES = "moulage_marker_distances"
# The viewport's colours and light before a heat map was shown, on the template object.
_SHADING = "moulage_shading"
SOURCES = {"DISTANCE": "moulage_distance", "STRETCH": "moulage_stretch", "SURE": "moulage_sd_normal"}
# The property with the end of each scale.
LIMITS = {"DISTANCE": "heat_limit", "STRETCH": "stretch_limit", "SURE": "sure_limit"}
_NO_VALUE = (0.35, 0.35, 0.35)

# Linear colours at equal steps. Distance: dark blue (on the surface) to yellow (far off), after viridis.
_DISTANCE = numpy.array([
    (0.058, 0.0003, 0.089), (0.042, 0.085, 0.258), (0.0152, 0.279, 0.262), (0.109, 0.578, 0.127),
    (0.982, 0.799, 0.0185),
])
# Standard deviation: white (sure) to purple.
_SURE = numpy.array([(0.9, 0.9, 0.85), (0.62, 0.45, 0.72), (0.38, 0.16, 0.55), (0.2, 0.04, 0.36), (0.09, 0.01, 0.2)])
# Stretch: blue (pressed) over white (unchanged) to red (stretched).
_STRETCH = numpy.array([(0.02, 0.08, 0.45), (0.25, 0.45, 0.75), (0.85, 0.85, 0.85), (0.75, 0.25, 0.15), (0.4, 0.01, 0.02)])
_TABLES = {"DISTANCE": _DISTANCE, "STRETCH": _STRETCH, "SURE": _SURE}


def spread(points, triangles, markers, distances):
    """The distance of the nearest markers at each vertex of a surface (n,), weighted by nearness; -1 where no
    marker is near."""
    if len(markers) == 0:
        return numpy.full(len(points), -1.0)
    with calls() as library:
        return numpy.nan_to_num(library.TriMesh(points, triangles).interpolate(markers, distances), nan=-1.0)


def _interpolate(table, share):
    place = numpy.clip(share, 0.0, 1.0) * (len(table) - 1)
    low = numpy.minimum(place.astype(int), len(table) - 2)
    rest = (place - low)[:, None]
    return table[low] * (1 - rest) + table[low + 1] * rest


def keep_marker_distances(template, distances):
    template[_MARKER_DISTANCES] = distances.tolist()


def marker_distances(template):
    """The distance of each marker after the last run (n,), or None."""
    kept = template.get(_MARKER_DISTANCES)
    return None if kept is None else numpy.array(kept)


def value_range(kind, values, limit=0.0):
    """The values at the two ends of the scale: up to `limit`, or if it is 0 up to the 99th percentile. A stretch goes
    as far down as up, so that 1 is in the middle."""
    known = values[values >= 0]
    if kind == "STRETCH":
        if limit <= 1.0 and len(known):
            limit = max(float(numpy.percentile(known, 99)), 1 / max(float(numpy.percentile(known, 1)), 1e-6))
        factor = max(limit, 1.01)
        return 1 / factor, factor
    if limit <= 0.0 and len(known):
        limit = float(numpy.percentile(known, 99))
    return 0.0, max(limit, 1e-12)


def colours(kind, values, low, high):
    """Linear RGBA (n, 4) of values."""
    values = numpy.asarray(values, dtype=numpy.float64)
    if kind == "STRETCH":
        share = numpy.log(numpy.maximum(values, 1e-6) / low) / numpy.log(high / low)
    else:
        share = (values - low) / (high - low)
    rgb = _interpolate(_TABLES[kind], share)
    rgb[values < 0] = _NO_VALUE
    return numpy.column_stack([rgb, numpy.ones(len(rgb))])


def paint(template):
    """Writes the colour attribute for the chosen heat map and makes it the active one."""
    kind = template.moulage.heat
    values = mesh_data.attribute(template.data, SOURCES.get(kind, ""))
    if values is None:
        return
    low, high = value_range(kind, values, getattr(template.moulage, LIMITS[kind]))
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
    """Vertex colours without light, which would change them; or what there was before."""
    if on and shading.color_type != "VERTEX":
        template[_SHADING] = f"{shading.color_type} {shading.light}"
        shading.color_type, shading.light = "VERTEX", "FLAT"
    elif not on and shading.color_type == "VERTEX":
        shading.color_type, shading.light = template.get(_SHADING, "MATERIAL STUDIO").split()
