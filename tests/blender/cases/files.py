"""Markers and landmarks in files, and landmarks in the scene."""

import tempfile
import types
import unittest
from pathlib import Path

import bpy
import numpy
from mathutils import Vector

import scenes
from scenes import part, points_of, shape_of


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


class DragAndDrop(unittest.TestCase):
    @unittest.skipIf(bpy.app.version < (4, 1, 0), "files can be dropped from Blender 4.1 on")
    def test_each_kind_of_file_is_taken_by_a_3d_view_and_by_no_other_editor(self):
        handlers = {cls.bl_idname: cls for cls in bpy.types.FileHandler.__subclasses__()}
        for kind, endings in (
            ("scan", (".nii", ".gz", ".nrrd", ".dcm", ".mha")), ("skeleton", (".json", ".osim")),
            ("markers", (".json", ".fcsv", ".pp", ".csv")),
        ):
            with self.subTest(kind=kind):
                handler = handlers[f"MOULAGE_FH_{kind}"]
                self.assertLessEqual(set(endings), set(handler.bl_file_extensions.split(";")))
                for area, taken in (("VIEW_3D", True), ("IMAGE_EDITOR", False), (None, False)):
                    place = types.SimpleNamespace(area=area and types.SimpleNamespace(type=area))
                    self.assertEqual(handler.poll_drop(place), taken)
                category, name = handler.bl_import_operator.split(".")
                told = getattr(getattr(bpy.ops, category), name).get_rna_type().properties
                # What Blender sets when files are dropped.
                self.assertLessEqual({"filepath", "directory", "files"}, set(told.keys()))

    def test_several_marker_files_become_one_object(self):
        template = scenes.ball_and_markers()
        bpy.ops.moulage.import_markers(
            "INVOKE_DEFAULT", directory=str(scenes.LIVER), files=[{"name": "markers.csv"}, {"name": "markers.csv"}]
        )
        self.assertEqual(len(template.moulage.markers.data.vertices), 2 * 308)

    def test_one_bad_file_among_several_changes_nothing(self):
        template = scenes.ball_and_markers()
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "good.csv").write_text("1,2,3\n4,5,6\n")
            (Path(folder) / "bad.fcsv").write_text("none")
            names = [{"name": "good.csv"}, {"name": "bad.fcsv"}]
            with self.assertRaisesRegex(RuntimeError, "bad.fcsv"):
                bpy.ops.moulage.import_markers("INVOKE_DEFAULT", directory=folder, files=names)
        self.assertEqual(template.moulage.markers.name, "marks")
        self.assertNotIn("good", bpy.data.objects)

    def test_several_slices_of_a_series_are_one_scan(self):
        scenes.ball_and_markers()
        bpy.context.scene.unit_settings.scale_length = 0.001
        with tempfile.TemporaryDirectory() as folder:
            scenes.write_egg_dicom(Path(folder))
            names = [{"name": path.name} for path in sorted(Path(folder).iterdir())[:5]]
            bpy.ops.moulage.load_scan("INVOKE_DEFAULT", directory=folder, files=names)
            self.assertEqual(list(part("scan").volume(bpy.context.scene)[1]["size"]), [41, 41, 41])
            bpy.context.scene.moulage.scan = ""

    def test_several_skeletons_become_an_armature_each(self):
        scenes.empty_scene()
        hand = str(scenes.ROOT / "examples" / "hand")
        bpy.ops.moulage.import_skeleton("INVOKE_DEFAULT", directory=hand, files=[{"name": "skeleton.json"}] * 2)
        armatures = [ob for ob in bpy.data.objects if ob.type == "ARMATURE"]
        self.assertEqual(len(armatures), 2)
        self.assertEqual(*(len(ob.children) for ob in armatures))
        self.assertIn(bpy.context.scene.moulage.skeleton, armatures)
        scenes.empty_scene()


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

    def test_names_with_a_side_are_mirrored_onto_the_template(self):
        template = scenes.ball_and_markers()
        template.location = (5, 0, 0)
        bpy.context.view_layer.update()
        for name, place in (("hip.L", (0.6, 0.8, 0)), ("top", (0, 0, 1)), ("left_knee", (0.8, 0, -0.6))):
            target = Vector(place) + Vector((7, 0, 0))
            bpy.ops.moulage.add_landmark(name=name, template_point=Vector(place) + Vector((5, 0, 0)), target=target)
        bpy.ops.moulage.mirror_landmarks()
        found = {l.name: l for l in template.moulage.landmarks}
        self.assertEqual(list(found), ["hip.L", "top", "left_knee", "hip.R", "right_knee"])
        bpy.context.view_layer.update()
        place = found["hip.R"].template.matrix_world.translation
        self.assertLess((place - Vector((4.4, 0.8, 0))).length, 0.03)
        self.assertAlmostEqual((place - Vector((5, 0, 0))).length, 1.0, delta=0.02)
        # They wait for their places on the person, one after the other.
        self.assertEqual(part("landmarks").incomplete(template).name, "hip.R")
        with self.assertRaisesRegex(RuntimeError, "waits for its partner"):
            bpy.ops.moulage.mirror_landmarks()
