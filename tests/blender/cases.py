"""What the add-on promises, in any Blender without a window: bpy, or blender -b."""

import math
import os
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import bpy
import numpy
from mathutils import Matrix, Vector

import scenes
from scenes import part, points_of, shape_of


def run_to_end(solve, limit=300):
    end = time.monotonic() + limit
    while solve.tick():
        solve.show()
        time.sleep(0.01)
        if time.monotonic() > end:
            raise TimeoutError("the run does not end")


class Template(unittest.TestCase):
    def setUp(self):
        scenes.empty_scene()

    def test_a_clean_ball_has_no_findings(self):
        ball = scenes.ball()
        bpy.context.scene.moulage.template = ball
        bpy.ops.moulage.check_template()
        self.assertTrue(ball.moulage.checked)
        self.assertEqual(ball.moulage.findings, "")

    def test_a_hole_a_flipped_face_and_a_double_are_found_and_fixed(self):
        ball = scenes.ball(subdivisions=2)
        points = points_of(ball.data).tolist()
        faces = [list(p.vertices) for p in ball.data.polygons]
        faces.pop()
        faces[0].reverse()
        points += [points[faces[1][0]], [3.0, 0.0, 0.0]]
        faces[1][0] = len(points) - 2
        broken = scenes.add_mesh("broken", points, faces)
        bpy.context.scene.moulage.template = broken
        bpy.ops.moulage.check_template()
        self.assertIn("border a hole", broken.moulage.findings)
        bpy.ops.moulage.fix_template()
        self.assertEqual(broken.moulage.findings, "")
        self.assertEqual(len(broken.data.vertices), len(ball.data.vertices))

    def test_fixing_keeps_the_vertices_of_a_mesh_with_shape_keys(self):
        ball = scenes.ball()
        ball.shape_key_add(name="Basis")
        before = len(ball.data.vertices)
        bpy.context.scene.moulage.template = ball
        bpy.ops.moulage.fix_template()
        self.assertEqual(len(ball.data.vertices), before)

    def test_tets_are_measured(self):
        ball = scenes.ball()
        bpy.context.scene.moulage.template = ball
        ball.moulage.method, ball.moulage.tet_count = "lattice", 500
        bpy.ops.moulage.tetrahedralize()
        self.assertIn("tets by the lattice", ball.moulage.tets_text)

    def test_a_template_in_metres_but_meant_as_millimetres_is_noticed(self):
        ball = scenes.ball()
        ball.scale = (200.0,) * 3
        bpy.context.scene.moulage.template = ball
        bpy.ops.moulage.check_template()
        self.assertIn("millimetres", ball.moulage.findings)
        bpy.ops.moulage.use_millimetres()
        self.assertEqual(ball.moulage.findings, "")

    def test_a_mirrored_template_counts_as_right_side_out(self):
        ball = scenes.ball()
        ball.scale = (-1.0, 1.0, 1.0)
        bpy.context.scene.moulage.template = ball
        bpy.ops.moulage.check_template()
        self.assertEqual(ball.moulage.findings, "")


