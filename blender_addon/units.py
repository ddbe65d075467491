# SPDX-License-Identifier: GPL-3.0-or-later
"""Lengths in words."""


def millimetres(scene, length):
    """A length of the scene in millimetres: one Blender unit is `scale_length` metres."""
    return length * scene.unit_settings.scale_length * 1000.0


def text(scene, length):
    """A length of the scene for reading, such as "0.31 mm"."""
    value = millimetres(scene, length)
    return f"{value / 1000:.3g} m" if value >= 10_000 else f"{value:.3g} mm"
