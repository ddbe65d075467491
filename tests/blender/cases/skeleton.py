"""Skeletons: files in and out, registration, the person's rest pose, joints, soft tissue and motion."""

import math
import tempfile
import unittest
from pathlib import Path

import bpy
import numpy
from mathutils import Matrix, Vector

import scenes
from scenes import part, points_of


def world_points(ob):
    frame = numpy.array(ob.matrix_world)
    return points_of(ob.data) @ frame[:3, :3].T + frame[:3, 3]


def block(name, centre, half):
    """A box of many faces."""
    side = numpy.linspace(-1, 1, 9)
    a, b = (v.ravel() for v in numpy.meshgrid(side, side, indexing="ij"))
    points, faces = [], []
    for axis in range(3):
        for sign in (1, -1):
            p = numpy.zeros((81, 3))
            p[:, axis], p[:, (axis + 1) % 3], p[:, (axis + 2) % 3] = sign, sign * a, b
            first = len(points) * 81
            points.append(p)
            for i in range(8):
                for j in range(8):
                    k = first + 9 * i + j
                    faces += [(k, k + 9, k + 10, k + 1)]
    return scenes.add_mesh(name, numpy.vstack(points) * half + centre, faces)


def leg():
    """A rig as an artist makes it: two bones along x, a hinge with limits, a mesh on each."""
    scenes.empty_scene()
    armature = bpy.data.objects.new("leg", bpy.data.armatures.new("leg"))
    bpy.context.scene.collection.objects.link(armature)
    with part("rig").edit_bones(bpy.context, armature) as edit:
        for name, x, length in (("thigh", -10, 20.5), ("shank", 10.5, 15)):
            bone = edit.new(name)
            bone.head, bone.tail = (x, 0, 0), (x + length, 0, 0)
        edit["shank"].parent = edit["thigh"]
    for name, x, half in (("thigh", 0, (10, 2, 3)), ("shank", 18, (7, 1.5, 2.5))):
        ob = block(f"{name} mesh", (x, 0, 0), half)
        part("rig").hang(bpy.context, ob, armature, name, ob.matrix_world.copy())
    knee = armature.pose.bones["shank"]
    knee.rotation_mode = "XYZ"
    part("skeleton").set_limits(knee, (0.1, 0.1, 0.2), (0.1, 0.1, 1.2))
    bpy.context.scene.moulage.skeleton = armature
    return armature


def bent_target(armature, angle, longer=1.2):
    """The leg with the knee bent about its z axis, both bones longer, as one surface without a hint."""
    thigh, shank = (bpy.data.objects[f"{n} mesh"] for n in ("thigh", "shank"))
    frame = armature.matrix_world @ armature.pose.bones["shank"].bone.matrix_local
    turn = Matrix.Translation((0.2 * 10.5, 0, 0)) @ frame @ Matrix.Rotation(angle, 4, "Z") @ frame.inverted()
    points, faces, first = [], [], 0
    for ob, motion in ((thigh, Matrix()), (shank, turn)):
        p = world_points(ob) * (1, 1, 1)
        middle = 0.0 if ob is thigh else 10.5
        p[:, 0] = middle + longer * (p[:, 0] - middle)
        points.append(p @ numpy.array(motion)[:3, :3].T + numpy.array(motion)[:3, 3])
        faces += [[v + first for v in f.vertices] for f in ob.data.polygons]
        first += len(p)
    return scenes.add_mesh("person surface", numpy.vstack(points), faces), points


def key_knee(armature):
    """A motion of two keys: the knee bends about z, the thigh moves."""
    armature.animation_data_create()
    knee, thigh = (armature.pose.bones[n] for n in ("shank", "thigh"))
    for frame, angle, move in ((1, 0.0, 0.0), (11, 0.8, 5.0)):
        knee.rotation_euler, thigh.location, knee.location = (0, 0, angle), (0, move, 0), (0, move / 10, 0)
        knee.keyframe_insert("rotation_euler", frame=frame)
        knee.keyframe_insert("location", frame=frame)
        thigh.keyframe_insert("location", frame=frame)
    armature.animation_data.action.name = "kick"
    bpy.context.scene.frame_set(1)


