# SPDX-License-Identifier: GPL-3.0-or-later
"""Lengths in words, and which unit coordinates are in."""

# Longer than any part of a body, in millimetres.
_TOO_LONG = 10_000


def millimetres(scene, length):
    """A length of the scene in millimetres: one Blender unit is `scale_length` metres."""
    return length * scene.unit_settings.scale_length * 1000.0


def text(scene, length):
    """A length of the scene for reading, such as "0.31 mm"."""
    value, unit = millimetres(scene, length), "mm"
    if value >= _TOO_LONG:
        value, unit = value / 1000, "m"
    return f"{value:.0f} {unit}" if value >= 1000 else f"{value:.3g} {unit}"


def are_millimetres(scene, size):
    """Whether something of this size has coordinates in millimetres, in a scene of another unit."""
    return millimetres(scene, size) > _TOO_LONG
