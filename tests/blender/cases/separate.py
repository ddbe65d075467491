"""Meshes that overlap are pushed apart, and what does not overlap stays as it is."""

import tempfile
import unittest
from pathlib import Path

import bpy
import numpy
from mathutils.bvhtree import BVHTree

import scenes
from cases.interruptions import run_to_end
from scenes import part, points_of

_CUBE = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
_SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def settings():
    return bpy.context.scene.moulage_separate


def now(ob):
    """The vertices as they are shown, in the world."""
    copy = ob.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = copy.to_mesh()
    points = part("mesh_data").transform(numpy.array(ob.matrix_world), points_of(mesh).astype(float))
    copy.to_mesh_clear()
    return points


def crossings(first, second):
    trees = [BVHTree.FromPolygons(now(ob).tolist(), [list(p.vertices) for p in ob.data.polygons]) for ob in (first, second)]
    return len(trees[0].overlap(trees[1]))


def select(*objects):
    for ob in bpy.context.scene.objects:
        ob.select_set(ob in objects)
    bpy.context.view_layer.objects.active = objects[0] if objects else None
    bpy.context.view_layer.update()


class Separate(unittest.TestCase):
    """Two balls that overlap, a ball far away, and a box under the first that stays."""

    def setUp(self):
        scenes.empty_scene()
        self.left, self.right, self.far = (scenes.ball(name) for name in ("left", "right", "far"))
        self.right.location = (1.7, 0.1, 0.05)
        # A frame of its own, mirrored.
        self.right.scale = (-1.0, 1.0, 1.0)
        self.far.location = (0, 5, 0)
        self.box = scenes.add_mesh("box", numpy.multiply(_CUBE, (0.5, 0.5, 0.2)), _SIDES)
        self.box.location = (-0.2, 0, -1.05)
        self.bones = bpy.data.collections.new("bones")
        bpy.context.scene.collection.children.link(self.bones)
        self.bones.objects.link(self.box)
        settings().bones, settings().method, settings().tet_count = self.bones, "lattice", 2000
        settings().rings, settings().gap, settings().live = 2, 0.0, True
        select(self.left, self.right, self.far, self.box)

    def refused(self, words):
        with self.assertRaises(RuntimeError) as caught:
            bpy.ops.moulage.separate()
        self.assertIn(words, str(caught.exception))
        self.assertFalse(part("runs").is_running())

    def test_balls_leave_each_other_and_the_box(self):
        before = {ob: now(ob) for ob in (self.left, self.right, self.far, self.box)}
        self.assertGreater(crossings(self.left, self.right), 0)
        self.assertGreater(crossings(self.left, self.box), 0)
        self.assertEqual(bpy.ops.moulage.separate(), {"FINISHED"})
        self.assertTrue(settings().clear, settings().report)
        for pair in ((self.left, self.right), (self.left, self.box)):
            self.assertEqual(crossings(*pair), 0)
        self.assertIn("left and right overlapped, ", settings().report)
        self.assertIn("left and box overlapped, ", settings().report)
        # Both yield, and only near the contact.
        for ob, side in ((self.left, 1.0), (self.right, -1.0)):
            moves = numpy.linalg.norm(now(ob) - before[ob], axis=1)
            self.assertGreater(moves.max(), 0.05)
            self.assertLess(moves.max(), 0.4)
            x, _, z = (before[ob] - before[ob].mean(axis=0)).T
            away = (side * x < -0.3) & (z > 0.3)
            self.assertGreater(away.sum(), 10)
            numpy.testing.assert_allclose(now(ob)[away], before[ob][away], atol=1e-6)
        for ob in (self.far, self.box):
            self.assertIsNone(ob.data.shape_keys)
            numpy.testing.assert_array_equal(now(ob), before[ob])
        self.assertEqual(len(self.left.data.uv_layers), 1)
        # From before to after.
        key = self.left.data.shape_keys.key_blocks["Separated"]
        key.value = 0.0
        numpy.testing.assert_allclose(now(self.left), before[self.left], atol=1e-6)

    def test_units_and_the_gap_are_the_scene_s(self):
        bpy.context.scene.unit_settings.scale_length = 0.001
        select(self.left, self.right)
        settings().bones, settings().rings = None, 5
        bpy.ops.moulage.separate()
        self.assertRegex(settings().report, r"left and right overlapped, 0\.\d+ mm deep")
        near = self.distance()
        for ob in (self.left, self.right):
            ob.shape_key_clear()
        settings().gap = 0.1
        bpy.ops.moulage.separate()
        self.assertTrue(0 < 3 * near < self.distance() < 0.12, (near, self.distance()))

    def distance(self):
        sides = [list(p.vertices) for p in self.right.data.polygons]
        tree = BVHTree.FromPolygons(now(self.right).tolist(), sides)
        return min(tree.find_nearest(p.tolist())[3] for p in now(self.left))

    def test_undo_and_redo(self):
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.moulage.separate("EXEC_DEFAULT", True)
        shape = now(bpy.data.objects["left"])
        bpy.ops.ed.undo()
        self.assertIsNone(bpy.data.objects["left"].data.shape_keys)
        self.assertEqual(bpy.data.objects["left"].moulage.tets, "")
        bpy.ops.ed.redo()
        bpy.context.view_layer.update()
        numpy.testing.assert_array_equal(now(bpy.data.objects["left"]), shape)

    def test_what_does_not_overlap_is_not_touched(self):
        self.right.location.x = 4.0
        select(self.right, self.far)
        bpy.ops.moulage.separate()
        self.assertIn("do not overlap, nothing was moved", settings().report)
        self.assertTrue(settings().clear)
        for ob in (self.right, self.far):
            self.assertIsNone(ob.data.shape_keys)

    def test_what_cannot_be_parted_is_named_with_its_depth(self):
        inside = scenes.add_mesh("core", numpy.multiply(_CUBE, 0.4), _SIDES)
        self.bones.objects.unlink(self.box)
        self.bones.objects.link(inside)
        settings().rings, settings().tet_count = 1, 1200
        select(self.left)
        bpy.ops.moulage.separate()
        self.assertFalse(settings().clear, settings().report)
        self.assertRegex(settings().report, r"^1 pair still overlaps\.\nleft and core: [\d.]+ mm deep; before, [\d.]+ mm deep\.\nAllow")

    def test_the_shape_and_tets_of_a_reshaping_are_taken_also_from_a_file(self):
        template = scenes.ball_and_markers(iterations=4)
        bpy.ops.moulage.reshape()
        shown, kept = now(template), part("kept_tets")
        frame = numpy.array(template.matrix_world)
        points, tets = kept.find(template, frame, shown)
        self.assertEqual(tets.shape[1], 4)
        self.assertGreater(kept.volumes(points, tets).min(), 0)
        rest = part("solve").tets_of(part("problem").gather_shape(bpy.context, template))
        numpy.testing.assert_array_equal(tets, rest.tets)
        self.assertGreater(numpy.ptp(points, axis=0)[0], 1.15 * numpy.ptp(rest.points, axis=0)[0])
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "saved.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
        template, other = bpy.data.objects["ball"], scenes.ball("other")
        other.location = (2.2, 0.2, 0.3)
        settings().tet_count, settings().method, settings().bones = 1500, "lattice", None
        select(template, other)
        run = part("separating").Separating(bpy.context)
        body = next(b for b in run.bodies if b.name == "ball")
        numpy.testing.assert_array_equal(body.tets[1], tets)
        self.assertEqual(len(body.markers), 42)
        run_to_end(run)
        run.finish(bpy.context)
        self.assertTrue(settings().clear, settings().report)
        self.assertEqual(crossings(template, other), 0)
        # The key lies over the reshaped one: without it the reshaped shape is there, and the other way round.
        keys = template.data.shape_keys.key_blocks
        self.assertEqual((keys["Reshaped"].value, keys["Separated"].relative_key.name), (1.0, "Reshaped"))
        keys["Separated"].value = 0.0
        numpy.testing.assert_allclose(now(template), shown, atol=1e-6)
        keys["Separated"].value = 1.0
        # Apart, a second run has nothing to do, and the tets still fit.
        before = now(template)
        self.assertIsNotNone(kept.find(template, frame, before))
        bpy.ops.moulage.separate()
        self.assertIn("nothing was moved", settings().report)
        numpy.testing.assert_array_equal(now(template), before)
        # A new reshaping shows its own shape alone.
        bpy.ops.moulage.reshape()
        numpy.testing.assert_allclose(now(template), scenes.shape_of(template), atol=1e-6)
        bpy.ops.wm.read_homefile(use_empty=True)

    def test_tets_of_another_shape_are_not_taken(self):
        template = scenes.ball_and_markers(iterations=2)
        bpy.ops.moulage.reshape()
        template.data.shape_keys.key_blocks["Reshaped"].value = 0.5
        select(template, scenes.ball("other"))
        run = part("separating").Separating(bpy.context)
        self.assertIsNone(next(b for b in run.bodies if b.name == "ball").tets)
        run.abandon()

    def test_other_shape_keys_stay(self):
        self.left.shape_key_add(name="Basis")
        wide = self.left.shape_key_add(name="wide")
        for vertex in wide.data:
            vertex.co.y *= 1.2
        wide.value = 0.5
        before = now(self.left)
        select(self.left, self.right)
        bpy.ops.moulage.separate()
        self.assertEqual(crossings(self.left, self.right), 0)
        self.assertEqual(wide.value, 0.5)
        away = (before[:, 0] < -0.3) & (before[:, 2] > 0.3)
        numpy.testing.assert_allclose(now(self.left)[away], before[away], atol=1e-6)

    def started_with_view(self):
        settings().rings = 8
        run = part("separating").Separating(bpy.context)
        while self.left.data.shape_keys is None:
            self.assertTrue(run.tick(), "the run ended before it was seen")
            run.show()
        return run

    def test_stop_keeps_the_best_so_far(self):
        run = self.started_with_view()
        run.stop()
        run_to_end(run)
        said = run.finish(bpy.context)
        self.assertTrue("Stopped" in said or settings().clear, said)
        self.assertFalse(part("runs").is_running())

    def test_stopped_while_being_filled_nothing_is_left(self):
        settings().tet_count = 60_000
        run = part("separating").Separating(bpy.context)
        run.stop()
        run_to_end(run)
        with self.assertRaisesRegex(Exception, "Stopped before"):
            run.finish(bpy.context)
        self.assertIsNone(self.left.data.shape_keys)

    def test_abandoned_and_deleted(self):
        run = self.started_with_view()
        bpy.data.objects.remove(self.right)
        run_to_end(run)
        with self.assertRaisesRegex(Exception, "'right' was deleted"):
            run.finish(bpy.context)
        self.assertIsNone(self.left.data.shape_keys)
        self.assertFalse(part("runs").is_running())

    def test_what_cannot_work_is_said(self):
        select(self.left)
        settings().bones = None
        self.refused("Select two or more meshes")
        loose = scenes.add_mesh("loose", [(0, 0, 0)], [])
        select(self.left, loose)
        self.refused("'loose' has no faces: only surfaces can be separated")
        twin = bpy.data.objects.new("twin", self.left.data)
        bpy.context.scene.collection.objects.link(twin)
        select(self.left, twin)
        self.refused("'left' and 'twin' share one mesh")
        self.right.scale = (0, 0, 0)
        select(self.left, self.right)
        self.refused("'right' is scaled to nothing")
        self.right.scale = (1, 1, 1)
        self.left.shape_key_add(name="Basis")
        self.left.data.shape_keys.use_relative = False
        select(self.left, self.right)
        self.refused("The shape keys of 'left' are absolute")
        self.assertEqual(self.left.data.shape_keys.key_blocks.keys(), ["Basis"])