class Reshape(unittest.TestCase):
    def test_the_ball_becomes_the_egg(self):
        template = scenes.ball_and_markers()
        rest = points_of(template.data).copy()
        self.assertEqual(bpy.ops.moulage.reshape(), {"FINISHED"})
        shape = shape_of(template)
        numpy.testing.assert_allclose(numpy.ptp(shape, axis=0), numpy.ptp(scenes.egg(rest), axis=0), atol=0.05)
        result = template.moulage.result
        self.assertLess(result.mean_distance, 0.03)
        self.assertEqual(result.inverted_tets, 0)
        numpy.testing.assert_array_equal(points_of(template.data), rest)

    def test_texture_groups_modifiers_and_order_are_kept(self):
        template = scenes.ball_and_markers()
        template.modifiers.new("Multires", "MULTIRES")
        template.modifiers.new("Subdivision", "SUBSURF").levels = 1
        layer = template.data.uv_layers[0]
        flat = numpy.empty(2 * len(layer.data), numpy.float32)
        layer.data.foreach_get("uv", flat)
        group = [len(v.groups) for v in template.data.vertices]
        bpy.ops.moulage.reshape()
        after = numpy.empty_like(flat)
        template.data.uv_layers[0].data.foreach_get("uv", after)
        numpy.testing.assert_array_equal(flat, after)
        self.assertEqual(group, [len(v.groups) for v in template.data.vertices])
        self.assertEqual([m.name for m in template.modifiers], ["Multires", "Subdivision"])
        # What is seen is the result, subdivided.
        bpy.context.view_layer.update()
        shown = template.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        self.assertGreater(len(shown.vertices), len(template.data.vertices))
        self.assertGreater(numpy.ptp(points_of(shown), axis=0)[0], 2.4)

    def test_the_result_is_where_the_person_is_whatever_the_object_s_frame(self):
        template = scenes.ball_and_markers()
        bpy.ops.moulage.reshape()
        straight = shape_of(template).copy()
        template = scenes.ball_and_markers()
        frame = scenes.part("mesh_data")
        template.location, template.rotation_euler, template.scale = (0.3, -2, 5), (0.1, 0.7, 2), (0.01, 0.01, 0.01)
        bpy.context.view_layer.update()
        inverse = numpy.linalg.inv(frame.matrix(template))
        moved = frame.transform(inverse, points_of(template.data).astype(float))
        template.data.vertices.foreach_set("co", moved.astype(numpy.float32).ravel())
        bpy.ops.moulage.reshape()
        world = frame.transform(frame.matrix(template), shape_of(template).astype(float))
        # Coordinates that are rounded otherwise may lie in another cell of the lattice.
        numpy.testing.assert_allclose(world, straight, atol=0.02)

    def test_a_second_run_replaces_the_key_or_makes_another_by_choice(self):
        template = scenes.ball_and_markers(iterations=1)
        bpy.ops.moulage.reshape()
        bpy.ops.moulage.reshape()
        names = [k.name for k in template.data.shape_keys.key_blocks]
        self.assertEqual(names, ["Basis", "Reshaped"])
        template.moulage.new_key = True
        bpy.ops.moulage.reshape()
        keys = template.data.shape_keys.key_blocks
        self.assertEqual([k.name for k in keys], ["Basis", "Reshaped", "Reshaped.001"])
        self.assertEqual([k.value for k in keys][1:], [0.0, 1.0])

    def test_markers_may_be_empties(self):
        template = scenes.ball_and_markers()
        marks = points_of(template.moulage.markers.data)[:120:4]
        template.moulage.markers = None
        collection = part("markers").add_empties(bpy.context, "clicks", marks, 0.01)
        template.moulage.marker_empties = collection
        bpy.context.view_layer.update()
        self.assertEqual(bpy.ops.moulage.reshape(), {"FINISHED"})
        self.assertGreater(numpy.ptp(shape_of(template), axis=0)[0], 2.4)

    def test_markers_may_be_a_point_cloud(self):
        if "POINTCLOUD" not in bpy.ops.object.convert.get_rna_type().properties["target"].enum_items:
            self.skipTest("this Blender makes no point clouds")
        template = scenes.ball_and_markers()
        marks = points_of(template.moulage.markers.data).copy()
        bpy.context.view_layer.objects.active = template.moulage.markers
        template.moulage.markers.select_set(True)
        bpy.ops.object.convert(target="POINTCLOUD")
        cloud = bpy.context.view_layer.objects.active
        self.assertEqual(cloud.type, "POINTCLOUD")
        template.moulage.markers = cloud
        numpy.testing.assert_allclose(part("markers").points(template), marks, atol=1e-6)
        self.assertEqual(bpy.ops.moulage.reshape(), {"FINISHED"})

    def test_landmarks_pull_and_tell_their_residual(self):
        template = scenes.ball_and_markers()
        template.moulage.markers = None
        for name, axis in (("x", (1, 0, 0)), ("-x", (-1, 0, 0)), ("y", (0, 1, 0)), ("z", (0, 0, 1)), ("-z", (0, 0, -1))):
            target = scenes.egg([axis])[0]
            bpy.ops.moulage.add_landmark(name=name, template_point=axis, target=target)
        template.moulage.landmark_tolerance = 0.01
        template.moulage.max_iterations = 20
        bpy.ops.moulage.reshape()
        for landmark in template.moulage.landmarks:
            self.assertTrue(0 <= landmark.residual < 0.1, landmark.residual)
        self.assertGreater(shape_of(template)[:, 0].max(), 1.25)

    def test_fixed_vertices_stay(self):
        template = scenes.ball_and_markers()
        template.moulage.fixed_group = "top"
        bpy.ops.moulage.reshape()
        rest, shape = points_of(template.data), shape_of(template)
        top = rest[:, 2] > 0.8
        self.assertLess(numpy.abs(shape[top] - rest[top]).max(), 0.02)
        self.assertGreater(numpy.abs(shape[~top] - rest[~top]).max(), 0.2)

    def test_a_bone_that_moves_takes_its_attachments_along(self):
        for by in ("DISTANCE", "GROUP"):
            with self.subTest(by=by):
                template = scenes.ball_and_markers(iterations=15)
                template.moulage.markers = None
                bone = scenes.add_mesh("bone", [(x, y, 1.05) for x in (-0.3, 0, 0.3) for y in (-0.3, 0, 0.3)], [(0, 1, 4, 3)])
                moved = scenes.add_mesh("moved", points_of(bone.data) + (0, 0, 0.4), [(0, 1, 4, 3)])
                template.moulage.fixed_group = "bottom"
                bottom = template.vertex_groups.new(name="bottom")
                bottom.add([v.index for v in template.data.vertices if v.co.z < -0.7], 1.0, "REPLACE")
                bpy.ops.moulage.add_attachment()
                item = template.moulage.attachments[0]
                item.bone, item.target, item.by, item.distance, item.group = bone, moved, by, 0.2, "top"
                self.assertEqual(bpy.ops.moulage.reshape(), {"FINISHED"})
                self.assertAlmostEqual(float(shape_of(template)[:, 2].max()), 1.4, delta=0.06)

    def test_other_meshes_are_carried_along(self):
        template = scenes.ball_and_markers()
        inside = scenes.ball("vessel", 2)
        inside.data.transform(Matrix.Scale(0.5, 4))
        template.moulage.carried.add().object = inside
        bpy.ops.moulage.reshape()
        key = inside.data.shape_keys.key_blocks["Reshaped"]
        flat = numpy.empty(3 * len(key.data), numpy.float32)
        key.data.foreach_get("co", flat)
        extent = numpy.ptp(flat.reshape(-1, 3), axis=0)
        self.assertTrue(1.15 < extent[0] < 1.45 and 0.7 < extent[2] < 0.95, extent)

    def test_heat_maps_colour_the_template(self):
        template = scenes.ball_and_markers()
        bpy.ops.moulage.reshape()
        seen = []
        for kind in ("DISTANCE", "STRETCH"):
            bpy.ops.moulage.show_heat_map(kind=kind)
            colour = template.data.attributes["moulage_heat"]
            flat = numpy.empty(4 * len(colour.data), numpy.float32)
            colour.data.foreach_get("color", flat)
            seen.append(flat)
            self.assertGreater(numpy.ptp(flat.reshape(-1, 4)[:, :3]), 0.2)
            low, high = template.moulage.result.heat_range
            self.assertLess(low, high)
        self.assertFalse(numpy.array_equal(*seen))
        stretch = part("mesh_data").attribute(template.data, "moulage_stretch")
        self.assertTrue(1.1 < stretch.max() < 1.6, stretch.max())

    def test_the_result_can_become_an_object_of_its_own(self):
        template = scenes.ball_and_markers(iterations=2)
        bpy.ops.moulage.reshape()
        bpy.ops.moulage.copy_result()
        copy = bpy.data.objects["ball reshaped"]
        self.assertIsNone(copy.data.shape_keys)
        numpy.testing.assert_array_equal(points_of(copy.data), shape_of(template))
        self.assertEqual(len(copy.data.uv_layers), 1)

    def test_placing_brings_a_turned_template_to_the_person(self):
        template = scenes.ball_and_markers()
        template.location = (5, 5, 5)
        bpy.context.view_layer.update()
        bpy.ops.moulage.place_template()
        self.assertLess(template.location.length, 0.4)