class Rig(unittest.TestCase):
    def test_an_artist_s_rig_is_a_skeleton(self):
        armature = leg()
        found = part("skeleton").gather(bpy.context, armature)
        self.assertEqual(found.names, ["thigh", "shank"])
        (joint,) = found.native().joints
        self.assertEqual((joint.name, joint.parent, joint.child), ("shank", 0, 1))
        numpy.testing.assert_allclose(joint.child_frame[:3, 3], (10.5, 0, 0), atol=1e-5)
        numpy.testing.assert_allclose(joint.positive_limits, (0.1, 0.1, 1.2), atol=1e-6)
        numpy.testing.assert_allclose(joint.negative_limits, (0.1, 0.1, 0.2), atol=1e-6)
        armature.pose.bones["shank"].rotation_euler = (0, 0, 0.7)
        bent = part("skeleton").gather(bpy.context, armature).native().joints[0]
        inside = numpy.linalg.inv(bent.parent_frame) @ bent.child_frame
        self.assertAlmostEqual(math.atan2(inside[1, 0], inside[0, 0]), 0.7, places=5)

    def test_a_scaled_and_turned_armature_counts_in_world_coordinates(self):
        armature = leg()
        before = part("skeleton").gather(bpy.context, armature).native().joints[0]
        armature.matrix_world = Matrix.Translation((1, 2, 3)) @ Matrix.Rotation(0.5, 4, "X") @ Matrix.Scale(0.1, 4)
        bpy.context.view_layer.update()
        after = part("skeleton").gather(bpy.context, armature)
        place = armature.matrix_world @ Vector(before.child_frame[:3, 3].tolist())
        numpy.testing.assert_allclose(after.joints[0].child_frame[:3, 3], place, atol=1e-5)
        self.assertAlmostEqual(float(numpy.ptp(after.points[0], axis=0)[0]), 2.0, places=4)

    def test_what_is_missing_is_said(self):
        scenes.empty_scene()
        empty = bpy.data.objects.new("empty", bpy.data.armatures.new("empty"))
        bpy.context.scene.collection.objects.link(empty)
        bpy.context.scene.moulage.skeleton = empty
        self.assertFalse(bpy.ops.moulage.register.poll())
        empty.moulage_skeleton.target = scenes.ball()
        with self.assertRaisesRegex(RuntimeError, "carries a mesh"):
            bpy.ops.moulage.register()
        armature = leg()
        other = block("second", (0, 0, 0), (1, 1, 1))
        part("rig").hang(bpy.context, other, armature, "thigh", other.matrix_world.copy())
        armature.moulage_skeleton.target = other
        with self.assertRaisesRegex(RuntimeError, "join them"):
            bpy.ops.moulage.register()

    def test_loops_labels_and_soft_tissues_survive_a_file(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            armature = leg()
            armature.pose.bones["thigh"].moulage.label = 3
            loop = armature.moulage_skeleton.loops.add()
            loop.name, loop.parent, loop.child = "band", "thigh", "shank"
            loop.parent_frame = loop.child_frame = part("skeleton").flat(Matrix())
            loop.negative, loop.positive, loop.shift = (-1, 0.2, 0.3), (-1, 0.2, 0.3), 2.0
            armature.moulage_skeleton.carried.add().object = block("skin", (18, 0, 0), (8, 3, 3.5))
            path = str(folder / "leg.skeleton.json")
            bpy.ops.moulage.export_skeleton(filepath=path, scale=0.001)
            scenes.empty_scene()
            bpy.ops.moulage.import_skeleton(filepath=path, scale=0.001)
            armature = bpy.context.scene.moulage.skeleton
            again = part("skeleton").gather(bpy.context, armature)
        self.assertEqual(armature.pose.bones["thigh"].moulage.label, 3)
        self.assertEqual(armature.moulage_skeleton.carried[0].object.name, "skin")
        self.assertEqual([j.in_tree for j in again.joints], [True, False])
        band = again.joints[1]
        self.assertTrue(math.isinf(band.negative_limits[0]))
        self.assertAlmostEqual(band.positive_limits[2], 0.3, places=5)
        self.assertAlmostEqual(band.shift_limit, 2.0, places=4)
        numpy.testing.assert_allclose(again.points[1].mean(axis=0), (18, 0, 0), atol=1e-4)


class Register(unittest.TestCase):
    def registered(self, angle=0.6, motion=False, **settings):
        armature = leg()
        if motion:
            key_knee(armature)
        target, points = bent_target(armature, angle)
        data = armature.moulage_skeleton
        data.target, data.near = target, True
        for name, value in settings.items():
            setattr(data, name, value)
        self.assertEqual(bpy.ops.moulage.register(), {"FINISHED"})
        return armature, data.person, points

    def test_bones_lie_on_the_person_s_and_the_template_stays(self):
        armature = leg()
        before = [world_points(bpy.data.objects[f"{n} mesh"]) for n in ("thigh", "shank")]
        armature, own, points = self.registered()
        for name, there, rest in zip(("thigh", "shank"), points, before):
            shape = world_points(bpy.data.objects[f"{name} mesh person"])
            self.assertLess(numpy.linalg.norm(shape - there, axis=1).mean(), 0.4)
            numpy.testing.assert_allclose(world_points(bpy.data.objects[f"{name} mesh"]), rest, atol=1e-5)
        result = own.moulage_skeleton.result
        self.assertLess(result.mean_residual, 0.1)
        self.assertEqual([row.name for row in result.joints], ["shank"])

    def test_the_rest_pose_is_the_person_s_and_the_pose_is_the_scan_s(self):
        armature, own, _points = self.registered()
        thigh, shank = (own.data.bones[n] for n in ("thigh", "shank"))
        self.assertAlmostEqual(thigh.length / armature.data.bones["thigh"].length, 1.2, delta=0.05)
        # In the neutral pose the legs are straight: the joint is 20.5 * 1.2 / 20.5 from the middle.
        straight = thigh.matrix_local.inverted() @ shank.matrix_local
        self.assertLess(straight.to_quaternion().angle, 0.1)
        angle = own.pose.bones["shank"].rotation_euler
        self.assertAlmostEqual(angle[2], 0.6, delta=0.06)
        self.assertLess(max(abs(angle[0]), abs(angle[1])), 0.06)
        # Posing the bones moves the meshes with them.
        before = world_points(bpy.data.objects["shank mesh person"])
        own.pose.bones["shank"].rotation_euler = (0, 0, 0)
        bpy.context.view_layer.update()
        after = world_points(bpy.data.objects["shank mesh person"])
        self.assertGreater(numpy.linalg.norm(after - before, axis=1).max(), 4.0)
        self.assertLess(numpy.ptp(after, axis=0)[1], 5.0)

    def test_a_joint_bent_beyond_its_limits_is_listed_at_its_limit(self):
        # Hard: no further than the range of 1.2. Soft, the default: further, by 10 degrees at most.
        ends = (("soft", 1.3, 1.2 + math.radians(10)), ("hard", 1.2, 1.2))
        for limits, least, most in ends:
            _armature, own, _points = self.registered(angle=1.5, limits=limits)
            result = own.moulage_skeleton.result
            self.assertEqual(len(part("person").at_limit(result)), 1)
            turned = own.pose.bones["shank"].rotation_euler[2]
            self.assertTrue(least - 1e-3 < turned < most + 1e-3, turned)
            self.assertIn("1 joint is at its limit", part("person").sentence(bpy.context.scene, own))
        self.assertEqual(leg().moulage_skeleton.limits, "soft")

    def test_the_motion_is_copied_for_the_person(self):
        armature, own, _points = self.registered(motion=True)
        data = own.moulage_skeleton
        self.assertEqual(armature.animation_data.action.name, "kick")
        self.assertEqual(data.motion.name, "kick of leg person")
        self.assertAlmostEqual(own.pose.bones["shank"].rotation_euler[2], 0.6, delta=0.06)
        bpy.ops.moulage.show_action(kind="MOTION")
        bpy.context.scene.frame_set(11)
        self.assertAlmostEqual(own.pose.bones["shank"].rotation_euler[2], 0.8, delta=1e-4)
        ratio = own.data.bones["thigh"].length / armature.data.bones["thigh"].length
        self.assertAlmostEqual(own.pose.bones["thigh"].location[1], 5.0 * ratio, places=3)
        self.assertAlmostEqual(armature.pose.bones["thigh"].location[1], 5.0, places=4)
        bpy.ops.moulage.show_action(kind="POSE")
        bpy.context.scene.frame_set(1)
        self.assertAlmostEqual(own.pose.bones["shank"].rotation_euler[2], 0.6, delta=0.06)

    def test_soft_tissue_is_carried(self):
        armature = leg()
        skin = block("skin", (18, 0, 0), (8, 3, 3.5))
        target, points = bent_target(armature, 0.6)
        armature.moulage_skeleton.carried.add().object = skin
        armature.moulage_skeleton.target, armature.moulage_skeleton.near = target, True
        bpy.ops.moulage.register()
        moved = world_points(bpy.data.objects["skin person"])
        self.assertLess(numpy.linalg.norm(moved.mean(axis=0) - points[1].mean(axis=0)), 1.0)
        self.assertEqual(armature.moulage_skeleton.person.moulage_skeleton.carried[0].object.name, "skin person")

    def test_bones_may_have_surfaces_of_their_own(self):
        armature = leg()
        _target, points = bent_target(armature, 0.5)
        collection = bpy.data.collections.new("scan")
        bpy.context.scene.collection.children.link(collection)
        faces = [list(f.vertices) for f in bpy.data.objects["shank mesh"].data.polygons]
        for name, p in zip(("thigh", "shank"), points):
            collection.objects.link(scenes.add_mesh(name, p, faces))
        data = armature.moulage_skeleton
        data.target_kind, data.target_bones, data.near = "BONES", collection, True
        bpy.ops.moulage.register()
        shape = world_points(bpy.data.objects["shank mesh person"])
        self.assertLess(numpy.linalg.norm(shape - points[1], axis=1).mean(), 0.4)
        collection.objects[0].name, collection.objects[1].name = "x", "y"
        with self.assertRaisesRegex(RuntimeError, "named as a bone"):
            bpy.ops.moulage.register()

    def test_a_bone_without_a_surface_is_in_doubt_and_a_target_in_metres_is_refused(self):
        armature = leg()
        target, points = bent_target(armature, 0.5)
        collection = bpy.data.collections.new("scan")
        bpy.context.scene.collection.children.link(collection)
        faces = [list(f.vertices) for f in bpy.data.objects["shank mesh"].data.polygons]
        collection.objects.link(scenes.add_mesh("thigh", points[0], faces))
        data = armature.moulage_skeleton
        data.target_kind, data.target_bones, data.near = "BONES", collection, True
        bpy.ops.moulage.register()
        result = data.person.moulage_skeleton.result
        self.assertNotEqual(result.verdict, "good")
        shank = next(row for row in result.bones if row.name == "shank")
        self.assertEqual(shank.verdict, "doubtful")
        self.assertIn("no surface of it", shank.reasons)
        data.target_kind, data.target = "SURFACE", target
        target.data.transform(Matrix.Scale(0.001, 4))
        with self.assertRaisesRegex(RuntimeError, "metres"):
            bpy.ops.moulage.register()

    def test_a_second_run_replaces_the_person_or_makes_another_by_choice(self):
        armature, _own, _points = self.registered()
        count = len(bpy.data.objects)
        bpy.ops.moulage.register()
        self.assertEqual(len(bpy.data.objects), count)
        armature.moulage_skeleton.keep = True
        bpy.ops.moulage.register()
        self.assertEqual(len(bpy.data.objects), count + 3)

    def test_the_person_can_be_the_template_of_another(self):
        armature, own, points = self.registered()
        bpy.context.scene.moulage.skeleton = own
        own.moulage_skeleton.target, own.moulage_skeleton.near = bpy.data.objects["person surface"], True
        bpy.ops.moulage.register()
        shape = world_points(bpy.data.objects["shank mesh person person"])
        self.assertLess(numpy.linalg.norm(shape - points[1], axis=1).mean(), 0.4)

    def test_the_template_is_hidden_and_a_slider_goes_from_it_to_the_person(self):
        armature, own, points = self.registered()
        target = armature.moulage_skeleton.target
        thigh, shank = (bpy.data.objects[f"{n} mesh"] for n in ("thigh", "shank"))
        self.assertEqual([ob.visible_get() for ob in (armature, thigh, shank, target, own)], [False] * 3 + [True] * 2)
        self.assertEqual((bpy.context.object, bpy.context.selected_objects), (own, [own]))
        bones = {ob.parent_bone: ob for ob in own.children}
        shown = part("mesh_data").shown_points
        as_person = shown(bones["shank"])
        self.assertLess(numpy.linalg.norm(as_person - points[1], axis=1).mean(), 0.4)
        own.moulage_skeleton.result.share = 0.0
        for name, ob in (("thigh", thigh), ("shank", shank)):
            numpy.testing.assert_allclose(shown(bones[name]), world_points(ob), atol=1e-4)
        own.moulage_skeleton.result.share = 0.5
        numpy.testing.assert_allclose(shown(bones["shank"]), (as_person + world_points(shank)) / 2, atol=1e-4)
        for which, ob in (("TEMPLATE", shank), ("TARGET", target), ("PERSON", bones["shank"])):
            before = ob.visible_get()
            bpy.ops.moulage.show_part(part=which)
            self.assertNotEqual(ob.visible_get(), before)
            bpy.ops.moulage.show_part(part=which)
            self.assertEqual(ob.visible_get(), before)

    def test_each_bone_has_its_verdict_and_choosing_one_selects_it(self):
        _armature, own, _points = self.registered()
        kept = own.moulage_skeleton.result
        self.assertEqual({row.name for row in kept.bones}, {"thigh", "shank"})
        for number, row in enumerate(kept.bones):
            self.assertIn(row.verdict, {"good", "doubtful", "failed"})
            kept.active_bone = number
            self.assertEqual(bpy.context.selected_objects, [row.object])
            self.assertEqual(row.object.parent_bone, row.name)

    def test_undo_takes_the_person_away(self):
        armature = leg()
        armature.moulage_skeleton.target = bent_target(armature, 0.6)[0]
        armature.moulage_skeleton.near = True
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.moulage.register("EXEC_DEFAULT", True)
        self.assertIn("leg person", bpy.data.objects)
        bpy.ops.ed.undo()
        self.assertNotIn("leg person", bpy.data.objects)
        self.assertIsNone(bpy.data.objects["leg"].moulage_skeleton.person)


class Scans(unittest.TestCase):
    """A label map and an image of the leg, in millimetres, in a scene of metres."""

    def write(self, path, values):
        head = (
            f"NRRD0004\ntype: short\ndimension: 3\nspace: right-anterior-superior\nsizes: {' '.join(map(str, values.shape[::-1]))}\n"
            "space directions: (0.5,0,0) (0,0.5,0) (0,0,0.5)\nspace origin: (-18,-10,-10)\nencoding: raw\nendian: little\n\n"
        )
        path.write_bytes(head.encode() + values.astype("<i2").tobytes())
        return str(path)

    def boxes(self, shift):
        """1 in the thigh, 2 in the shank, 0 elsewhere; the person lies `shift` mm along y."""
        z, y, x = numpy.meshgrid(*(0.5 * numpy.arange(n) - o for n, o in ((41, 10), (41, 10), (101, 18))), indexing="ij")
        inside = [
            (abs(x - c) < h[0]) & (abs(y - shift) < h[1]) & (abs(z) < h[2])
            for c, h in ((0, (10, 2, 3)), (18, (7, 1.5, 2.5)))
        ]
        return inside[0] + 2 * inside[1]

    def in_metres(self):
        armature = leg()
        armature.matrix_world = Matrix.Scale(0.001, 4)
        bpy.context.view_layer.update()
        armature.moulage_skeleton.near = True
        return armature

    def test_a_label_map_with_a_label_for_each_bone_or_one_for_all(self):
        armature = self.in_metres()
        data = armature.moulage_skeleton
        with tempfile.TemporaryDirectory() as folder:
            data.target_kind, data.label_map = "LABELS", self.write(Path(folder) / "labels.nrrd", self.boxes(1.0))
            with self.assertRaisesRegex(RuntimeError, "has the labels 1, 2"):
                bpy.ops.moulage.register()
            for name, label in (("thigh", 1), ("shank", 2)):
                armature.pose.bones[name].moulage.label = label
            bpy.ops.moulage.register()
            apart = world_points(bpy.data.objects["shank mesh person"])
            self.write(Path(folder) / "labels.nrrd", (self.boxes(1.0) > 0) * 7)
            bpy.ops.moulage.register()
            together = world_points(bpy.data.objects["shank mesh person"])
        for shape in (apart, together):
            numpy.testing.assert_allclose(shape.mean(axis=0), (0.018, 0.001, 0), atol=4e-4)

    def test_an_image_of_the_person_by_what_the_template_shows_in_its_own(self):
        armature = self.in_metres()
        data = armature.moulage_skeleton
        noise = numpy.random.default_rng(1).normal(0, 15, (41, 41, 101))
        with tempfile.TemporaryDirectory() as folder:
            images = [
                self.write(Path(folder) / f"{name}.nrrd", 100 + 400 * (self.boxes(shift) > 0) + noise)
                for name, shift in (("reference", 0.0), ("person", 0.8))
            ]
            data.target_kind, data.reference, data.image = "IMAGE", *images
            bpy.ops.moulage.register()
        shape = world_points(bpy.data.objects["thigh mesh person"])
        self.assertAlmostEqual(shape.mean(axis=0)[1], 0.0008, delta=3e-4)
