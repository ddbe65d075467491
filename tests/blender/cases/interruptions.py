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

    def test_undo_in_the_middle_does_not_end_the_run(self):
        template = scenes.ball_and_markers(**{"subdivisions": 4, "tet_count": 6000, "iterations": 8})
        bpy.ops.ed.undo_push(message="ball and markers")
        bpy.ops.moulage.add_landmark("EXEC_DEFAULT", True, template_point=(1, 0, 0), target=(1.4, 0, 0))
        solve = part("solve").Solve(bpy.context, template)
        self.until_preview(solve)
        bpy.ops.ed.undo()
        run_to_end(solve)
        self.assertIn("Markers", solve.finish(bpy.context))
        template = bpy.context.scene.moulage.template
        self.assertEqual(template.moulage.result.key, "Reshaped")
        self.assertEqual(len(template.moulage.landmarks), 0)
        self.assertGreater(numpy.ptp(shape_of(template), axis=0)[0], 2.3)
        self.assertIn("reshape once more", template.moulage.result.warnings)

    def test_undo_to_before_the_template_was_chosen_does_not_end_it_either(self):
        template = scenes.ball_and_markers(tet_count=1500)
        bpy.context.scene.moulage.template = None
        template.moulage.uid = ""
        bpy.context.view_layer.objects.active = template
        bpy.ops.ed.undo_push(message="ball")
        bpy.ops.moulage.set_template("EXEC_DEFAULT", True)
        solve = part("solve").Solve(bpy.context, template)
        self.until_preview(solve)
        bpy.ops.ed.undo()
        run_to_end(solve)
        solve.finish(bpy.context)
        self.assertEqual(bpy.data.objects["ball"].moulage.result.key, "Reshaped")
        self.assertEqual(bpy.data.objects["ball"].moulage.result.warnings, "")

    def test_a_chosen_template_has_its_uid_in_the_step_of_undo(self):
        template = scenes.ball_and_markers()
        uid = template.moulage.uid
        self.assertTrue(uid)
        bpy.ops.ed.undo_push(message="chosen")
        bpy.ops.moulage.add_landmark("EXEC_DEFAULT", True, template_point=(1, 0, 0), target=(1.4, 0, 0))
        bpy.ops.ed.undo()
        self.assertEqual(bpy.context.scene.moulage.template.moulage.uid, uid)

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


class Steps(unittest.TestCase):
    """Every operator that changes something is one step of undo."""

    # They write files, ask, ask for the end, or push a step for each click.
    WITHOUT = {
        "stop", "reshape_anyway", "export_markers", "export_landmarks", "export_skeleton", "pick_landmarks", "click_markers",
    }

    def test_operators_can_be_undone(self):
        for cls in part("operators").classes:
            if issubclass(cls, bpy.types.Operator):
                name = cls.bl_idname.split(".")[1]
                self.assertEqual("UNDO" in getattr(cls, "bl_options", ()), name not in self.WITHOUT, name)

    def test_one_step_takes_all_of_it_back(self):
        def state():
            template = bpy.context.scene.moulage.template
            data = template.moulage
            scale = bpy.context.scene.unit_settings.scale_length
            return (
                len(bpy.data.objects), list(template.data.polygons[0].vertices), len(template.data.attributes), scale, data.findings,
                len(data.landmarks), len(data.attachments), data.markers.name, data.tets_text, data.heat,
                [tuple(round(v, 6) for v in row) for row in template.matrix_world],
            )

        template = scenes.ball_and_markers(iterations=1)
        for axis in ((1, 0, 0), (-1, 0, 0), (0, 1, 0)):
            bpy.ops.moulage.add_landmark(name="tip.L", template_point=axis, target=scenes.egg([axis])[0])
        bpy.ops.moulage.reshape()
        template.data.polygons[0].flip()
        bpy.context.view_layer.update()
        bpy.ops.ed.undo_push(message="ready")
        for name, options in (
            ("check_template", {}), ("fix_template", {}), ("use_millimetres", {}), ("place_template", {}),
            ("remove_landmark", {"all": True}), ("mirror_landmarks", {}), ("add_attachment", {}),
            ("import_markers", {"filepath": str(scenes.LIVER / "markers.csv")}),
            ("import_landmarks", {"filepath": str(scenes.LIVER / "landmarks.csv")}), ("tetrahedralize", {}),
            ("show_heat_map", {"kind": "STRETCH"}), ("copy_result", {}),
        ):
            with self.subTest(name):
                before = state()
                self.assertEqual(getattr(bpy.ops.moulage, name)("EXEC_DEFAULT", True, **options), {"FINISHED"})
                self.assertNotEqual(state(), before)
                bpy.ops.ed.undo()
                bpy.context.view_layer.update()
                self.assertEqual(state(), before)


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
