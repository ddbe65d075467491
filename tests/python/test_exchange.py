"""Surfaces and images of other packages, there and back; pictures and bars.

    python tests/python/test_exchange.py
"""

import contextlib
import io
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import nibabel
import numpy
import pyvista
import SimpleITK
import trimesh
from PIL import Image

import moulage
from test_package import HAND, LIVER, cube


def longer_cube():
    problem = moulage.Reshaping(moulage.Tetrahedralization(moulage.TriMesh(*cube()), "lattice", 300))
    problem.set_landmarks_at_vertices(range(8), cube()[0] * (1.5, 1, 1))
    return problem


def reshaped():
    """A cube that was marked on one side only."""
    problem = longer_cube()
    problem.set_markers([(1.5, 0.2, 0.5), (1.5, 0.8, 0.5)])
    return problem.run(moulage.ReshapingOptions(landmark_tolerance=0.01))


class Surfaces(unittest.TestCase):
    def test_trimesh_and_pyvista_keep_points_and_triangles_there_and_back(self):
        points, triangles = cube()
        ours = moulage.TriMesh(points, triangles)
        for other in (ours.to_trimesh(), ours.to_pyvista(), pyvista.PolyData.from_regular_faces(points, triangles)):
            back = moulage.TriMesh.of(other)
            numpy.testing.assert_array_equal(back.points, points)
            numpy.testing.assert_array_equal(back.triangles, triangles)
        self.assertIs(moulage.TriMesh.of(ours), ours)

    def test_polygons_of_pyvista_are_split(self):
        box = pyvista.Box((0, 1, 0, 1, 0, 1)).clean()
        self.assertFalse(box.is_all_triangles)
        surface = moulage.TriMesh.of(box)
        self.assertEqual((surface.check(), len(surface.triangles)), ([], 12))
        self.assertAlmostEqual(surface.to_trimesh().volume, 1)

    def test_what_is_no_surface_is_said(self):
        with self.assertRaisesRegex(TypeError, "a dict is no surface; give a moulage.TriMesh, a trimesh.Trimesh"):
            moulage.TriMesh.of({})

    def test_every_method_takes_them(self):
        ball = trimesh.creation.icosphere(subdivisions=2, radius=10.0)
        tets = moulage.Tetrahedralization(ball, "lattice", 300)
        self.assertEqual(len(tets.surface.points), len(ball.vertices))
        self.assertAlmostEqual(tets.to_pyvista().volume, tets.quality["volume"], places=6)
        apart = moulage.Separation()
        apart.add_body("ball", moulage.TetMesh(tets.points, tets.tets), ball)
        apart.add_obstacle("box", pyvista.Box((20, 30, 20, 30, 20, 30)))
        self.assertTrue(apart.run().summary["separated"])
        skeleton = moulage.Skeleton([("ball", ball), ("box", pyvista.Box((20, 30, 20, 30, 20, 30)))])
        self.assertEqual(skeleton.to_pyvista().keys(), ["ball", "box"])
        numpy.testing.assert_array_equal(skeleton.bone("box").points, skeleton.bone_points(1))
        with self.assertRaisesRegex(KeyError, "no bone 'bone'; there are ball, box"):
            skeleton.bone("bone")
        self.assertEqual(len(moulage.section(ball, (0, 0, 0), (0, 0, 1))), 1)


