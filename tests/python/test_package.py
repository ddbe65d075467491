"""The Python package, installed from its wheel: runs from arrays to arrays.

    python tests/python/test_package.py
"""

import math
import os
import re
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import numpy

import moulage
from moulage import interface

ROOT = Path(__file__).resolve().parents[2]
LIVER = ROOT / "examples" / "liver"


def cube():
    points = numpy.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return points, numpy.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def long_run():
    """A run on the liver that goes on until it is stopped."""
    surface = moulage.TriMesh.load(LIVER / "template.obj")
    problem = moulage.Reshaping(moulage.Tetrahedralization(surface, "lattice", 3000))
    problem.set_markers(moulage.Markers.load(LIVER / "markers.csv"))
    return problem.start(moulage.ReshapingOptions(tolerance=1e-6))


class Arrays(unittest.TestCase):
    def setUp(self):
        self.points, self.triangles = cube()
        self.surface = moulage.TriMesh(self.points, self.triangles)
        self.tets = moulage.Tetrahedralization(self.surface, "lattice", 300)

    def test_surfaces_and_tets_give_back_their_arrays(self):
        numpy.testing.assert_array_equal(self.surface.points, self.points)
        numpy.testing.assert_array_equal(self.surface.triangles, self.triangles)
        self.assertEqual(self.surface.check(), [])
        self.assertEqual((self.tets.method, self.tets.tets.shape[1]), ("lattice", 4))
        self.assertEqual(self.tets.quality["tet_count"], len(self.tets.tets))

    def test_a_cube_becomes_longer(self):
        wish = self.points * (1.5, 1, 1)
        problem = moulage.Reshaping(self.tets)
        problem.set_landmarks_at_vertices(range(8), wish)
        seen = []
        result = problem.run(moulage.ReshapingOptions(landmark_tolerance=0.01), progress=seen.append)
        numpy.testing.assert_allclose(result.points, wish, atol=0.05)
        self.assertTrue(seen[-1].ended and result.summary["inverted_tets"] == 0)
        self.assertTrue(math.isnan(result.summary["mean_marker_distance"]))
        self.assertTrue((result.max_stretches > 1.3).all() and (result.min_stretches < 1.2).all())
        carried = result.carry([[0.5, 0.5, 0.5]])
        numpy.testing.assert_allclose(carried, [[0.75, 0.5, 0.5]], atol=0.05)

    def test_a_moved_landmark_is_followed_from_the_earlier_result(self):
        wish = self.points * (1.5, 1, 1)
        problem = moulage.Reshaping(self.tets)
        problem.set_landmarks_at_vertices(range(8), wish)
        options = moulage.ReshapingOptions(landmark_tolerance=0.01)
        earlier = problem.run(options)
        wish[-1] += (0.2, 0, 0)
        problem.set_landmarks_at_vertices(range(8), wish)
        again = problem.start_again(earlier, options).wait()
        numpy.testing.assert_allclose(again.points, wish, atol=0.05)
        with self.assertRaisesRegex(moulage.Error, "other options"):
            problem.start_again(earlier, moulage.ReshapingOptions(landmark_tolerance=0.02)).wait()

    def test_a_run_can_be_stopped_and_keeps_its_best(self):
        run = long_run()
        while run.poll().iteration < 1:
            time.sleep(0.01)
        run.cancel()
        self.assertEqual(run.wait().summary["stop"], "cancelled")

    def test_wrong_shapes_and_names_are_refused_before_the_library(self):
        with self.assertRaisesRegex(ValueError, "points: shape"):
            moulage.TriMesh([[1, 2]], self.triangles)
        for wrong in (-1, 2**32, 1.5, math.nan):
            with self.assertRaisesRegex(ValueError, "indices are whole numbers from 0"):
                moulage.TriMesh(self.points, [[0, 1, wrong]])
        problem = moulage.Reshaping(self.tets)
        with self.assertRaisesRegex(ValueError, "2 weights for 1 points"):
            problem.set_markers([[0, 0, 0]], [1, 1])
        with self.assertRaisesRegex(TypeError, "tolerence"):
            moulage.ReshapingOptions(tolerence=1)

    def test_what_the_library_refuses_comes_as_its_sentence(self):
        with self.assertRaisesRegex(moulage.Error, "no-such.obj"):
            moulage.TriMesh.load("no-such.obj")
        with self.assertRaisesRegex(moulage.Error, "do not determine a shape"):
            moulage.Reshaping(self.tets).run()

    def test_labels_and_weights_go_through_a_file(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "ä.mrk.json"
            moulage.Markers(self.points[:2], labels=["left", "Öhr"]).save(path)
            back = moulage.Markers.load(path)
        self.assertEqual(back.labels, ["left", "Öhr"])
        numpy.testing.assert_allclose(back.points, self.points[:2])


class Separations(unittest.TestCase):
    def setUp(self):
        """Two cubes whose sides overlap by a fifth, and a bone under the first."""
        points, triangles = cube()
        made = moulage.Tetrahedralization(moulage.TriMesh(points, triangles), "lattice", 120)
        self.tets = made.points, made.tets
        self.problem = moulage.Separation()
        for name, shift in (("left", 0.0), ("right", 0.8)):
            away = (shift, shift / 8, shift / 16)
            self.problem.add_body(name, moulage.TetMesh(made.points + away, made.tets))
        self.bone = moulage.TriMesh(points - (0.5, 0.05, 0.9), triangles)

    def test_cubes_leave_each_other_and_a_bone(self):
        self.problem.add_obstacle("Schlüsselbein", self.bone)
        seen = []
        result = self.problem.run(progress=seen.append)
        self.assertTrue(seen[-1].ended and result.summary["separated"])
        self.assertEqual(result.summary["ending"], "parted")
        pairs = {(o["first"], o["second"]) for o in result.overlaps}
        self.assertLessEqual({(0, 1), (0, 2)}, pairs)
        for overlap in result.overlaps:
            self.assertEqual((overlap["depth"][1], overlap["crossings"][1]), (0.0, 0))
        self.assertGreater(max(o["depth"][0] for o in result.overlaps), 0.05)
        body = result.body(0)
        self.assertEqual(body["inverted_tets"], 0)
        self.assertGreater(body["largest_move"], 0.05)
        self.assertEqual(result.tet_points(0).shape, self.tets[0].shape)
        low, high = self.bone.points.min(axis=0), self.bone.points.max(axis=0)
        in_bone = ((result.points(0) > low) & (result.points(0) < high)).all(axis=1)
        self.assertFalse(in_bone.any())

    def test_a_separation_can_be_stopped(self):
        run = self.problem.start(moulage.SeparationOptions(rings=3))
        while run.poll().iteration < 1 and not run.poll().ended:
            time.sleep(0.001)
        run.cancel()
        self.assertIn(run.wait().summary["ending"], ("cancelled", "parted"))
        with self.assertRaisesRegex(moulage.Error, "'left' already"):
            self.problem.add_obstacle("left", self.bone)
        with self.assertRaisesRegex(moulage.Error, "at least one ring"):
            self.problem.start(moulage.SeparationOptions(rings=0))


HAND = ROOT / "examples" / "hand"


class Skeletons(unittest.TestCase):
    def test_a_skeleton_goes_into_arrays_and_a_file_and_back(self):
        hand = moulage.Skeleton.load(HAND / "skeleton.json")
        surfaces = [moulage.TriMesh(hand.bone_points(i), hand.bone_triangles(i)) for i in range(27)]
        joints = hand.joints
        joints[3].shift_limit = 0.125
        made = moulage.Skeleton(zip(hand.bone_names, surfaces), joints)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "ö" / "hand.skeleton.json"
            path.parent.mkdir()
            made.save(path)
            made.save(path.with_name("hand.glb"))
            again = moulage.Skeleton.load(path)
        self.assertEqual(again.bone_names, hand.bone_names)
        numpy.testing.assert_array_equal(again.points, hand.points)
        self.assertEqual(len(again.joints), 26)
        for one, other in zip(again.joints, joints):
            self.assertEqual((one.name, one.parent, one.child), (other.name, other.parent, other.child))
            numpy.testing.assert_allclose(one.parent_frame, other.parent_frame, atol=1e-9)
            numpy.testing.assert_allclose(one.positive_limits, other.positive_limits, atol=1e-12)
        self.assertEqual(again.joints[3].shift_limit, 0.125)
        self.assertIn("cmc_flexion", hand.angles)

    def test_a_hand_is_registered_and_what_it_carries_moves(self):
        hand = moulage.Skeleton.load(HAND / "skeleton.json")
        problem = moulage.Registration(hand)
        problem.set_target(moulage.TriMesh.load(HAND / "target_surface.ply"))
        run = problem.start()
        previews = 0
        while not run.poll().ended:
            points = run.preview_points()
            if points is not None:
                self.assertEqual(points.shape, hand.points.shape)
                previews += 1
            time.sleep(0.02)
        result = run.wait()
        self.assertGreater(previews, 0)
        summary = result.summary
        self.assertEqual((summary["cancelled"], summary["joints_outside"]), (False, 0))
        self.assertLess(summary["mean_residual"], 0.05)
        fit = result.bone_fit(5)
        self.assertGreater(fit["seen"], 0.9)
        self.assertEqual((summary["verdict"], fit["verdict"], fit["reasons"]), ("good", "good", []))
        self.assertLessEqual(max(result.joint_pose(j)["usage"] for j in range(26)), 1.001)
        person = result.skeleton
        carried = result.carry(moulage.TriMesh(hand.bone_points(4), hand.bone_triangles(4)))
        self.assertLess(numpy.linalg.norm(carried - person.bone_points(4), axis=1).mean(), 2.0)

    def test_a_motion_goes_through_files(self):
        hand = moulage.Skeleton.load(HAND / "skeleton.json")
        times = numpy.arange(5) / 25
        bends = {name: 0.1 * times / times[-1] for name in list(hand.angles)[:3]}
        motion = moulage.Motion(hand, times, bends)
        self.assertEqual(motion.notes, "")
        with tempfile.TemporaryDirectory() as folder:
            for name in ("a.bvh", "a.mot", "a.glb"):
                motion.save(Path(folder) / name)
            read = moulage.Motion.load(hand, Path(folder) / "a.mot", flipped=list(bends)[:1])
            tree = moulage.Motion.load(hand, Path(folder) / "a.bvh")
            still = Path(folder) / "still.glb"
            hand.save(still)
            self.assertGreater((Path(folder) / "a.glb").stat().st_size, still.stat().st_size)
        numpy.testing.assert_allclose(read.times, times)
        for sign, (name, values) in zip((-1, 1, 1), bends.items()):
            numpy.testing.assert_allclose(read.angles[name], sign * values, atol=1e-9)
            numpy.testing.assert_allclose(tree.angles[name], values, atol=1e-6)
        other = moulage.Motion(hand, times, {"no such angle": times})
        self.assertIn("no such angle", other.notes)
        with self.assertRaisesRegex(moulage.Error, "times are finite and rise"):
            moulage.Motion(hand, times[::-1], bends)
        with self.assertRaisesRegex(ValueError, "one for each time"):
            moulage.Motion(hand, times, {"a": [1.0]})

    def test_a_shape_model_is_learnt_saved_and_holds_a_registration(self):
        hand = moulage.Skeleton.load(HAND / "skeleton.json")

        def finger(length, width):
            """The first two bones of a hand of another size."""
            surfaces = [
                moulage.TriMesh(hand.bone_points(b) * (width, width, length), hand.bone_triangles(b)) for b in (4, 5)
            ]
            return moulage.Skeleton(zip("ab", surfaces), [moulage.Joint("j", 0, 1)])

        template = finger(1, 1)
        samples = [finger(*sizes) for sizes in ((0.9, 1), (1.1, 1.04), (1, 0.93), (0.97, 1.08))]
        model = moulage.ShapeModel(template, samples)
        self.assertGreater(model.explained[1], 0.99)
        self.assertLess(moulage.left_out(template, samples).max(), 0.2)
        with tempfile.TemporaryDirectory() as folder:
            model.save(Path(folder) / "finger.h5.json")
            again = moulage.ShapeModel.load(template, Path(folder) / "finger.h5.json")
        numpy.testing.assert_allclose(again.deviations[:2], model.deviations[:2], rtol=1e-4)
        shapes = [model.shape([c]).points for c in (-1, 0, 1)]
        self.assertGreater(numpy.linalg.norm(shapes[2] - shapes[0], axis=1).max(), 0.5)
        with self.assertRaisesRegex(moulage.Error, "modes"):
            model.shape([0] * 9)
        with self.assertRaisesRegex(moulage.Error, "not of this template"):
            moulage.ShapeModel(template, [hand, hand])
        problem = moulage.Registration(template)
        wanted = finger(1.05, 1.02)
        for b in (0, 1):
            problem.set_bone_target(b, moulage.TriMesh(wanted.bone_points(b), wanted.bone_triangles(b)))
        problem.set_shape_model(model)
        result = problem.run(moulage.RegistrationOptions(align=False))
        self.assertEqual(len(result.coefficients), len(model.deviations))
        self.assertLess(numpy.linalg.norm(result.skeleton.points - wanted.points, axis=1).mean(), 0.3)

    def test_a_registration_can_be_stopped(self):
        hand = moulage.Skeleton.load(HAND / "skeleton.json")
        problem = moulage.Registration(hand)
        with self.assertRaisesRegex(moulage.Error, "has no target"):
            problem.run()
        problem.set_bone_target(0, moulage.TriMesh(hand.bone_points(0) + (3, 0, 0), hand.bone_triangles(0)))
        result = problem.run(moulage.RegistrationOptions(radii=[float("inf"), 20.0], align=False), progress=lambda now: False)
        self.assertTrue(result.summary["cancelled"])

    def test_wrong_frames_and_ends_are_refused(self):
        bones = [(name, moulage.TriMesh(*cube())) for name in "ab"]
        with self.assertRaisesRegex(ValueError, r"joint j: a frame has the shape \(4, 4\)"):
            moulage.Skeleton(bones, [moulage.Joint("j", 0, 1, numpy.eye(3))])
        with self.assertRaisesRegex(moulage.Error, "there is no bone 2"):
            moulage.Skeleton(bones, [moulage.Joint("j", 0, 2)])


class LibraryFile(unittest.TestCase):
    def sentence_with(self, path):
        code = "import moulage\ntry:\n    moulage.check_library()\nexcept moulage.LibraryError as e:\n    print(e)"
        environment = {**os.environ, "MOULAGE_LIBRARY": str(path)}
        done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
        return done.stdout

    def test_a_missing_or_foreign_library_is_said_in_a_sentence(self):
        self.assertIn("there is no /no/such/lib.so", self.sentence_with("/no/such/lib.so"))
        self.assertIn("cannot be loaded", self.sentence_with(__file__))
        with tempfile.TemporaryDirectory() as folder:
            source, library = Path(folder) / "other.c", Path(folder) / "other.so"
            for text, words in (
                ("int other;", "is not the moulage library"),
                ("unsigned mlg_abi_version(void) { return 999; }", "of another version (interface 999"),
                (f"unsigned mlg_abi_version(void) {{ return {interface.ABI_VERSION}; }}", "is older than this package"),
            ):
                source.write_text(text)
                subprocess.run(["cc", "-shared", "-fPIC", "-o", library, source], check=True)
                self.assertIn(words, self.sentence_with(library))


class Versions(unittest.TestCase):
    def test_all_places_name_the_same_version(self):
        version = re.search(r'^version = "(.+)"', (ROOT / "Cargo.toml").read_text(), re.M).group(1)
        manifest = (ROOT / "blender_addon" / "blender_manifest.toml").read_text()
        self.assertEqual(re.search(r'^version = "(.+)"', manifest, re.M).group(1), version)
        info = (ROOT / "blender_addon" / "__init__.py").read_text()
        self.assertIn(f'"version": ({", ".join(version.split("."))})', info)
        self.assertEqual((moulage.version(), moulage.__version__), (version, version))


if __name__ == "__main__":
    unittest.main(verbosity=2)