class Refusals(unittest.TestCase):
    """What cannot work is said in a sentence."""

    def refused(self, words):
        with self.assertRaises(RuntimeError) as caught:
            bpy.ops.moulage.reshape()
        self.assertIn(words, str(caught.exception))

    def test_nothing_to_follow(self):
        template = scenes.ball_and_markers()
        template.moulage.markers = scenes.add_mesh("nothing", [], [])
        self.refused("do not determine a shape")

    def test_two_units(self):
        template = scenes.ball_and_markers()
        template.moulage.markers.scale = (1000.0,) * 3
        self.refused("times larger")

    def test_a_group_that_is_not_there(self):
        scenes.ball_and_markers().moulage.fixed_group = "no such group"
        self.refused("no vertex group 'no such group'")

    def test_a_template_without_faces(self):
        template = scenes.ball_and_markers()
        bpy.context.scene.moulage.template = template.moulage.markers
        template.moulage.markers.moulage.markers = template
        self.refused("has no faces")

    def test_tetgen_that_is_not_there(self):
        template = scenes.ball_and_markers()
        template.moulage.method = "tetgen"
        preferences = part("preferences").get(bpy.context)
        preferences.tetgen = "/no/such/tetgen"
        try:
            self.refused("/no/such/tetgen")
        finally:
            preferences.tetgen = ""

    def test_a_bone_of_other_vertices(self):
        template = scenes.ball_and_markers()
        bpy.ops.moulage.add_attachment()
        item = template.moulage.attachments[0]
        item.bone, item.target = scenes.ball("a", 1), scenes.ball("b", 2)
        self.refused("needs the same vertices")

    def test_edit_mode(self):
        template = scenes.ball_and_markers()
        bpy.context.view_layer.objects.active = template
        bpy.ops.object.mode_set(mode="EDIT")
        try:
            self.assertFalse(bpy.ops.moulage.reshape.poll())
        finally:
            bpy.ops.object.mode_set(mode="OBJECT")