class Images(unittest.TestCase):
    def test_nibabel_and_simpleitk_see_the_same_image_there_and_back(self):
        path = LIVER / "scan.nii.gz"
        ours = moulage.Volume(path)
        others = nibabel.load(path), SimpleITK.ReadImage(str(path)), ours.to_nibabel(), ours.to_sitk()
        for other in (*others, str(path), ours):
            volume = moulage.Volume.of(other)
            numpy.testing.assert_array_equal(volume.values, ours.values)
            numpy.testing.assert_allclose(volume.info["world_from_voxel"], ours.info["world_from_voxel"], atol=1e-4)

    def test_a_turned_image_lies_where_it_lay(self):
        turned = [[0, -1, 0], [0, 0, 1], [1, 0, 0]]
        ours = moulage.Volume.from_array(numpy.arange(24.0).reshape(2, 3, 4), (1, 2, 3), (10, 20, 30), turned)
        corner = ours.to_sitk().TransformIndexToPhysicalPoint((1, 2, 3))
        world = ours.info["world_from_voxel"] @ (1, 2, 3, 1)
        numpy.testing.assert_allclose(numpy.array(corner) * (-1, -1, 1), world)
        numpy.testing.assert_allclose((ours.to_nibabel().affine @ (1, 2, 3, 1))[:3], world)

    def test_what_is_no_image_is_said(self):
        with self.assertRaisesRegex(TypeError, "a list is no image; give a path"):
            moulage.Volume.of([])
        with self.assertRaisesRegex(ValueError, "where \\('i', 'j', 'k'\\) is needed"):
            moulage.Volume.of(SimpleITK.Image([2, 2], SimpleITK.sitkFloat32))


class Pictures(unittest.TestCase):
    def picture(self, result, **how):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "ü.png"
            result.plot(screenshot=path, window_size=(300, 200), **how)
            with Image.open(path) as picture:
                return len(set(picture.convert("RGB").get_flattened_data()))

    def test_a_reshaping_has_its_heat_maps(self):
        result = reshaped()
        drawn = result.to_pyvista()
        self.assertEqual(set(drawn.point_data.keys()), {"stretch", "stretch_min", "moved", "marker_distance"})
        numpy.testing.assert_array_equal(drawn["stretch"], result.max_stretches)
        self.assertAlmostEqual(drawn["moved"].max(), 0.5, delta=0.05)
        self.assertLess(drawn["marker_distance"].min(), 0.7)
        for heat in ("stretch", "marker_distance", None):
            self.assertGreater(self.picture(result, heat=heat), 20)

    def test_a_registration_has_its_verdicts(self):
        problem = moulage.Registration(moulage.Skeleton.load(HAND / "skeleton.json"))
        problem.set_target(moulage.TriMesh.load(HAND / "target_surface.ply"))
        result = problem.run(moulage.RegistrationOptions(max_iterations=3))
        blocks = result.to_pyvista()
        self.assertEqual(blocks.n_blocks, 27)
        verdicts = {name: block["verdict"][0] for name, block in zip(blocks.keys(), blocks)}
        for name in ("lunate", "2distph"):
            expected = ("good", "doubtful", "failed").index(result.bone_fit(name)["verdict"])
            self.assertEqual(verdicts[name], expected)
        self.assertEqual(blocks[0]["distance"].shape, (blocks[0].n_points,))
        numpy.testing.assert_array_equal(numpy.concatenate([block["seen"] for block in blocks]), result.seen)
        for heat in (None, "distance"):
            self.assertGreater(self.picture(result, heat=heat), 20)

    def test_without_pyvista_a_sentence_says_how_to_get_it(self):
        with mock.patch.dict(sys.modules, {"pyvista": None}):
            with self.assertRaisesRegex(ImportError, "plot needs pyvista, .* pip install pyvista"):
                reshaped().plot()


class Bars(unittest.TestCase):
    def told(self):
        problem = longer_cube()
        with contextlib.redirect_stderr(io.StringIO()) as said:
            problem.run(progress=True)
        return said.getvalue()

    def test_tqdm_draws_the_bar_where_it_is(self):
        self.assertRegex(self.told(), r"100 %\|.*iterations")

    def test_without_tqdm_a_line_tells(self):
        with mock.patch.dict(sys.modules, {"tqdm": None, "tqdm.auto": None}):
            self.assertRegex(self.told(), r"\r100 % .*iterations")


if __name__ == "__main__":
    unittest.main(verbosity=2)
