# SPDX-License-Identifier: GPL-3.0-or-later
"""Lengths in words, in the scene's unit, and which unit coordinates are in."""

# Longer than any part of a body, in millimetres.
_TOO_LONG = 10_000
# Millimetres of Blender's length units, and what they are called. Adaptive and metres, Blender's own default, are
# read in millimetres up to the size of a person: nobody says 0.00031 m.
_METRIC = {
    "KILOMETERS": (1e6, "km"), "CENTIMETERS": (10.0, "cm"), "MILLIMETERS": (1.0, "mm"), "MICROMETERS": (1e-3, "\u00b5m"),
}
_IMPERIAL = {"MILES": (1_609_344.0, "mi"), "FEET": (304.8, "ft"), "THOU": (0.0254, "thou")}
_INCHES = (25.4, "in")
_CUBED = "\u00b3"


def millimetres(scene, length):
    """A length of the scene in millimetres: one Blender unit is `scale_length` metres."""
    return length * scene.unit_settings.scale_length * 1000.0


def unit(scene, longest):
    """The unit for lengths up to `longest`: how many lengths of the scene it is, and its name."""
    settings = scene.unit_settings
    if settings.system == "NONE":
        return 1.0, ""
    if settings.system == "IMPERIAL":
        size, name = _IMPERIAL.get(settings.length_unit, _INCHES)
    else:
        person = (1000.0, "m") if millimetres(scene, longest) >= _TOO_LONG else (1.0, "mm")
        size, name = _METRIC.get(settings.length_unit, person)
    return size / millimetres(scene, 1.0), name


def texts(scene, *lengths):
    """Lengths of the scene for reading side by side, in one unit, such as "0.31 mm"."""
    size, name = unit(scene, max(lengths))
    return [f"{number(length / size)} {name}".rstrip() for length in lengths]


def text(scene, length):
    """A length of the scene for reading."""
    return texts(scene, length)[0]


def volume(scene, size):
    """A volume of the scene for reading: up to that of a person in millilitres, where lengths are millimetres."""
    length, name = unit(scene, size ** (1 / 3))
    if name == "mm":
        return f"{number(size / length**3 / 1000)} ml"
    return f"{number(size / length**3)} {name + _CUBED if name else ''}".rstrip()


def number(value):
    """Three digits, never as a power of ten."""
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}" if abs(value) >= 1e-4 or value == 0 else f"{value:.6f}"


def are_millimetres(scene, size):
    """Whether something of this size has coordinates in millimetres, in a scene of another unit."""
    return millimetres(scene, size) > _TOO_LONG
