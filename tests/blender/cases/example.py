"""The example script, beside the command line."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import bpy
import numpy

import scenes
from scenes import part, points_of, shape_of


# Few: the two are to agree, not to be good.
ITERATIONS = 4


@scenes.in_the_newest
class Liver(unittest.TestCase):
    """The example script, against the command line with the same options on the same coordinates."""

    def test_the_result_is_that_of_the_command_line(self):
        program = os.environ["MOULAGE_PROGRAM"]
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            template = scenes.run_example_script(folder / "liver.blend", max_iterations=ITERATIONS)
            self.assertLess(template.moulage.result.mean_distance, 2.0)
            self.assertTrue((folder / "liver.blend").is_file())
            self._write_inputs(template, folder)
            subprocess.run(
                [program, "reshape", "--template", folder / "template.obj", "--markers", folder / "markers.csv",
                 "--landmarks", folder / "landmarks.csv", "--tolerance", repr(float(template.moulage.tolerance)),
                 "--landmark-tolerance", "15", "--max-iterations", str(ITERATIONS), "-o", folder / "out.obj"],
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
