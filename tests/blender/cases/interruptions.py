"""Runs in the middle of other things; undo; saved files."""

import tempfile
import time
import unittest
from pathlib import Path

import bpy
import numpy

import scenes
from scenes import part, shape_of


def run_to_end(solve):
    while solve.tick():
        solve.show()
        time.sleep(0.01)


class Interruptions(unittest.TestCase):
    """A run in the middle of other things."""

    def started(self, **settings):
        template = scenes.ball_and_markers(**{"subdivisions": 4, "tet_count": 6000, "iterations": 60, **settings})
        template.moulage.tolerance = 1e-6
        return template, part("solve").Solve(bpy.context, template)

    def until_preview(self, solve):
        while solve.progress is None or solve.progress.iteration < 1:
            self.assertTrue(solve.tick(), "the run ended early")
            solve.show()
            time.sleep(0.01)

    def test_live_view_and_stop_keep_the_best(self):
        template, solve = self.started()
        self.until_preview(solve)
        while "Reshaped" not in (template.data.shape_keys.key_blocks if template.data.shape_keys else ()):
            self.assertTrue(solve.tick())
            solve.show()
            time.sleep(0.01)
        solve.stop()
        run_to_end(solve)
        self.assertIn("Stopped", solve.finish(bpy.context))
        self.assertGreater(numpy.ptp(shape_of(template), axis=0)[0], 2.1)
        self.assertFalse(part("runs").is_running())

    def test_stopped_before_the_first_shape_nothing_is_left(self):
        # So many tets that they are still being made.
        template, solve = self.started(tet_count=50_000)
        solve.stop()
        run_to_end(solve)
        with self.assertRaisesRegex(Exception, "Stopped before"):
            solve.finish(bpy.context)
        self.assertIsNone(template.data.shape_keys)

    def test_the_template_is_deleted(self):
        template, solve = self.started()
        self.until_preview(solve)
        bpy.data.objects.remove(template)
        run_to_end(solve)
        with self.assertRaisesRegex(Exception, "was deleted"):
            solve.finish(bpy.context)
        self.assertFalse(part("runs").is_running())

    def test_the_template_is_renamed(self):
        template, solve = self.started(iterations=2)
        template.name = "someone else"
        run_to_end(solve)
        solve.finish(bpy.context)
        self.assertEqual(template.moulage.result.key, "Reshaped")

    def test_the_template_s_vertices_change(self):
        template, solve = self.started(iterations=2)
        template.data.vertices.add(1)
        run_to_end(solve)
        with self.assertRaisesRegex(Exception, "vertices were changed"):
            solve.finish(bpy.context)

    def test_the_template_is_edited_when_the_run_ends(self):
        template, solve = self.started(iterations=2)
        bpy.context.view_layer.objects.active = template
        bpy.ops.object.mode_set(mode="EDIT")
        run_to_end(solve)
        self.assertTrue(solve.waits_for_object_mode)
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertFalse(solve.waits_for_object_mode)
        solve.finish(bpy.context)
        self.assertEqual(template.moulage.result.key, "Reshaped")

    def test_disabling_the_add_on_ends_the_run(self):
        import addon_utils

        template, solve = self.started()
        self.until_preview(solve)
        name = template.name
        addon_utils.disable(scenes.MODULE, default_set=False)
        self.assertTrue(solve.closed)
        self.assertIsNone(bpy.data.objects[name].data.shape_keys)
        addon_utils.enable(scenes.MODULE, default_set=False)
        self.assertEqual(scenes.ball_and_markers(iterations=1).moulage.max_iterations, 1)
        self.assertEqual(bpy.ops.moulage.reshape(), {"FINISHED"})

    def test_opening_another_file_ends_the_run(self):
        _template, solve = self.started()
        bpy.ops.wm.read_homefile(use_empty=True)
        self.assertTrue(solve.closed)
        self.assertFalse(part("runs").is_running())


class Keeping(unittest.TestCase):
    def test_undo_and_redo(self):
        scenes.ball_and_markers(iterations=2)
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.moulage.reshape("EXEC_DEFAULT", True)
        shape = shape_of(bpy.data.objects["ball"]).copy()
        bpy.ops.ed.undo()
        self.assertIsNone(bpy.data.objects["ball"].data.shape_keys)
        self.assertEqual(bpy.data.objects["ball"].moulage.result.key, "")
        bpy.ops.ed.redo()
        numpy.testing.assert_array_equal(shape_of(bpy.data.objects["ball"]), shape)

    def test_all_is_saved_in_the_file(self):
        template = scenes.ball_and_markers(iterations=2)
        bpy.ops.moulage.add_landmark(name="tip", template_point=(1, 0, 0), target=(1.4, 0, 0))
        bpy.ops.moulage.reshape()
        shape, residual = shape_of(template).copy(), template.moulage.landmarks[0].residual
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "saved.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
        template = bpy.context.scene.moulage.template
        numpy.testing.assert_array_equal(shape_of(template), shape)
        self.assertEqual(template.moulage.landmarks[0].target.name, "tip")
        self.assertAlmostEqual(template.moulage.landmarks[0].residual, residual, places=6)
        self.assertEqual(bpy.ops.moulage.reshape(), {"FINISHED"})
        # Not part of any test after this one.
        bpy.ops.wm.read_homefile(use_empty=True)
