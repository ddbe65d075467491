# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators, in the order of work."""

from . import attach, files, landmark, pick, preflight, reshape, scan, separate, show, skeleton, start, template

classes = (
    *start.classes, *template.classes, *preflight.classes, *landmark.classes, *pick.classes, *attach.classes,
    *reshape.classes, *show.classes, *files.classes, *scan.classes, *skeleton.classes, *separate.classes,
)