class Library(unittest.TestCase):
    """A native library that is missing or of another version is said in a sentence; nothing breaks."""

    def with_library(self, path):
        native = part("library").moulage().native
        kept, native._loaded = native._loaded, None
        os.environ["MOULAGE_LIBRARY"] = str(path)
        try:
            scenes.ball_and_markers()
            with self.assertRaises(RuntimeError) as caught:
                bpy.ops.moulage.reshape()
            problem = part("library").problem()
            self.assertIn(problem, str(caught.exception))
            return problem
        finally:
            del os.environ["MOULAGE_LIBRARY"]
            native._loaded = kept

    def test_missing(self):
        self.assertIn("there is no /no/such/libmoulage.so", self.with_library("/no/such/libmoulage.so"))

    def test_another_file(self):
        self.assertIn("cannot be loaded", self.with_library(__file__))

    def test_another_version(self):
        with tempfile.TemporaryDirectory() as folder:
            source, library = Path(folder) / "other.c", Path(folder) / "libother.so"
            source.write_text("unsigned mlg_abi_version(void) { return 999; }")
            subprocess.run(["cc", "-shared", "-fPIC", "-o", library, source], check=True)
            self.assertIn("is of another version (interface 999", self.with_library(library))


class Interruptions(unittest.TestCase):
    """A run in the middle of other things."""

    def started(self, **settings):
        template = scenes.ball_and_markers(**{"subdivisions": 4, "tet_count": 6000, "iterations": 60, **settings})
        template.moulage.tolerance = 1e-6
        return template, part("solve").Solve(bpy.context, template)

    def until_preview(self, solve):
        end = time.monotonic() + 120
        while solve.progress is None or solve.progress.iteration < 1:
            self.assertTrue(solve.tick(), "the run ended early")
            solve.show()
            time.sleep(0.01)
            self.assertLess(time.monotonic(), end)

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
        self.assertFalse(part("solve").is_running())

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
        self.assertFalse(part("solve").is_running())

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
        self.assertFalse(part("solve").is_running())


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


