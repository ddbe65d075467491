# SPDX-License-Identifier: GPL-3.0-or-later
"""The person's skeleton: a copy of the armature with the person's rest pose, bones, pose, soft tissue, motion.
The template stays as it is, for the next person."""

import math

import bpy
import mathutils
import numpy

from . import blend, library, mesh_data, rig, skeleton, slice_view, units, views

# Marks objects that a run made, and the next one may remove.
MADE = "moulage_made"
# By the verdict on the whole.
_ENDINGS = {
    "good": "Done: good.",
    "doubtful": "Done, but in doubt: look at the bones below.",
    "failed": "Failed: the bones are not where the person's are.",
}
# From this share of the allowed rotation a joint is at its limit.
AT_LIMIT = 0.995


def _copy_mesh(ob, collection, name):
    copy = ob.copy()
    copy.data = ob.data.copy()
    copy.name = copy.data.name = name
    copy.property_unset("moulage")
    if copy.data.shape_keys:
        copy.shape_key_clear()
    copy[MADE] = True
    collection.objects.link(copy)
    return copy


def _set_points(ob, frame, points):
    """Gives a mesh its points in world coordinates, the object being put at `frame`."""
    local = mesh_data.transform(numpy.linalg.inv(skeleton.array(frame)), points)
    ob.data.vertices.foreach_set("co", numpy.ascontiguousarray(local, numpy.float32).ravel())
    ob.data.update()


class Preview:
    """Meshes that show a run; they go when it ends."""

    def __init__(self, armature, template):
        self._of = [ob.name for ob in template.objects]
        self._sizes = [len(p) for p in template.points]
        self._name = f"Registering {armature.name}"

    def show(self, points):
        collection = bpy.data.collections.get(self._name)
        if collection is None:
            collection = bpy.data.collections.new(self._name)
            bpy.context.scene.collection.children.link(collection)
            for name in self._of:
                ob = bpy.data.objects.get(name)
                if ob is not None:
                    copy = _copy_mesh(ob, collection, f"{name} (so far)")
                    copy.parent, copy.matrix_world = None, mathutils.Matrix()
        first = 0
        for name, size in zip(self._of, self._sizes):
            ob = collection.objects.get(f"{name} (so far)")
            if ob is not None and len(ob.data.vertices) == size:
                _set_points(ob, mathutils.Matrix(), points[first : first + size])
            first += size

    def remove(self):
        collection = bpy.data.collections.get(self._name)
        if collection is not None:
            _remove_all(collection)


def _remove_all(collection):
    for ob in list(collection.objects):
        if ob.get(MADE):
            data = ob.data
            bpy.data.objects.remove(ob)
            if data is not None and data.users == 0:
                (bpy.data.meshes if isinstance(data, bpy.types.Mesh) else bpy.data.armatures).remove(data)
    if not collection.objects and not collection.children:
        bpy.data.collections.remove(collection)


def write(context, armature, run, found, seconds):
    """Writes all of a result; returns what to tell the user."""
    data, template, unit = armature.moulage_skeleton, run.template, run.unit
    native = found.skeleton
    points = [native.bone_points(b) * unit for b in range(len(template.names))]
    if data.person is not None and not data.keep and data.person.get(MADE):
        for collection in data.person.users_collection:
            _remove_all(collection)
    collection = bpy.data.collections.new(f"{armature.name} person")
    context.scene.collection.children.link(collection)
    motions = _motions(template, points)
    frames = _frames(template, native, motions, unit)
    own = _copy_armature(context, armature, template, native, frames, motions, collection, unit)
    copies = []
    for ob, name, shape in zip(template.objects, template.names, points):
        copy = _copy_mesh(ob, collection, f"{ob.name} person")
        place = motions[name][0] @ ob.matrix_world
        rig.hang(context, copy, own, name, place)
        _set_points(copy, place, shape)
        copies.append((ob, copy))
    meshes = {name: copy for name, (_ob, copy) in zip(template.names, copies)}
    copies += _carry(own, run, found, collection)
    context.view_layer.update()
    for ob, copy in copies:
        blend.add(copy, mesh_data.world_points(ob))
    data.person = own
    slice_view.leave(context)
    views.show(context, parts(armature, "TEMPLATE"), False)
    views.select_only(context, own)
    own.moulage_skeleton.person = None
    kept = own.moulage_skeleton.result
    _keep(own, template, found, kept, seconds, unit, meshes)
    context.view_layer.update()
    return sentence(context.scene, own)


