"""Medical images and label maps: from files, from arrays, and what is made of them.

    python tests/python/test_images.py
"""

import tempfile
import unittest
from pathlib import Path

import numpy

import moulage
from test_package import cube


class Volumes(unittest.TestCase):
    def test_a_nrrd_is_sliced_at_its_place_in_the_world(self):
        values = numpy.zeros((4, 5, 6), numpy.int16)
        values[3, 4, 5] = 1000  # z, y, x: the farthest corner
        head = (
            "NRRD0004\ntype: short\ndimension: 3\nspace: right-anterior-superior\nsizes: 6 5 4\n"
            "space directions: (2,0,0) (0,2,0) (0,0,3)\nspace origin: (10,20,30)\nencoding: raw\nendian: little\n\n"
        )
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.nrrd"
            path.write_bytes(head.encode() + values.tobytes())
            volume = moulage.Volume(path)
        info = volume.info
        numpy.testing.assert_allclose(info["world_from_voxel"], [[2, 0, 0, 10], [0, 2, 0, 20], [0, 0, 3, 30]])
        plane = volume.plane((0, 0, 1), 39.0)
        pixels = volume.slice(plane, (1000, 500))
        row, column = numpy.unravel_index(pixels[:, :, 0].argmax(), pixels.shape[:2])
        place = plane.corner + column * plane.right + row * plane.down
        numpy.testing.assert_allclose(place, [20, 28, 39], atol=1.0)

    def test_a_plane_cuts_a_cube_in_a_square(self):
        surface = moulage.TriMesh(*cube())
        (line,) = moulage.section(surface, (0.5, 0.5, 0.25), (0, 0, 1))
        numpy.testing.assert_allclose(line[:, 2], 0.25)
        length = numpy.linalg.norm(numpy.diff(line, axis=0), axis=1).sum()
        self.assertAlmostEqual(length, 4.0)
        self.assertEqual(moulage.section(surface, (0, 0, 5), (0, 0, 1)), [])

    def test_an_array_becomes_an_image_at_its_place_and_gives_itself_back(self):
        values = numpy.arange(24, dtype=numpy.int16).reshape(2, 3, 4)
        turned = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
        for given in (values, numpy.asfortranarray(values), values.astype(float)):
            image = moulage.Volume.from_array(given, (1, 2, 3), (10, 20, 30), turned, lps=True)
            numpy.testing.assert_array_equal(image.values, values)
        place = image.info["world_from_voxel"]
        # Index j runs along -x of LPS, that is x of RAS.
        numpy.testing.assert_allclose(place, [[0, 2, 0, -10], [-1, 0, 0, -20], [0, 0, 3, 30]], atol=1e-12)
        affine = numpy.array([[2.0, 0, 0, 5], [0, 0, 1, 6], [0, 3, 0, 7]])
        image = moulage.Volume.from_array(values, origin=affine[:, 3], directions=affine[:, :3])
        numpy.testing.assert_allclose(image.info["world_from_voxel"], affine)
        with self.assertRaisesRegex(ValueError, "where \\('i', 'j', 'k'\\) is needed"):
            moulage.Volume.from_array(values[0])
        with self.assertRaisesRegex(moulage.Error, "grid.spacing\\[1\\] is 0"):
            moulage.Volume.from_array(values, (1, 0, 1))

    def test_labels_have_the_names_of_their_file(self):
        head = (
            "NRRD0004\ntype: uint8\ndimension: 3\nspace: right-anterior-superior\nsizes: 2 2 2\n"
            "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n"
            "Segment0_Name:=left kidney\nSegment0_LabelValue:=3\n\n"
        )
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "segments.seg.nrrd"
            path.write_bytes(head.encode() + bytes([0, 3, 5, 0, 0, 0, 0, 0]))
            segments = moulage.Volume(path)
        self.assertEqual((segments.labels, segments.label_names), ([3, 5], {3: "left kidney"}))

    def test_a_label_map_gives_its_labels_outlines_markers_and_surface(self):
        k, j, i = numpy.meshgrid(*[numpy.arange(-12, 13)] * 3, indexing="ij")
        ball = moulage.Volume.from_array(7 * (i**2 + j**2 + k**2 < 81), (2, 2, 2), (-24, -24, -24))
        self.assertEqual((ball.labels, ball.notes), ([7], []))
        (ring,) = ball.outlines(7, ball.plane((0, 0, 1), 0))
        numpy.testing.assert_allclose(ring[0], ring[-1])
        few = ball.label_markers(7, clicks=moulage.Clicks(spacing=12)).points
        many = ball.label_markers(7, [(0, 0, 1), (1, 0, 0)], moulage.Clicks(spacing=6, every=4)).points
        self.assertGreater(len(many), 3 * len(few))
        for points in (ring, few, many, ball.label_surface(7).points):
            numpy.testing.assert_allclose(numpy.linalg.norm(points, axis=1), 18, atol=1.5)
        with self.assertRaisesRegex(moulage.Error, "it has 7"):
            ball.label_markers(8)


if __name__ == "__main__":
    unittest.main()
