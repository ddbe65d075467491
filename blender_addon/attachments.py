# SPDX-License-Identifier: GPL-3.0-or-later
"""Attachments: where the template grows on a bone. The gap between the two is kept, turned as the
bone is turned."""

import numpy
from mathutils.kdtree import KDTree

from . import mesh_data
from .library import Wrong, calls


def pairs(template, rest, faces):
    """Template points and targets in world coordinates (n, 3) of all attachments. `rest`: the
    template's vertices in world coordinates, `faces`: its triangles."""
    points, targets = [numpy.zeros((0, 3))], [numpy.zeros((0, 3))]
    for attachment in template.moulage.attachments:
        bone, target = _bones(attachment)
        if attachment.by == "GROUP":
            own = _group_vertices(template, attachment, rest)
            turn = mesh_data.best_rigid(bone, target)[:3, :3]
            near = _nearest_vertices(bone, own)
            points.append(own)
            targets.append(target[near] + (own - bone[near]) @ turn.T)
        else:
            found = _near_bone(attachment, rest, faces, bone, target)
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


def _group_vertices(template, attachment, rest):
    weights = mesh_data.group_weights(template, attachment.group)
    if weights is None:
        raise Wrong(f"'{attachment.name}': the template has no vertex group '{attachment.group}'.")
    if not (weights > 0.5).any():
        raise Wrong(f"The vertex group '{attachment.group}' has no vertices of a weight above 0.5.")
    return rest[weights > 0.5]


def _nearest_vertices(bone, points):
    tree = KDTree(len(bone))
    for index, place in enumerate(bone):
        tree.insert(place, index)
    tree.balance()
    return numpy.array([tree.find(p)[1] for p in points])


def _near_bone(attachment, rest, faces, bone, target):
    own = mesh_data.triangles(attachment.bone)
    with calls() as library:
        return library.Pairs.from_bone(
            library.TriMesh(rest, faces), library.TriMesh(bone, own), library.TriMesh(target, own), attachment.distance
        )