class Files(unittest.TestCase):
    def test_markers_go_out_and_come_back_in_every_format(self):
        for ending in (".mrk.json", ".fcsv", ".pp", ".csv"):
            with self.subTest(ending=ending), tempfile.TemporaryDirectory() as folder:
                template = scenes.ball_and_markers()
                marks = points_of(template.moulage.markers.data).copy()
                path = str(Path(folder) / f"marks{ending}")
                bpy.ops.moulage.export_markers(filepath=path, format=ending)
                bpy.ops.moulage.import_markers(filepath=path)
                self.assertNotEqual(template.moulage.markers.name, "marks")
                numpy.testing.assert_allclose(part("markers").points(template), marks, atol=1e-4)

    def test_several_files_that_are_dropped_become_one_object(self):
        template = scenes.ball_and_markers()
        bpy.ops.moulage.import_markers(directory=str(scenes.LIVER), files=[{"name": "markers.csv"}, {"name": "markers.csv"}])
        self.assertEqual(len(template.moulage.markers.data.vertices), 2 * 308)

    def test_landmarks_go_out_and_are_paired_by_their_names(self):
        template = scenes.ball_and_markers()
        for name, place in (("a", (1, 0, 0)), ("b", (0, 1, 0)), ("c", (0, 0, 1))):
            bpy.ops.moulage.add_landmark(name=name, template_point=place, target=scenes.egg([place])[0])
        bpy.context.view_layer.update()
        before = part("landmarks").pairs(template)
        with tempfile.TemporaryDirectory() as folder:
            own, person = str(Path(folder) / "own.mrk.json"), str(Path(folder) / "person.mrk.json")
            bpy.ops.moulage.export_landmarks(filepath=own, format=".mrk.json", side="TEMPLATE", scale=0.001)
            bpy.ops.moulage.export_landmarks(filepath=person, format=".mrk.json", side="TARGET", scale=0.001)
            bpy.ops.moulage.remove_landmark(all=True)
            self.assertEqual(len(template.moulage.landmarks), 0)
            bpy.ops.moulage.import_landmarks(filepath=own, person=person, scale=0.001)
        bpy.context.view_layer.update()
        after = part("landmarks").pairs(template)
        self.assertEqual([l.name for l in template.moulage.landmarks], ["a", "b", "c"])
        for one, other in zip(before, after):
            numpy.testing.assert_allclose(one, other, atol=1e-4)

    def test_a_file_that_is_none_is_refused_in_a_sentence(self):
        scenes.ball_and_markers()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "bad.mrk.json"
            path.write_text("{")
            with self.assertRaisesRegex(RuntimeError, "bad.mrk.json"):
                bpy.ops.moulage.import_markers(filepath=str(path))


class Landmarks(unittest.TestCase):
    def test_clicks_on_a_reshaped_template_mean_the_place_at_rest(self):
        template = scenes.ball_and_markers()
        bpy.ops.moulage.reshape()
        bpy.context.view_layer.update()
        pick = part("operators.pick")
        shape, rest = shape_of(template), points_of(template.data)
        tip = int(shape[:, 0].argmax())
        start = Vector(shape[tip].tolist()) + Vector((5, 0, 0))
        place = pick.point_on_template(bpy.context, template, start, Vector((-1, 0, 0)))
        self.assertLess((place - Vector(rest[tip].tolist())).length, 0.01)
        self.assertIsNone(pick.point_on_template(bpy.context, template, Vector((5, 9, 0)), Vector((-1, 0, 0))))

    def test_a_removed_empty_makes_its_landmark_incomplete(self):
        template = scenes.ball_and_markers()
        bpy.ops.moulage.add_landmark(name="a", template_point=(1, 0, 0), target=(2, 0, 0))
        bpy.data.objects.remove(template.moulage.landmarks[0].target)
        self.assertEqual(part("landmarks").used(template), [])
        self.assertEqual(part("landmarks").incomplete(template).name, "a")
        self.assertEqual(bpy.ops.moulage.reshape(), {"FINISHED"})

    def test_template_points_move_with_the_template(self):
        template = scenes.ball_and_markers()
        bpy.ops.moulage.add_landmark(name="a", template_point=(1, 0, 0), target=(2, 0, 0))
        template.location = (0, 0, 3)
        bpy.context.view_layer.update()
        points, targets, _ = part("landmarks").pairs(template)
        numpy.testing.assert_allclose(points, [(1, 0, 3)], atol=1e-6)
        numpy.testing.assert_allclose(targets, [(2, 0, 0)], atol=1e-6)


