"""Live editing: the shape follows what is moved."""

import tempfile
import time
import unittest
from pathlib import Path

import bpy
from mathutils import Vector

import scenes
from scenes import part, shape_of

# Steps of live editing without a run after which nothing more is waited for.
PATIENCE = 500


class Live(unittest.TestCase):
    def setUp(self):
        self.template = scenes.ball_and_markers(tet_count=1500, iterations=15)
        data = self.template.moulage
        # Landmarks alone: dense markers would outvote one that moves.
        data.markers = None
        for axis in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)):
            bpy.ops.moulage.add_landmark(template_point=axis, target=scenes.egg([axis])[0])
        data.landmark_tolerance = 0.01
        self.tip = max(range(len(self.template.data.vertices)), key=lambda v: self.template.data.vertices[v].co.x)
        self.state = bpy.context.window_manager.moulage

    def tearDown(self):
        # Opening a file has made the old references invalid.
        bpy.context.window_manager.moulage.live_edit = False
        part("live_edit").step(bpy.context)

    def step(self):
        bpy.context.view_layer.update()
        self.assertTrue(part("live_edit").step(bpy.context))
        time.sleep(0.02)

    def steps_until(self, condition, what):
        """Waits while a run goes on, and for a number of steps without one."""
        idle = 0
        while not condition():
            idle = 0 if part("runs").is_running() else idle + 1
            self.assertLess(idle, PATIENCE, f"waited in vain for {what}")
            self.step()

    def a_few_steps(self):
        for _ in range(10):
            self.step()

    def place(self):
        return Vector(shape_of(self.template)[self.tip].tolist())

    def test_a_moved_landmark_takes_the_shape_along(self):
        bpy.ops.moulage.reshape()
        before = self.place()
        self.state.live_edit = True
        self.a_few_steps()
        self.assertFalse(part("runs").is_running(), "nothing was moved")
        self.template.moulage.landmarks[0].target.location.x += 0.15
        self.steps_until(lambda: (self.place() - before).x > 0.08, "the tip that follows")
        self.template.moulage.landmarks[0].target.location.x -= 0.15
        self.steps_until(lambda: abs((self.place() - before).x) < 0.04, "the tip that comes back")

    def test_a_dragged_landmark_is_met_among_markers_that_contradict_it(self):
        data = self.template.moulage
        data.markers = scenes.add_mesh("dense", scenes.egg(scenes.points_of(self.template.data)), [])
        # The tip is a vertex: what is said of the pin is said of it.
        tip = self.template.data.vertices[self.tip].co
        data.landmarks[0].template.location = tip
        bpy.context.view_layer.update()
        bpy.ops.moulage.reshape()
        before = self.place()
        data.landmarks[0].target.location = before
        self.state.live_edit = True
        self.a_few_steps()
        self.assertEqual({landmark.hold for landmark in data.landmarks}, {"HINT"})
        data.landmarks[0].target.location.x += 0.12
        self.steps_until(lambda: (self.place() - before).x > 0.117, "the tip at the pin")
        self.steps_until(lambda: not part("runs").is_running(), "the end")
        self.assertEqual([landmark.hold for landmark in data.landmarks], ["EXACT"] + 5 * ["HINT"])
        self.assertLess(data.landmarks[0].residual, 0.003)
        self.assertGreaterEqual(data.result.mean_before, 0)
        # How sure the edited shape is is not known until the next whole run.
        self.assertEqual(tuple(data.result.volume), (-1.0, -1.0))
        with self.assertRaisesRegex(RuntimeError, "known after a whole run"):
            bpy.ops.moulage.show_heat_map(kind="SURE")
        # Undo puts it back, and it is the hint that it was.
        data.landmarks[0].hold, data.landmarks[0].target.location = "HINT", before
        part("live_edit").after_undo(bpy.context)
        self.steps_until(lambda: abs((self.place() - before).x) < 0.02, "the tip that comes back")
        self.assertEqual(data.landmarks[0].hold, "HINT")

    def test_it_goes_on_after_the_file_was_opened_again(self):
        bpy.ops.moulage.reshape()
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "saved.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
        self.template, self.state = bpy.context.scene.moulage.template, bpy.context.window_manager.moulage
        before = self.place()
        self.assertFalse(self.state.live_edit)
        self.state.live_edit = True
        self.steps_until(lambda: part("solve").can_go_on(self.template), "the result, found once more")
        self.assertLess((self.place() - before).length, 1e-6)
        self.template.moulage.landmarks[0].target.location.x += 0.15
        self.steps_until(lambda: (self.place() - before).x > 0.08, "the tip that follows")
        self.tearDown()
        bpy.ops.wm.read_homefile(use_empty=True)

    def test_settings_that_changed_ask_for_a_whole_run(self):
        bpy.ops.moulage.reshape()
        self.state.live_edit = True
        self.a_few_steps()
        self.template.moulage.tolerance = 0.123
        self.template.moulage.landmarks[0].target.location.x += 0.1
        self.steps_until(lambda: "reshape once more" in self.template.moulage.result.ending, "the sentence")

    def test_it_begins_with_a_result_and_ends_when_it_is_switched_off(self):
        self.state.live_edit = True
        self.template.moulage.landmarks[0].target.location.x += 0.1
        self.a_few_steps()
        self.assertIsNone(self.template.data.shape_keys)
        self.state.live_edit = False
        self.assertFalse(part("live_edit").step(bpy.context))
