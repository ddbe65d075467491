"""A hundred thousand vertices."""

import math
import unittest

import bpy
import numpy

import scenes
from scenes import points_of, shape_of


@scenes.in_the_newest
class Large(unittest.TestCase):
    def test_a_hundred_thousand_vertices(self):
        """A grid bent to a closed ball of 100,202 vertices, reshaped with few tets."""
        scenes.empty_scene()
        template = scenes.add_mesh("large", *_dense_ball(300, 334))
        self.assertGreater(len(template.data.vertices), 100_000)
        marks = scenes.ball("marks", 3)
        marks.data.vertices.foreach_set("co", scenes.egg(points_of(marks.data)).astype(numpy.float32).ravel())
        bpy.context.scene.moulage.template = template
        data = template.moulage
        data.markers, data.method, data.tet_count, data.max_iterations = marks, "lattice", 600, 3
        self.assertEqual(bpy.ops.moulage.reshape(), {"FINISHED"})
        numpy.testing.assert_allclose(numpy.ptp(shape_of(template), axis=0), numpy.ptp(scenes.egg(points_of(template.data)), axis=0), atol=0.1)


def _dense_ball(rings, sectors):
    """A sphere of rings * sectors + 2 vertices."""
    theta = math.pi * (numpy.arange(rings) + 1) / (rings + 1)
    phi = 2 * math.pi * numpy.arange(sectors) / sectors
    t, p = numpy.meshgrid(theta, phi, indexing="ij")
    points = numpy.stack([numpy.sin(t) * numpy.cos(p), numpy.sin(t) * numpy.sin(p), numpy.cos(t)], -1).reshape(-1, 3)
    points = numpy.vstack([points, [(0, 0, 1), (0, 0, -1)]])
    ring, sector = numpy.meshgrid(numpy.arange(rings - 1), numpy.arange(sectors), indexing="ij")
    following = (sector + 1) % sectors
    a, b = ring * sectors + sector, ring * sectors + following
    c, d = a + sectors, b + sectors
    faces = numpy.stack([a, c, d, a, d, b], -1).reshape(-1, 3)
    s = numpy.arange(sectors)
    n = (s + 1) % sectors
    top = numpy.stack([numpy.full(sectors, rings * sectors), s, n], -1)
    last = (rings - 1) * sectors
    bottom = numpy.stack([numpy.full(sectors, rings * sectors + 1), last + n, last + s], -1)
    return points, numpy.vstack([faces, top, bottom])