class Scan(unittest.TestCase):
    """A small image of a bright egg."""

    def setUp(self):
        self.template = scenes.ball_and_markers()
        bpy.context.scene.unit_settings.scale_length = 0.001
        self.folder = tempfile.TemporaryDirectory()
        self.path = scenes.write_egg_scan(Path(self.folder.name) / "egg.nrrd")
        self.settings = bpy.context.scene.moulage
        bpy.ops.moulage.load_scan(filepath=str(self.path))

    def tearDown(self):
        self.folder.cleanup()
        self.settings = None

    def brightness(self, view, place):
        """What a slice shows at a world position on its plane."""
        empty = part("scan").slices(bpy.context.scene)[view]
        local = empty.matrix_world.inverted() @ Vector(place)
        self.assertLess(abs(local.z), 0.05)
        width, height = empty.data.size
        pixel = empty.empty_display_size / max(width, height)
        column, row = int(local.x / pixel + width / 2), int(local.y / pixel + height / 2)
        flat = numpy.empty(4 * width * height, numpy.float32)
        empty.data.pixels.foreach_get(flat)
        return flat.reshape(height, width, 4)[row, column, 0]

    def test_slices_show_the_image_where_it_is(self):
        # The egg spans -1.2 to 1.4 along x at the middle, and -0.8 to 0.8 along z beside its bend.
        for view, inside, outside in (
            ("AXIAL", (0.3, 0, 0), (1.8, 1.5, 0)), ("CORONAL", (0, 0, 0.5), (0, 0, -1.3)), ("SAGITTAL", (0, 0.6, 0), (0, -1.4, 0)),
        ):
            with self.subTest(view=view):
                setattr(self.settings, view.lower(), 0.0)
                self.assertGreater(self.brightness(view, inside), 0.8)
                self.assertLess(self.brightness(view, outside), 0.2)

    def test_moving_a_slice_moves_its_slider_and_keeps_it_in_its_plane(self):
        empty = part("scan").slices(bpy.context.scene)["AXIAL"]
        self.settings.axial = 0.0
        empty.location += Vector((0.7, 0.2, 1.2))
        bpy.context.view_layer.update()
        self.assertAlmostEqual(self.settings.axial, 1.2, places=3)
        self.assertLess(self.brightness("AXIAL", (0, 0, 1.2)), 0.2)

    def test_an_oblique_slice_is_drawn_where_its_empty_is(self):
        empty = part("scan").slices(bpy.context.scene)["OBLIQUE"]
        empty.hide_viewport = False
        empty.location, empty.rotation_euler = (0, 0, 0), (0.6, 0.3, 0.2)
        bpy.context.view_layer.update()
        bpy.context.view_layer.update()
        out = empty.matrix_world @ Vector((1.6, 0, 0))
        self.assertGreater(self.brightness("OBLIQUE", (0, 0, 0)), 0.8)
        self.assertLess(self.brightness("OBLIQUE", out), 0.2)

    def test_window_presets_change_the_picture(self):
        self.settings.axial = 0.0
        bpy.ops.moulage.scan_window(preset="BONE")
        self.assertEqual((self.settings.window_width, self.settings.window_level), (2000, 400))
        # 1000 is 1600 above the window's black end, of 2000.
        self.assertAlmostEqual(self.brightness("AXIAL", (0.3, 0, 0)), 0.8, delta=0.02)

    def test_a_click_on_a_slice_becomes_a_marker(self):
        self.settings.axial, self.settings.coronal, self.settings.sagittal = 0.5, 1.9, 1.9
        bpy.context.view_layer.update()
        place = part("scan").hit(bpy.context, Vector((0.2, 0.3, 9)), Vector((0, 0, -1)))
        self.assertLess((place - Vector((0.2, 0.3, 0.5))).length, 1e-4)
        self.template.moulage.markers = None
        for z in (0.0, 0.5):
            part("markers").add_point(bpy.context, self.template, Vector((0.2, 0.3, z)))
        numpy.testing.assert_allclose(part("markers").points(self.template), [(0.2, 0.3, 0), (0.2, 0.3, 0.5)], atol=1e-6)

    def test_a_scene_in_metres_shows_the_scan_a_thousand_times_smaller(self):
        bpy.context.scene.unit_settings.scale_length = 1.0
        self.settings.axial = 1.0
        empty = part("scan").slices(bpy.context.scene)["AXIAL"]
        self.assertAlmostEqual(empty.matrix_world.translation.z, 0.001, places=6)

    def test_slices_are_drawn_again_after_the_file_is_opened(self):
        self.settings.axial = 0.0
        path = str(Path(self.folder.name) / "saved.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
        self.assertGreater(self.brightness("AXIAL", (0.3, 0, 0)), 0.8)
        bpy.ops.wm.read_homefile(use_empty=True)

    def test_a_scan_that_is_gone_or_none_is_said_in_a_sentence(self):
        other = Path(self.folder.name) / "bad.nrrd"
        other.write_text("no image")
        with self.assertRaisesRegex(RuntimeError, "bad.nrrd"):
            bpy.ops.moulage.load_scan(filepath=str(other))
        self.assertEqual(self.settings.scan, str(self.path))
        self.path.unlink()
        part("scan").forget()
        self.settings.axial = 0.3
        self.assertIn("not there any more", part("scan").missing(bpy.context.scene))


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
        program = scenes.ROOT / "target" / "release" / "moulage"
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
