"""Answers that can be checked by hand, of what needs more than arrays in and out: files, pairs, distances, tets.

    python tests/python/test_answers.py
"""

import dataclasses
import tempfile
import unittest
from pathlib import Path

import numpy

import moulage
from moulage import interface, native
from test_package import HAND, cube


class Answers(unittest.TestCase):
    def setUp(self):
        self.points, self.triangles = cube()
        self.surface = moulage.TriMesh(self.points, self.triangles)
        self.tets = moulage.Tetrahedralization(self.surface, "lattice", 300)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def file(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def test_pins_are_met_and_landmarks_give_way(self):
        problem = moulage.Reshaping(self.tets)
        problem.set_markers(self.points)
        target = self.points[:1] + (0.0, 0.0, -0.2)
        problem.set_landmarks(self.points[:1], target)
        distances = []
        for within in (-1, 0.1, 0):
            problem.set_pins([within])
            distances.append(problem.run().landmark_distances[0])
        self.assertGreater(distances[0], 0.15)
        self.assertAlmostEqual(distances[1], 0.1, delta=5e-3)
        self.assertLess(distances[2], 5e-3)
        with self.assertRaisesRegex(moulage.Error, "2 lengths for 1 landmarks"):
            problem.set_pins([0, 0])
        self.assertEqual(moulage.Pairs(self.points[:1], target).within.tolist(), [-1])

    def test_findings_tell_what_mends_them(self):
        self.assertEqual(moulage.inspect(moulage.TriMesh(self.points, self.triangles), numpy.vstack([self.points] * 2)), [])
        far = self.points * (1, 2, 3) + (40, 30, 20)
        turned = far @ [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
        (found,) = moulage.inspect(moulage.TriMesh(turned, self.triangles), numpy.vstack([far, far]))
        self.assertEqual((found.concern, found.severity, found.exchange), ("up_axis", "refused", None))
        self.assertRegex(found.text, "turned from . up to . up")
        numpy.testing.assert_allclose(turned @ found.motion[:3, :3].T + found.motion[:3, 3], far, atol=1e-9)
        self.assertGreater(found.distance, 10 * found.mended_distance)
        places = far[[0, 1, 2, 4, 7]]
        pairs = moulage.Pairs(places, places[[1, 0, 2, 3, 4]], labels=["left", "right", None, None, None])
        self.assertEqual(pairs.labels, ["left", "right", "2", "3", "4"])
        (found,) = moulage.inspect(moulage.TriMesh(far, self.triangles), landmarks=pairs)
        self.assertEqual((found.concern, found.exchange, found.motion), ("exchange", (0, 1), None))
        self.assertIn("'left' and 'right'", found.text)
        with self.assertRaisesRegex(ValueError, "3 targets for 2"):
            moulage.Pairs(places[:2], places[:3])
        with self.assertRaisesRegex(moulage.Error, "vertex 8 does not exist"):
            moulage.inspect(moulage.TriMesh(far, self.triangles), far, fixed=[8])

    def test_distances_of_and_to_a_surface(self):
        numpy.testing.assert_allclose(self.surface.distances_of([[0.5, 0.5, 3], [0.5, 0.5, 0.5]]), [2, 0.5])
        numpy.testing.assert_allclose(self.surface.distances_to([[0, 0, 2]]), numpy.linalg.norm(self.points - (0, 0, 2), axis=1))

    def test_places_and_values_of_points_are_found_on_a_surface(self):
        numpy.testing.assert_allclose(self.surface.closest_points([[0.5, 0.5, 3], [2, 2, 2]]), [[0.5, 0.5, 1], [1, 1, 1]])
        heights = self.surface.interpolate(self.points, self.points[:, 2])
        numpy.testing.assert_allclose(heights, self.points[:, 2], atol=0.05)
        near = self.surface.interpolate(self.points[:1] + [[0, 0, 0], [0.01, 0, 0]], [1, 3])
        self.assertAlmostEqual(near[0], 1, delta=0.05)
        self.assertTrue(numpy.isnan(near[-1]))
        with self.assertRaisesRegex(ValueError, "1 values for 2 points"):
            self.surface.interpolate(self.points[:2], [1])

    def test_pairs_of_points_are_aligned(self):
        turned = 2 * self.points[:, [1, 0, 2]] * (-1, 1, 1) + (5, 0, 0)
        matrix = moulage.align(self.points, turned, "similarity")
        numpy.testing.assert_allclose(matrix, [[0, -2, 0, 5], [2, 0, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]], atol=1e-12)
        numpy.testing.assert_allclose(numpy.linalg.det(moulage.align(self.points, turned)[:3, :3]), 1)
        with self.assertRaisesRegex(ValueError, "1 targets for 2"):
            moulage.align(self.points[:2], self.points[:1])

    def test_a_moved_cube_is_placed_and_saved_with_its_points(self):
        moved = self.points + (5, 0, 0)
        matrix = self.surface.align(landmarks=self.points, targets=moved, markers=moved)
        numpy.testing.assert_allclose(matrix, [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], atol=1e-6)
        self.surface.save(self.folder / "moved.obj", moved)
        numpy.testing.assert_allclose(moulage.TriMesh.load(self.folder / "moved.obj").points, moved)

    def test_tets_go_through_a_file_and_carry_the_surface_again(self):
        whole = moulage.TetMesh(self.tets.points, self.tets.tets)
        whole.save(self.folder / "tets.vtu")
        read = moulage.TetMesh.load(self.folder / "tets.vtu")
        numpy.testing.assert_array_equal(read.tets, whole.tets)
        numpy.testing.assert_allclose(read.points, whole.points, rtol=1e-6)
        given = moulage.Tetrahedralization.from_tets(self.surface, read)
        self.assertEqual((given.method, given.boundary_kept, given.warnings), ("given", False, []))
        self.assertTrue((given.inside_fractions <= 1).all())
        # A lattice tet counts by the share of it that is inside, coarsely: together about the cube's volume, where all tets
        # have half as much again.
        corners = given.points[given.tets]
        volumes = numpy.linalg.det(corners[:, 1:] - corners[:, :1]) / 6
        self.assertGreater(volumes.sum(), 1.5)
        self.assertAlmostEqual(volumes @ given.inside_fractions, 1, delta=0.25)

    def test_an_open_surface_is_filled_with_a_warning(self):
        open_cube = moulage.TriMesh(self.points, self.triangles[1:])
        (warning,) = moulage.Tetrahedralization(open_cube, "lattice", 300).warnings
        self.assertRegex(warning, "hole")

    def test_pairs_come_from_files_and_bones(self):
        path = self.file("pairs.csv", "label,vertex,target_x,target_y,target_z,weight\ntop,7,1,1,2,3\n")
        landmarks = moulage.Pairs.load_landmarks(self.surface, path)
        self.assertEqual((landmarks.labels, landmarks.warning), (["top"], None))
        numpy.testing.assert_array_equal(landmarks.template_vertices, [7])
        numpy.testing.assert_array_equal(landmarks.template_points, [[1, 1, 1]])
        numpy.testing.assert_array_equal(landmarks.targets, [[1, 1, 2]])
        numpy.testing.assert_array_equal(landmarks.weights, [3])
        bone = moulage.TriMesh(self.points + (1.1, 0, 0), self.triangles)
        there = moulage.TriMesh(self.points + (2.1, 0, 0), self.triangles)
        held = moulage.Pairs.from_bone(self.surface, bone, there, 0.2)
        numpy.testing.assert_allclose(held.targets - held.template_points, [[1, 0, 0]] * 4, atol=1e-12)
        chosen = moulage.Pairs.from_vertices(self.surface, [0, 7], bone, there)
        numpy.testing.assert_array_equal(chosen.template_vertices, [0, 7])
        numpy.testing.assert_allclose(chosen.targets - chosen.template_points, [[1, 0, 0]] * 2, atol=1e-12)
        with self.assertRaisesRegex(moulage.Error, "vertex 8 does not exist: there are 8"):
            moulage.Pairs.from_vertices(self.surface, [8], bone, there)
        with self.assertRaisesRegex(moulage.Error, "target"):
            moulage.Pairs.load_attachments(self.surface, self.file("bad.csv", "vertex\n7\n"))

    def test_a_result_tells_how_far_everything_is(self):
        problem = moulage.Reshaping(self.tets)
        targets = self.points[:4] * (1.2, 1, 1) - (0.1, 0, 0)
        problem.set_landmarks(self.points[:4], targets)
        held = self.points[4:7] + (0.2, 0, 0)
        problem.set_attachments(self.points[4:7], held)
        problem.set_markers([[0.5, 0.5, 1.1]])
        with self.assertRaisesRegex(moulage.Error, "number 0 is -1"):
            problem.set_markers([[0.5, 0.5, 1.1]], sigmas=[-1])
        with self.assertRaisesRegex(TypeError, "nothing beside them"):
            problem.set_markers(moulage.Markers([[0.5, 0.5, 1.1]]), [1])
        problem.set_markers(moulage.Markers([[0.5, 0.5, 1.1]]))
        problem.set_fixed([7])
        (note,) = problem.check()
        self.assertRegex(note, "only 1 markers")
        result = problem.run(moulage.ReshapingOptions(max_iterations=3))
        numpy.testing.assert_allclose(result.landmark_distances, numpy.linalg.norm(result.points[:4] - targets, axis=1), atol=1e-9)
        numpy.testing.assert_allclose(result.attachment_distances, numpy.linalg.norm(result.points[4:7] - held, axis=1), atol=1e-9)
        person = moulage.TriMesh(result.points, self.triangles)
        numpy.testing.assert_allclose(result.marker_distances, person.distances_of([[0.5, 0.5, 1.1]]), atol=1e-9)
        self.assertEqual(result.quality["tet_count"], len(self.tets.tets))
        self.assertEqual(result.plastic_strains.shape, (len(self.tets.tets), 3, 3))
        numpy.testing.assert_array_equal(result.tets, self.tets.tets)
        self.assertEqual(result.summary["remeshes"], 0)
        numpy.testing.assert_array_equal(result.surface.triangles, self.triangles)
        result.save(self.folder / "result.obj")
        numpy.testing.assert_allclose(moulage.TriMesh.load(self.folder / "result.obj").points, result.points, atol=1e-6)
        sure = result.uncertainty(8)
        self.assertEqual(repr(sure), "Uncertainty(8 plausible shapes)")
        changes = numpy.array([sure.shape(number) for number in range(8)]) - result.points
        numpy.testing.assert_allclose(sure.sd, numpy.sqrt((changes**2).sum(axis=2).mean(axis=0)))
        self.assertTrue((sure.sd_normal <= sure.sd + 1e-12).all() and (sure.sd_normal > 0).all())
        size = sure.summary
        edges = person.points[person.triangles]
        areas = numpy.linalg.norm(numpy.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0]), axis=1) / 2
        self.assertAlmostEqual(size["area"], areas.sum())
        self.assertTrue(0 < size["volume_sd"] < size["volume"] and size["area_sd"] > 0)
        with self.assertRaisesRegex(moulage.Error, "no shape 8: there are 8"):
            sure.shape(8)
        with self.assertRaisesRegex(moulage.Error, "1 plausible shapes do not tell"):
            result.uncertainty(1)
        result.save_tets(self.folder / "result.vtu")
        numpy.testing.assert_allclose(moulage.TetMesh.load(self.folder / "result.vtu").points, result.tet_points, atol=1e-6)
        apart = moulage.Separation()
        apart.add_result("cube", result)
        apart.add_obstacle("far", moulage.TriMesh(self.points + (9, 0, 0), self.triangles))
        self.assertTrue(apart.run().summary["separated"])

    def test_pairs_go_into_a_problem_with_nothing_beside_them(self):
        path = self.file("pairs.csv", "vertex,target_x,target_y,target_z\n" + "".join(
            f"{i},{1.5 * x},{y},{z}\n" for i, (x, y, z) in enumerate(self.points)))
        pairs = moulage.Pairs.load_landmarks(self.surface, path)
        problem = moulage.Reshaping(self.tets)
        problem.set_landmarks(pairs)
        problem.set_attachments(pairs)
        problem.set_attachments([pairs, pairs])
        with self.assertRaisesRegex(TypeError, "give nothing beside them"):
            problem.set_attachments([pairs], pairs.targets)
        problem.set_attachments_at_vertices([], numpy.empty((0, 3)))
        problem.load_fixed(self.file("fixed.csv", "vertex\n0\n"))
        result = problem.run(moulage.ReshapingOptions(landmark_tolerance=0.01))
        numpy.testing.assert_allclose(result.points, pairs.targets, atol=0.05)
        for set_pairs in (problem.set_landmarks, problem.set_attachments):
            with self.assertRaisesRegex(TypeError, "give nothing beside them"):
                set_pairs(pairs, pairs.targets)

    def test_a_wait_tells_whether_the_end_has_come(self):
        problem = moulage.Reshaping(self.tets)
        problem.set_landmarks_at_vertices(range(8), self.points * (1.5, 1, 1))
        run = problem.start()
        self.assertTrue(run.wait_for(float("inf")) and run.poll().ended)
        with self.assertRaisesRegex(moulage.Error, "seconds is -1"):
            run.wait_for(-1)

    def test_a_hand_moves_in_a_scene_and_is_no_opensim_model(self):
        hand = moulage.Skeleton.load(HAND / "skeleton.json")
        self.assertEqual(hand.notes, [])
        numpy.testing.assert_array_equal(hand.surface.points, hand.points)
        last = len(hand.bone_triangles("5distph"))
        ends = hand.surface.points[hand.surface.triangles[-last:]]
        numpy.testing.assert_array_equal(ends, hand.bone_points(26)[hand.bone_triangles(26)])
        name = list(hand.angles)[0]
        moulage.Motion(hand, [0, 1], {name: [0, 0.2]}).save(self.folder / "bend.mot")
        hand.save_motion(self.folder / "bend.mot", self.folder / "bend.glb")
        self.assertEqual((self.folder / "bend.glb").read_bytes()[:4], b"glTF")
        with self.assertRaises(moulage.Error):
            hand.save_osim(self.folder / "none.osim", self.folder / "out.osim", 70.0)
        with self.assertRaises(moulage.Error):
            hand.save_osim(self.folder / "none.osim", self.folder / "out.osim")

    def test_an_image_of_another_kind_of_target_is_taken(self):
        ball = moulage.Volume.from_array(numpy.eye(8)[:, :, None] * numpy.ones(8))
        registration = moulage.Registration(moulage.Skeleton([("cube", self.surface)]))
        registration.set_image(ball, ball)
        larger = moulage.TriMesh(self.points * 1.1, self.triangles)
        registration.set_target(larger)
        result = registration.run(moulage.RegistrationOptions(align=False, max_iterations=2))
        self.assertIsInstance(result.warnings, list)

    def test_a_target_in_metres_is_refused_unless_it_is_meant(self):
        registration = moulage.Registration(moulage.Skeleton([("cube", self.surface)]))
        registration.set_target(moulage.TriMesh(self.points / 1000, self.triangles))
        with self.assertRaisesRegex(moulage.Error, "metres"):
            registration.run(moulage.RegistrationOptions(align=False))
        found = registration.run(moulage.RegistrationOptions(align=False, as_is=True)).skeleton
        self.assertLess(numpy.ptp(found.points), 0.01 * numpy.ptp(self.points))

    def test_options_have_the_library_s_defaults(self):
        for options, name in (
            (moulage.ReshapingOptions(), "reshaping_options"), (moulage.RegistrationOptions(), "registration_options"),
            (moulage.SeparationOptions(), "separation_options"), (moulage.Clicks(), "clicks"),
        ):
            words = "".join(word.capitalize() for word in name.split("_"))
            struct = getattr(interface, f"Mlg{words}")()
            native.get(f"{name}_init", native.byref(struct), struct.struct_size)
            theirs = struct.fields()
            ours = {field.name: getattr(options, field.name) for field in dataclasses.fields(options)}
            if "limits" in ours:
                ours["limits"] = interface.LIMITS.index(ours["limits"])
                ours["radii"] = ours["radii"] or None
            for key in ("reserved", "reserved_too", "radius_count"):
                self.assertEqual(theirs.pop(key, 0), 0)
            self.assertEqual(theirs, ours)

    def test_objects_say_what_they_are(self):
        self.assertEqual(repr(self.surface), "TriMesh(8 points, 12 triangles)")
        self.assertEqual(repr(moulage.TetMesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2, 3)])), "TetMesh(4 points, 1 tets)")
        self.assertRegex(repr(self.tets), r"Tetrahedralization\(\d+ points, \d+ tets, by lattice\)")
        self.assertEqual(repr(moulage.Markers(self.points)), "Markers(8 points)")
        self.assertEqual(repr(moulage.Pairs.from_bone(self.surface, self.surface, self.surface, 0.1)), "Pairs(8 pairs)")
        self.assertEqual(repr(moulage.Volume.from_array(numpy.ones((2, 3, 4)), (1, 1, 2.5))), "Volume(2 x 3 x 4 voxels of 1 x 1 x 2.5 mm)")
        skeleton = moulage.Skeleton([("cube", self.surface)])
        self.assertEqual(repr(skeleton), "Skeleton(1 bones, 0 joints)")
        registration = moulage.Registration(skeleton)
        registration.set_target(self.surface)
        found = registration.run(moulage.RegistrationOptions(align=False))
        self.assertEqual(repr(found), "RegistrationResult(good; 0 bones are not good)")
        problem = moulage.Reshaping(self.tets)
        problem.set_landmarks_at_vertices(range(8), self.points)
        result = problem.run()
        self.assertRegex(repr(result), r"ReshapingResult\(\w+ after \d+ iterations\)")
        apart = moulage.Separation()
        apart.add_result("cube", result)
        apart.add_obstacle("far", moulage.TriMesh(self.points + 9, self.triangles))
        self.assertRegex(repr(apart.run()), r"SeparationResult\(parted after \d+ rounds\)")

    def test_limits_have_names(self):
        registration = moulage.Registration(moulage.Skeleton([("cube", self.surface)]))
        registration.set_target(self.surface)
        with self.assertRaisesRegex(ValueError, "known are hard, soft, none"):
            registration.run(moulage.RegistrationOptions(limits="loose"))
        for limits in ("hard", "soft", "none"):
            self.assertFalse(registration.run(moulage.RegistrationOptions(align=False, limits=limits)).summary["cancelled"])

    def test_a_bone_that_the_target_hardly_shows_is_in_doubt_with_its_reasons(self):
        registration = moulage.Registration(moulage.Skeleton([("cube", self.surface)]))
        corner = self.points[self.triangles[0]]
        registration.set_target(moulage.TriMesh(corner[0] + 0.3 * (corner - corner[0]), [[0, 1, 2]]))
        result = registration.run(moulage.RegistrationOptions(align=False))
        fit = result.bone_fit(0)
        self.assertNotEqual(fit["verdict"], "good")
        self.assertNotEqual(result.summary["verdict"], "good")
        self.assertEqual(result.seen.shape, (len(self.points),))
        self.assertLess(result.seen.mean(), 0.5)
        self.assertEqual(result.summary["suspicious_bones"], 1)
        self.assertIn("lie on the target", " ".join(fit["reasons"]))
        self.assertIn("cube", " ".join(result.warnings))


if __name__ == "__main__":
    unittest.main()
