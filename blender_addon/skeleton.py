# SPDX-License-Identifier: GPL-3.0-or-later
"""A skeleton in Blender: an armature whose bones carry meshes, with Limit Rotation constraints.

Each bone of the armature that carries a mesh is a bone of the skeleton; the joint to the nearest bone above it
that carries one lies at its head. The bone's axes are the joint's: the rest pose is the joint's neutral position,
so limits and keyed rotations mean the same for every person."""

import math
from dataclasses import dataclass, field

import mathutils
import numpy

from . import mesh_data
from .library import Wrong, moulage

CONSTRAINT = "Moulage limits"
_AXES = "xyz"


@dataclass
class Template:
    """A skeleton taken out of Blender. Points (n, 3) and frames are in world coordinates times `scale`."""

    names: list
    objects: list
    points: list
    triangles: list
    joints: list
    # The armature's bone of each joint; None for one that only closes a loop.
    joint_bones: list
    frames: dict = field(default_factory=dict)
    scale: float = 1.0

    def native(self):
        """The library's skeleton."""
        package = moulage()
        surfaces = (package.TriMesh(p, t) for p, t in zip(self.points, self.triangles))
        return package.Skeleton(zip(self.names, surfaces), self.joints)


def rigid(matrix):
    """A matrix without its scale."""
    place, turn, _scale = matrix.decompose()
    return mathutils.Matrix.Translation(place) @ turn.to_matrix().to_4x4()


def array(matrix):
    return numpy.array(matrix, dtype=numpy.float64)


def meshes(armature):
    """The mesh that each bone carries, by the bone's name; Wrong if one carries several."""
    found = {}
    for ob in armature.children:
        if ob.type != "MESH" or ob.parent_type != "BONE" or ob.parent_bone not in armature.data.bones:
            continue
        if ob in _soft(armature):
            continue
        if ob.parent_bone in found:
            raise Wrong(
                f"The bone '{ob.parent_bone}' carries '{found[ob.parent_bone].name}' and '{ob.name}': join them (Ctrl J)."
            )
        found[ob.parent_bone] = ob
    return found


def _soft(armature):
    return {item.object for item in armature.moulage_skeleton.carried}


def world(armature, pose_bone):
    """Where a bone is now, after its constraints."""
    return rigid(armature.matrix_world @ pose_bone.matrix)


def ancestor(bone, carrying):
    """The nearest bone above that carries a mesh, or None."""
    while bone.parent is not None:
        bone = bone.parent
        if bone.name in carrying:
            return bone
    return None


def neutral(armature, above, bone):
    """Where a bone would be in its neutral position, seen from where the bone above is now."""
    pose = armature.pose.bones[above.name]
    return rigid(armature.matrix_world @ pose.matrix @ above.matrix_local.inverted() @ bone.matrix_local)


def gather(context, armature, scale=1.0):
    """The skeleton of an armature; Wrong says what is missing."""
    if armature is None:
        raise Wrong("Pick an armature whose bones carry meshes as the skeleton first.")
    context.view_layer.update()
    carrying = meshes(armature)
    if not carrying:
        raise Wrong(
            f"No bone of '{armature.name}' carries a mesh: select a mesh and then the armature, pick the bone in Pose "
            "Mode, and use Parent > Bone (Ctrl P)."
        )
    bones = [bone for bone in armature.data.bones if bone.name in carrying]
    names = [bone.name for bone in bones]
    objects = [carrying[name] for name in names]
    found = Template(
        names, objects, [mesh_data.world_points(ob) * scale for ob in objects],
        [mesh_data.triangles(ob) for ob in objects], [], [], scale=scale,
    )
    for ob, triangles in zip(objects, found.triangles):
        if len(triangles) == 0:
            raise Wrong(f"The bone mesh '{ob.name}' has no faces.")
    for bone in bones:
        pose = armature.pose.bones[bone.name]
        found.frames[bone.name] = world(armature, pose)
        above = ancestor(bone, carrying)
        if above is not None:
            found.joints.append(_joint(armature, found, names.index(above.name), above, pose))
            found.joint_bones.append(bone.name)
    for loop in armature.moulage_skeleton.loops:
        if loop.parent in names and loop.child in names:
            found.joints.append(_loop(found, loop))
            found.joint_bones.append(None)
    return found


