# SPDX-License-Identifier: GPL-3.0-or-later
"""Armatures made and changed: rest poses, poses, meshes on bones, actions."""

from contextlib import contextmanager

import bpy
import mathutils

from . import skeleton


@contextmanager
def edit_bones(context, armature):
    """The armature's edit bones; Blender gives them only in Edit Mode."""
    layer = context.view_layer
    before = layer.objects.active
    hidden = armature.hide_get()
    armature.hide_set(False)
    layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    mirror, armature.data.use_mirror_x = armature.data.use_mirror_x, False
    try:
        yield armature.data.edit_bones
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")
        armature.data.use_mirror_x = mirror
        armature.hide_set(hidden)
        layer.objects.active = before


def set_rest(bone, matrix, length):
    """Puts an edit bone at a frame of the armature's space."""
    bone.use_connect = False
    if bone.length == 0.0:
        bone.tail = bone.head + mathutils.Vector((0.0, length, 0.0))
    bone.matrix = matrix
    bone.length = length


def set_pose(context, armature, frames):
    """Poses bones so that they lie at world frames, by name, and lets the constraints allow that. Bones that are
    not named keep their pose."""
    inverse = armature.matrix_world.inverted()
    placed = {}
    for bone in armature.data.bones:
        pose = armature.pose.bones[bone.name]
        if bone.parent is None:
            unposed = bone.matrix_local.copy()
        else:
            unposed = placed[bone.parent.name] @ bone.parent.matrix_local.inverted() @ bone.matrix_local
        if bone.name in frames:
            placed[bone.name] = skeleton.rigid(inverse @ frames[bone.name])
            pose.matrix_basis = unposed.inverted() @ placed[bone.name]
            skeleton.widen(pose)
        else:
            placed[bone.name] = unposed @ pose.matrix_basis
    context.view_layer.update()


def hang(context, ob, armature, bone, matrix):
    """Parents an object to a bone as it is posed, and puts it at a world matrix."""
    ob.parent, ob.parent_type, ob.parent_bone = armature, "BONE", bone
    ob.matrix_parent_inverse = mathutils.Matrix()
    context.view_layer.update()
    ob.matrix_world = matrix


def curves(action, ob):
    """The curves of an action for an object, also where actions have layers (Blender 4.4 and newer)."""
    if hasattr(action, "layers") and hasattr(ob.animation_data, "action_slot"):
        found = []
        for layer in action.layers:
            for strip in layer.strips:
                bag = strip.channelbag(ob.animation_data.action_slot)
                found += list(bag.fcurves) if bag is not None else []
        return found
    return list(action.fcurves)


def assign(ob, action, slot_of=None):
    """Lets an action move an object. `slot_of`: an object that the same action, or the one it was copied from,
    moves already."""
    data = ob.animation_data or ob.animation_data_create()
    data.action = action
    if action is None or not hasattr(data, "action_slot"):
        return
    wanted = slot_of.animation_data.action_slot.identifier if slot_of and slot_of.animation_data.action_slot else None
    slots = {slot.identifier: slot for slot in action.slots}
    data.action_slot = slots.get(wanted) or next(iter(action.slots), None)


def copy_action(template, person, ratios):
    """The template's action for the person, or None: rotations as they are, because the joints' axes are the same;
    locations of bones times how much longer the bone is. `ratios`: by the bone's name."""
    if template.animation_data is None or template.animation_data.action is None:
        return None
    action = template.animation_data.action.copy()
    action.name = f"{template.animation_data.action.name} of {person.name}"
    action.use_fake_user = True
    assign(person, action, template)
    for curve in curves(action, person):
        bone = _bone_of(curve.data_path)
        if bone in ratios and curve.data_path.endswith(".location"):
            for point in curve.keyframe_points:
                for handle in (point.co, point.handle_left, point.handle_right):
                    handle[1] *= ratios[bone]
            curve.update()
    return action


def _bone_of(path):
    return path.split('"')[1] if path.startswith('pose.bones["') else None


def key_pose(context, armature, name):
    """An action that holds the present pose."""
    assign(armature, None)
    for pose in armature.pose.bones:
        rotation = {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}
        for path in ("location", rotation.get(pose.rotation_mode, "rotation_euler")):
            pose.keyframe_insert(path, frame=context.scene.frame_current)
    action = armature.animation_data.action
    action.name, action.use_fake_user = name, True
    return action