def _motions(template, points):
    """For each bone the rigid motion from the template to the person, and how many times larger it became."""
    found = {}
    for name, before, after in zip(template.names, template.points, points):
        rest = before / template.scale
        with library.calls() as package:
            motion = mathutils.Matrix(package.align(rest, after).tolist())
        spread = [numpy.linalg.norm(p - p.mean(axis=0)) for p in (rest, after)]
        found[name] = motion, float(spread[1] / spread[0]) if spread[0] > 0 else 1.0
    return found


def _frames(template, native, motions, unit):
    """Where each bone of the person lies, world."""
    found = {name: motions[name][0] @ template.frames[name] for name in template.names}
    for joint, bone in zip(native.joints, template.joint_bones):
        if bone is not None:
            found[bone] = _frame(joint.child_frame, unit)
    return found


def _frame(matrix, unit):
    found = mathutils.Matrix(matrix.tolist())
    found.translation *= unit
    return found


def _copy_armature(context, armature, template, native, frames, motions, collection, unit):
    copy = armature.copy()
    copy.data = armature.data.copy()
    copy.name = copy.data.name = f"{armature.name} person"
    copy[MADE] = True
    copy.moulage_skeleton.uid = ""
    if copy.animation_data is not None:
        copy.animation_data.action = None
    collection.objects.link(copy)
    neutral = {
        bone: (template.names[joint.parent], _frame(joint.parent_frame, unit))
        for joint, bone in zip(native.joints, template.joint_bones) if bone is not None
    }
    ratios = {}
    with rig.edit_bones(context, copy) as edit:
        inverse = copy.matrix_world.inverted()
        size = sum(copy.matrix_world.to_scale()) / 3
        rests = {}
        # Parents come before their children.
        for bone in armature.data.bones:
            name = bone.name
            if name in neutral:
                above, frame = neutral[name]
                step = frames[above].inverted() @ frame
                step.translation /= size
                rests[name] = rests[above] @ step
            elif name in frames:
                rests[name] = inverse @ frames[name]
            elif bone.parent is not None:
                step = bone.parent.matrix_local.inverted() @ bone.matrix_local
                step.translation *= ratios[bone.parent.name]
                rests[name] = rests[bone.parent.name] @ step
            else:
                rests[name] = bone.matrix_local.copy()
            rests[name] = skeleton.rigid(rests[name])
            inherited = ratios[bone.parent.name] if bone.parent is not None else 1.0
            ratios[name] = motions[name][1] if name in motions else inherited
            rig.set_rest(edit[name], rests[name], bone.length * ratios[name])
    loose = [n for n in template.names if n not in neutral]
    _keep_root_pose(armature, copy, loose, frames)
    action = rig.copy_action(armature, copy, ratios)
    if action is not None:
        copy.moulage_skeleton.motion = action
        rig.assign(copy, None)
    rig.set_pose(context, copy, frames)
    if action is not None:
        copy.moulage_skeleton.pose = rig.key_pose(context, copy, f"Pose of {copy.name}")
    _move_loops(copy, template, native, frames, unit)
    return copy


def _keep_root_pose(armature, copy, names, frames):
    """Bones without a joint keep their pose, so that keys of the template's motion mean the same: their rest pose
    is moved instead."""
    inverse = copy.matrix_world.inverted()
    with rig.edit_bones(bpy.context, copy) as edit:
        for name in names:
            pose = armature.pose.bones[name]
            if pose.parent is not None:
                continue
            rest = skeleton.rigid(inverse @ frames[name]) @ skeleton.rigid(pose.matrix_basis).inverted()
            step = rest @ edit[name].matrix.inverted()
            rig.set_rest(edit[name], rest, edit[name].length)
            for child in edit[name].children_recursive:
                rig.set_rest(child, step @ child.matrix, child.length)


