# SPDX-License-Identifier: GPL-3.0-or-later
"""From the template to the person: a shape key of the person's meshes, with the template's points where they are
beside the person in the pose of the scan."""

import numpy

from . import mesh_data

KEY = "Template"


def add(ob, points):
    """Gives a mesh the key, switched off. `points`: the template's, in world coordinates (n, 3)."""
    ob.shape_key_add(name="Basis", from_mix=False)
    key = ob.shape_key_add(name=KEY, from_mix=False)
    mesh_data.set_key_points(key, mesh_data.transform(numpy.linalg.inv(mesh_data.matrix(ob)), points))
    key.value = 0.0


def show(armature, share):
    """Shows a person's meshes at this share of the way from the template."""
    for ob in meshes(armature):
        keys = ob.data.shape_keys
        if keys is not None and KEY in keys.key_blocks:
            keys.key_blocks[KEY].value = 1.0 - share


def meshes(armature):
    """A person's bones and soft tissues."""
    soft = [item.object for item in armature.moulage_skeleton.carried if item.object is not None]
    return [ob for ob in armature.children if ob.type == "MESH"] + soft
