# SPDX-License-Identifier: GPL-3.0-or-later
"""Attachments: where the template grows on a bone. The gap between the two is kept, turned as the
bone is turned."""

import numpy

from . import mesh_data
from .library import Wrong, calls


def pairs(template, rest, faces):
    """Template points and targets in world coordinates (n, 3) of all attachments. `rest`: the
    template's vertices in world coordinates, `faces`: its triangles."""
    points, targets = [numpy.zeros((0, 3))], [numpy.zeros((0, 3))]
    for attachment in template.moulage.attachments:
        bone, target = _bones(attachment)
        own = mesh_data.triangles(attachment.bone)
        with calls() as library:
            surfaces = library.TriMesh(rest, faces), library.TriMesh(bone, own), library.TriMesh(target, own)
            if attachment.by == "GROUP":
                found = library.Pairs.from_vertices(surfaces[0], _group_vertices(template, attachment), *surfaces[1:])
            else:
                found = library.Pairs.from_bone(*surfaces, attachment.distance)
        points.append(found.template_points)
        targets.append(found.targets)
    return numpy.vstack(points), numpy.vstack(targets)


def _bones(attachment):
    name = attachment.name or "attachment"
    if attachment.bone is None:
        raise Wrong(f"'{name}' has no bone: pick one in Attachments, or remove it.")
    bone = mesh_data.world_points(attachment.bone)
    if len(bone) == 0:
        raise Wrong(f"The bone '{attachment.bone.name}' has no vertices.")
    target = bone if attachment.target is None else mesh_data.world_points(attachment.target)
    if len(bone) != len(target):
        raise Wrong(
            f"'{attachment.bone.name}' has {len(bone)} vertices and '{attachment.target.name}' {len(target)}: "
            "the person's bone needs the same vertices."
        )
    return bone, target


def _group_vertices(template, attachment):
    weights = mesh_data.group_weights(template, attachment.group)
    if weights is None:
        raise Wrong(f"'{attachment.name}': the template has no vertex group '{attachment.group}'.")
    if not (weights > 0.5).any():
        raise Wrong(f"The vertex group '{attachment.group}' has no vertices of a weight above 0.5.")
    return numpy.flatnonzero(weights > 0.5)