def _move_loops(copy, template, native, frames, unit):
    loops = iter(copy.moulage_skeleton.loops)
    for joint, bone in zip(native.joints, template.joint_bones):
        if bone is None:
            loop = next(loops)
            parent, child = (template.names[b] for b in (joint.parent, joint.child))
            loop.parent_frame = skeleton.flat(frames[parent].inverted() @ _frame(joint.parent_frame, unit))
            loop.child_frame = skeleton.flat(frames[child].inverted() @ _frame(joint.child_frame, unit))


def _carry(own, run, found, collection):
    """Copies the soft tissues into the person; returns each with its copy."""
    carried = own.moulage_skeleton.carried
    carried.clear()
    copies = []
    for ob, surface in run.tissues:
        copy = _copy_mesh(ob, collection, f"{ob.name} person")
        copy.parent, copy.matrix_world = None, ob.matrix_world.copy()
        _set_points(copy, ob.matrix_world, found.carry(surface) * run.unit)
        carried.add().object = copy
        copies.append((ob, copy))
    return copies


def _keep(own, template, found, kept, seconds, unit, meshes):
    summary = found.summary
    kept.verdict = summary["verdict"]
    kept.ending = "Stopped: what there was is kept." if summary["cancelled"] else _ENDINGS[kept.verdict]
    kept.mean_residual, kept.max_residual = summary["mean_residual"] * unit, summary["max_residual"] * unit
    kept.iterations, kept.seconds = summary["iterations"], seconds
    kept.warnings = "\n".join(library.sentence(line) for line in found.warnings)
    # A person may have been the template.
    kept.share = 1.0
    kept.bones.clear()
    fits = [(name, found.bone_fit(number)) for number, name in enumerate(template.names)]
    for verdict in ("failed", "doubtful", "good"):
        for name, fit in fits:
            if fit["verdict"] == verdict:
                row = kept.bones.add()
                row.name, row.verdict, row.object = name, verdict, meshes[name]
                row.mean_residual = fit["mean_residual"] * unit
                row.reasons = "\n".join(library.sentence(reason) for reason in fit["reasons"])
    kept.joints.clear()
    poses = [found.joint_pose(number) for number in range(len(template.joints))]
    for joint, pose in sorted(zip(template.joints, poses), key=lambda pair: -_usage(pair[1])):
        row = kept.joints.add()
        row.name, row.usage = joint.name, _usage(pose)
        row.rotation = float(numpy.linalg.norm(pose["rotation"]))
        row.excess = pose["excess_rotation"]


def _usage(pose):
    """A turn about an axis without freedom counts as at the limit."""
    return min(pose["usage"], 10.0) if math.isfinite(pose["usage"]) else 1.0


def at_limit(kept):
    """The joints of a result that are at their limits."""
    return [row for row in kept.joints if row.usage >= AT_LIMIT]


def parts(armature, which):
    """The objects of a skeleton's TEMPLATE, TARGET or PERSON that are there."""
    data = armature.moulage_skeleton
    if which == "TARGET":
        bones = list(data.target_bones.all_objects) if data.target_kind == "BONES" and data.target_bones else []
        return bones + ([data.target] if data.target_kind == "SURFACE" and data.target else [])
    own = armature if which == "TEMPLATE" else data.person
    return [own, *blend.meshes(own)] if own is not None else []


def sentence(scene, own):
    """The result in one line."""
    kept = own.moulage_skeleton.result
    mean, largest = units.texts(scene, kept.mean_residual, kept.max_residual)
    text = f"{kept.ending} Bones: mean {mean}, largest {largest}."
    tight = len(at_limit(kept))
    return text + (f" {tight} joint{'s are at their limits' if tight > 1 else ' is at its limit'}." if tight else "")
