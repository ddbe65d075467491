# SPDX-License-Identifier: GPL-3.0-or-later
"""Skeleton files in and out: what the library's skeleton does not tell (named angles, labels, soft tissues) is
read from and added to the file itself."""

import json
import math
import os
import re
import tempfile
from pathlib import Path

import bpy
import mathutils
import numpy

from . import mesh_data, rig, skeleton
from .library import calls, moulage

# A bone of the armature as a share of its mesh: it shows the joint's axes, not the bone's extent.
_LENGTH = 0.25


def load(context, path, scale):
    """Makes an armature with the bones of a .skeleton.json or .osim file; returns it and notes."""
    with calls() as library:
        found = library.Skeleton.load(path)
        entries = _entries(found)
        soft = _read_soft(library, Path(path))
    name = Path(path).name.split(".")[0]
    # Many are called skeleton.json.
    name = Path(path).resolve().parent.name if name == "skeleton" else name
    armature = _build(context, found, name, scale, entries)
    for name, surface in soft:
        ob = _add_mesh(armature, name, surface.points * scale, surface.triangles)
        armature.moulage_skeleton.carried.add().object = ob
    return armature, found.notes


def _entries(found):
    """The skeleton's file in its normal form."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.skeleton.json"
        found.save(path)
        return json.loads(path.read_text(encoding="utf-8"))


def _read_soft(library, path):
    if path.suffix != ".json":
        return []
    entries = json.loads(path.read_text(encoding="utf-8")).get("soft", [])
    return [(entry["name"], library.TriMesh.load(path.parent / entry["mesh"])) for entry in entries]


def _tree(found):
    """The joint above each bone, by the bone's number: each bone hangs on one other, without circles. The other
    joints close loops."""
    above, loops = {}, []
    for joint in found.joints:
        bone = joint.parent
        while bone in above and bone != joint.child:
            bone = above[bone].parent
        if joint.in_tree and joint.child not in above and bone != joint.child:
            above[joint.child] = joint
        else:
            loops.append(joint)
    return above, loops


def _build(context, found, name, scale, entries):
    names = found.bone_names
    points = [found.bone_points(i) * scale for i in range(len(names))]
    above, loops = _tree(found)
    frames, rests, order = {}, {}, []

    def place(bone):
        if bone in rests:
            return
        joint = above.get(bone)
        if joint is None:
            rests[bone] = frames[bone] = mathutils.Matrix.Translation(points[bone].mean(axis=0).tolist())
        else:
            place(joint.parent)
            neutral, now = (_frame(f, scale) for f in (joint.parent_frame, joint.child_frame))
            rests[bone] = rests[joint.parent] @ frames[joint.parent].inverted() @ neutral
            frames[bone] = now
        order.append(bone)

    for bone in range(len(names)):
        place(bone)
    collection = bpy.data.collections.new(name)
    context.scene.collection.children.link(collection)
    armature = bpy.data.objects.new(name, bpy.data.armatures.new(name))
    armature.show_in_front = True
    armature.data.display_type = "STICK"
    collection.objects.link(armature)
    with rig.edit_bones(context, armature) as edit:
        for bone in order:
            new = edit.new(names[bone])
            if bone in above:
                new.parent = edit[names[above[bone].parent]]
            size = float(numpy.linalg.norm(numpy.ptp(points[bone], axis=0)))
            rig.set_rest(new, rests[bone], _LENGTH * size or 1.0)
    labels = {entry["name"]: entry.get("label", 0) for entry in entries["bones"]}
    joints = {entry["name"]: entry for entry in entries["joints"]}
    for bone, own in enumerate(names):
        pose = armature.pose.bones[own]
        pose.rotation_mode = "XYZ"
        pose.moulage.label = labels.get(own, 0)
        if bone in above:
            _set_joint(pose, above[bone], scale, joints.get(above[bone].name, {}))
    rig.set_pose(context, armature, {names[bone]: frame for bone, frame in frames.items()})
    for bone, own in enumerate(names):
        ob = _add_mesh(armature, own, points[bone], found.bone_triangles(bone), frames[bone])
        rig.hang(context, ob, armature, own, frames[bone])
    for joint in loops:
        _add_loop(armature, joint, names, frames, scale)
    return armature


def _frame(matrix, scale):
    found = mathutils.Matrix(matrix.tolist())
    found.translation *= scale
    return found


def _set_joint(pose, joint, scale, entry):
    pose.moulage.joint = joint.name
    pose.moulage.shift = joint.shift_limit * scale
    pose.moulage.coordinates = json.dumps(entry.get("coordinates", []))
    skeleton.set_limits(pose, joint.negative_limits, joint.positive_limits)


def _add_loop(armature, joint, names, frames, scale):
    loop = armature.moulage_skeleton.loops.add()
    loop.name, loop.parent, loop.child = joint.name, names[joint.parent], names[joint.child]
    loop.parent_frame = skeleton.flat(frames[joint.parent].inverted() @ _frame(joint.parent_frame, scale))
    loop.child_frame = skeleton.flat(frames[joint.child].inverted() @ _frame(joint.child_frame, scale))
    loop.negative = [v if math.isfinite(v) else -1.0 for v in joint.negative_limits]
    loop.positive = [v if math.isfinite(v) else -1.0 for v in joint.positive_limits]
    loop.shift = joint.shift_limit * scale


def _add_mesh(armature, name, points, triangles, frame=None):
    frame = mathutils.Matrix() if frame is None else frame
    local = points @ numpy.array(frame.inverted())[:3, :3].T + numpy.array(frame.inverted())[:3, 3]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(local.tolist(), [], triangles.tolist())
    mesh.update()
    ob = bpy.data.objects.new(name, mesh)
    ob.matrix_world = frame
    armature.users_collection[0].objects.link(ob)
    return ob


def save(context, armature, path, scale):
    """Writes an armature as .skeleton.json with its bones beside it, or as .glb; returns the number of bones."""
    template = skeleton.gather(context, armature, 1.0 / scale)
    with calls():
        template.native().save(path)
        if str(path).lower().endswith(".json"):
            _complete(context, armature, template, Path(path))
    return len(template.names)


def _complete(context, armature, template, path):
    document = json.loads(path.read_text(encoding="utf-8"))
    if abs(context.scene.unit_settings.scale_length / template.scale - 0.001) < 1e-9:
        document["units"] = "mm"
    for entry in document["bones"]:
        if armature.pose.bones[entry["name"]].moulage.label > 0:
            entry["label"] = armature.pose.bones[entry["name"]].moulage.label
    for entry, bone in zip(document["joints"], template.joint_bones):
        kept = json.loads(armature.pose.bones[bone].moulage.coordinates or "[]") if bone else []
        if kept:
            entry["coordinates"] = kept
    soft = []
    for ob, surface in soft_tissues(armature, template.scale):
        name = re.sub(r"[^\w.-]", "_", ob.name)
        (path.parent / "soft").mkdir(exist_ok=True)
        surface.save(path.parent / "soft" / f"{name}.obj")
        soft.append({"name": ob.name, "mesh": f"soft/{name}.obj"})
    if soft:
        document["soft"] = soft
    beside = path.with_name(path.name + ".part")
    beside.write_text(json.dumps(document, indent=2), encoding="utf-8")
    os.replace(beside, path)


def soft_tissues(armature, scale):
    """The carried meshes and their surfaces."""
    found = []
    for item in armature.moulage_skeleton.carried:
        if item.object is not None and item.object.data.polygons:
            points = mesh_data.world_points(item.object) * scale
            found.append((item.object, moulage().TriMesh(points, mesh_data.triangles(item.object))))
    return found
