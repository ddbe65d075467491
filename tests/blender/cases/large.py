"""A million vertices, and the example script beside the command line."""

import math
import os
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import bpy
import numpy

import scenes
from scenes import part, points_of, shape_of


class Large(unittest.TestCase):
    def test_a_million_vertices(self):
        """A grid bent to a closed box of 1,000,002 vertices, reshaped with few tets."""
        scenes.empty_scene()
        template = scenes.add_mesh("large", *_dense_ball(1000, 1002))
        self.assertGreater(len(template.data.vertices), 1_000_000)
        marks = scenes.ball("marks", 3)
        marks.data.vertices.foreach_set("co", scenes.egg(points_of(marks.data)).astype(numpy.float32).ravel())
        bpy.context.scene.moulage.template = template
        data = template.moulage
        data.markers, data.method, data.tet_count, data.max_iterations = marks, "lattice", 600, 3
        began = time.monotonic()
        self.assertEqual(bpy.ops.moulage.reshape(), {"FINISHED"})
        print(f"a million vertices took {time.monotonic() - began:.0f} s")
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


class Liver(unittest.TestCase):
    """The example script, against the command line with the same options on the same coordinates."""

    def test_the_result_is_that_of_the_command_line(self):
        program = os.environ["MOULAGE_PROGRAM"]
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            template = scenes.run_example_script(folder / "liver.blend", max_iterations=12)
            self.assertLess(template.moulage.result.mean_distance, 2.0)
            self.assertTrue((folder / "liver.blend").is_file())
            self._write_inputs(template, folder)
            subprocess.run(
                [program, "reshape", "--template", folder / "template.obj", "--markers", folder / "markers.csv",
                 "--landmarks", folder / "landmarks.csv", "--tolerance", repr(float(template.moulage.tolerance)),
                 "--landmark-tolerance", "15", "--max-iterations", "12", "-o", folder / "out.obj"],
                check=False, capture_output=True,
            )
            lines = (folder / "out.obj").read_text().splitlines()
        theirs = numpy.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=float)
        ours = shape_of(template)
        size = float(numpy.ptp(ours, axis=0).max())
        difference = numpy.abs(ours - theirs).max()
        print(f"largest difference to the command line: {difference:.2e} of {size:.0f} mm")
        # A coordinate of some hundred millimetres in float32 is rounded by up to 2e-5.
        self.assertLess(difference, 1e-6 * 500)

    def _write_inputs(self, template, folder):
        """What Blender has, in all its digits: float32 coordinates are not those of the files."""
        bpy.context.view_layer.update()
        rest = points_of(template.data).astype(float)
        vertices = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in rest.tolist())
        faces = "".join("f " + " ".join(str(v + 1) for v in p.vertices) + "\n" for p in template.data.polygons)
        (folder / "template.obj").write_text(vertices + faces)
        marks = part("markers").points(template).tolist()
        (folder / "markers.csv").write_text("x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in marks))
        points, targets, _ = part("landmarks").pairs(template)
        rows = numpy.hstack([points, targets]).tolist()
        head = "template_x,template_y,template_z,target_x,target_y,target_z\n"
        (folder / "landmarks.csv").write_text(head + "".join(",".join(map(repr, row)) + "\n" for row in rows))