def _scaled(matrix, scale):
    found = array(matrix)
    found[:3, 3] *= scale
    return found


def _joint(armature, found, parent, above, pose):
    negative, positive = limits(pose)
    shift = pose.moulage.shift * found.scale
    return moulage().Joint(
        pose.moulage.joint or pose.name, parent, found.names.index(pose.name),
        _scaled(neutral(armature, above, pose.bone), found.scale), _scaled(found.frames[pose.name], found.scale),
        negative, positive, shift if shift > 0 else None,
    )


def _loop(found, loop):
    frames = []
    for bone, flat in ((loop.parent, loop.parent_frame), (loop.child, loop.child_frame)):
        frames.append(_scaled(found.frames[bone] @ square(flat), found.scale))
    shift = loop.shift * found.scale
    return moulage().Joint(
        loop.name, found.names.index(loop.parent), found.names.index(loop.child), *frames,
        tuple(_number(v) for v in loop.negative), tuple(_number(v) for v in loop.positive),
        shift if shift > 0 else None, False,
    )


def square(flat):
    return mathutils.Matrix([flat[4 * r : 4 * r + 4] for r in range(4)])


def flat(matrix):
    return [v for row in matrix for v in row]


def _number(value):
    """Limits of loops are kept as numbers; below 0: free."""
    return math.inf if value < 0 else value


def limits(pose):
    """The largest rotations of a pose bone in the negative and the positive sense, radians. Without a constraint
    it is free; locked axes do not turn."""
    negative, positive = [math.inf] * 3, [math.inf] * 3
    for k in range(3):
        if pose.lock_rotation[k]:
            negative[k] = positive[k] = 0.0
    for own in pose.constraints:
        if own.type != "LIMIT_ROTATION" or own.mute or own.owner_space != "LOCAL":
            continue
        for k, axis in enumerate(_AXES):
            if getattr(own, f"use_limit_{axis}"):
                wider = pose.moulage.widened if own.name == CONSTRAINT else (0.0,) * 6
                negative[k] = _side(-getattr(own, f"min_{axis}") - wider[k])
                positive[k] = _side(getattr(own, f"max_{axis}") - wider[3 + k])
    return tuple(negative), tuple(positive)


def _side(angle):
    """A limit; a whole turn is none."""
    return math.inf if angle > math.tau - 1e-3 else max(0.0, angle)


def set_limits(pose, negative, positive):
    """Gives a pose bone its constraint. Limits of a joint are an ellipsoid, the constraint's are its box."""
    own = pose.constraints.get(CONSTRAINT) or pose.constraints.new("LIMIT_ROTATION")
    own.name, own.owner_space, own.use_transform_limit = CONSTRAINT, "LOCAL", True
    for k, axis in enumerate(_AXES):
        bounded = math.isfinite(negative[k]) or math.isfinite(positive[k])
        setattr(own, f"use_limit_{axis}", bounded)
        if bounded:
            setattr(own, f"min_{axis}", -min(negative[k], math.tau))
            setattr(own, f"max_{axis}", min(positive[k], math.tau))
    pose.moulage.widened = (0.0,) * 6


def widen(pose):
    """Lets the constraint allow the pose as it is: Euler angles may lie a little outside the box of a rotation
    vector inside. What was added is kept, so that the joint's limits stay known."""
    own = pose.constraints.get(CONSTRAINT)
    if own is None:
        return
    angles = pose.matrix_basis.to_euler("XYZ")
    wider = list(pose.moulage.widened)
    for k, axis in enumerate(_AXES):
        if getattr(own, f"use_limit_{axis}"):
            low, high = getattr(own, f"min_{axis}"), getattr(own, f"max_{axis}")
            below, beyond = max(0.0, low - angles[k]), max(0.0, angles[k] - high)
            setattr(own, f"min_{axis}", low - below)
            setattr(own, f"max_{axis}", high + beyond)
            wider[k] += below
            wider[3 + k] += beyond
    pose.moulage.widened = wider
