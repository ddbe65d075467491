# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators, in the order of work."""

from . import attach, files, landmark, pick, reshape, scan, separate, show, skeleton, template

classes = (
    *template.classes, *landmark.classes, *pick.classes, *attach.classes, *reshape.classes, *show.classes,
    *files.classes, *scan.classes, *skeleton.classes, *separate.classes,
)
