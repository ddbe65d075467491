"""Before a run: mistakes of an import are found, named, mended by one button, and never run by accident."""

import tempfile
import unittest
from pathlib import Path

import bpy
import numpy
from mathutils import Matrix

import scenes
from scenes import LIVER, part, points_of


def world(ob):
    return part("mesh_data").world_points(ob)


class Doubts(unittest.TestCase):
    """The liver of the examples, imported wrong in the usual ways."""

    def start(self, change=None):
        """The template, moved by a matrix as a wrong import would, and the person."""
        scenes.empty_scene()
        bpy.ops.moulage.import_template(filepath=str(LIVER / "template.obj"))
        template = bpy.context.scene.moulage.template
        self.right = world(template)
        if change is not None:
            template.matrix_world = change
        bpy.ops.moulage.import_person(filepath=str(LIVER / "markers.csv"))
        template.moulage.method, template.moulage.tet_count, template.moulage.max_iterations = "lattice", 1500, 2
        return template

    def concerns(self, template):
        return [row.concern for row in template.moulage.doubts]

    def refused_then_mended(self, template, concern, words, button):
        self.assertEqual(self.concerns(template), [concern])
        row = template.moulage.doubts[0]
        self.assertIn(words, row.text)
        self.assertEqual(row.button, button)
        with self.assertRaises(RuntimeError) as caught:
            bpy.ops.moulage.reshape()
        self.assertIn(words, str(caught.exception))
        self.assertIsNone(template.data.shape_keys)
        bpy.ops.moulage.mend(index=0)
        self.assertEqual(template.moulage.findings, "")

    def test_a_right_import_raises_no_doubt(self):
        template = self.start()
        self.assertEqual(template.moulage.findings, "")
        self.assertAlmostEqual(bpy.context.scene.unit_settings.scale_length, 0.001, places=7)
        self.assertEqual(bpy.ops.moulage.reshape(), {"FINISHED"})

    def test_the_usual_axes_of_an_obj_file_are_turned_back(self):
        # What Blender's importer does to it by default.
        template = self.start(Matrix.Rotation(numpy.pi / 2, 4, "X"))
        self.refused_then_mended(template, "up_axis", "turned when it was imported", "Turn Back to Z up")
        numpy.testing.assert_allclose(world(template), self.right, atol=1e-3)

    def test_a_file_with_y_up_is_turned_upright(self):
        template = self.start(Matrix.Rotation(-numpy.pi / 2, 4, "X"))
        self.refused_then_mended(template, "up_axis", "its file has Y up", "Turn from Y up")
        numpy.testing.assert_allclose(world(template), self.right, atol=1e-3)

    def test_the_other_medical_frame_is_turned_round(self):
        template = self.start(Matrix.Rotation(numpy.pi, 4, "Z"))
        self.refused_then_mended(template, "frame", "in LPS, the other in RAS", "Turn LPS to RAS")
        numpy.testing.assert_allclose(world(template), self.right, atol=1e-3)

    def test_a_template_in_metres_is_scaled(self):
        template = self.start(Matrix.Scale(0.001, 4))
        self.refused_then_mended(template, "unit", "their files are in two units", "Bring to One Unit")
        numpy.testing.assert_allclose(world(template), self.right, atol=1e-3)

    def test_metres_and_wrong_axes_at_once(self):
        template = self.start(Matrix.Rotation(numpy.pi / 2, 4, "X") @ Matrix.Scale(0.001, 4))
        self.refused_then_mended(template, "unit", "their files are in two units", "Bring to One Unit")
        numpy.testing.assert_allclose(world(template), self.right, atol=1e-3)

    def test_a_person_in_metres_is_scaled_instead(self):
        template = self.start()
        marks = template.moulage.markers
        right = world(marks)
        marks.scale = (0.001,) * 3
        bpy.ops.moulage.check_template()
        self.refused_then_mended(template, "unit", "their files are in two units", "Bring to One Unit")
        numpy.testing.assert_allclose(world(marks), right, atol=1e-3)
        numpy.testing.assert_allclose(world(template), self.right, atol=1e-6)

    def test_a_template_far_away_is_placed(self):
        template = self.start(Matrix.Translation((700, 0, 300)))
        self.refused_then_mended(template, "place", "it lies somewhere else", "Place")

    def test_exchanged_landmarks_are_named_and_swapped(self):
        template = self.start()
        bpy.ops.moulage.import_person(filepath=str(LIVER / "landmarks.csv"))
        self.assertEqual(template.moulage.findings, "")
        before = part("landmarks").pairs(template)[1]
        first, second = (template.moulage.landmarks[n].target for n in (0, 2))
        first.location, second.location = second.location.copy(), first.location.copy()
        bpy.ops.moulage.check_template()
        names = [template.moulage.landmarks[n].name for n in (0, 2)]
        self.refused_then_mended(template, "exchange", f"'{names[0]}' and '{names[1]}' look exchanged", "Swap Them")
        bpy.context.view_layer.update()
        numpy.testing.assert_allclose(part("landmarks").pairs(template)[1], before, atol=1e-5)

    def test_what_is_meant_runs_all_the_same(self):
        template = self.start(Matrix.Rotation(numpy.pi, 4, "Z"))
        self.assertEqual(bpy.ops.moulage.reshape(anyway=True), {"FINISHED"})
        self.assertIn("LPS", template.moulage.result.warnings)

    def test_holes_are_closed_by_their_button(self):
        template = self.start()
        faces = [list(p.vertices) for p in template.data.polygons]
        broken = scenes.add_mesh("broken", points_of(template.data), faces[1:])
        bpy.context.view_layer.objects.active = broken
        bpy.ops.moulage.set_template()
        self.assertEqual(self.concerns(broken), ["surface"])
        self.assertEqual(broken.moulage.doubts[0].severity, "note")
        bpy.ops.moulage.mend(index=0)
        self.assertEqual(broken.moulage.findings, "")

    def test_a_scene_in_metres_gets_millimetres_and_the_scan_follows(self):
        template = self.start()
        bpy.context.scene.unit_settings.scale_length = 1.0
        with tempfile.TemporaryDirectory() as folder:
            bpy.ops.moulage.load_scan(filepath=str(scenes.write_egg_scan(Path(folder) / "egg.nrrd")))
            oblique = part("scan").slices(bpy.context.scene)["OBLIQUE"]
            oblique.location.x += 0.001
            bpy.context.scene.moulage.axial = 1.5
            bpy.ops.moulage.check_template()
            self.assertEqual(self.concerns(template), ["scene"])
            bpy.ops.moulage.mend(index=0)
            self.assertEqual(self.concerns(template), [])
            axial = part("scan").slices(bpy.context.scene)["AXIAL"]
            self.assertAlmostEqual(axial.matrix_world.translation.z, 1.5, places=4)
            self.assertAlmostEqual(oblique.location.x, 1.0, places=4)


class Imports(unittest.TestCase):
    """One step each."""

    def setUp(self):
        scenes.empty_scene()
        bpy.context.scene.moulage.template = None

    def test_several_files_of_a_person_at_once(self):
        bpy.ops.moulage.import_template(filepath=str(LIVER / "template.obj"))
        files = [{"name": name} for name in ("landmarks.csv", "markers.csv")]
        bpy.ops.moulage.import_person(directory=str(LIVER), files=files)
        data = bpy.context.scene.moulage.template.moulage
        self.assertEqual((len(data.landmarks), len(data.markers.data.vertices)), (4, 308))
        self.assertEqual(data.findings, "")

    def test_a_person_s_surface_is_taken_for_markers_and_units_are_told_by_size(self):
        with tempfile.TemporaryDirectory() as folder:
            paths = {}
            for ending in ("obj", "stl", "ply"):
                paths[ending] = Path(folder) / f"small.{ending}"
            package = part("library").moulage()
            liver = package.TriMesh.load(LIVER / "template.obj")
            small = package.TriMesh(liver.points / 1000, liver.triangles)
            for ending, path in paths.items():
                small.save(path)
                scenes.empty_scene()
                bpy.ops.moulage.import_template(filepath=str(path))
                template = bpy.context.scene.moulage.template
                numpy.testing.assert_allclose(
                    numpy.ptp(world(template), axis=0), numpy.ptp(liver.points, axis=0), rtol=1e-3, err_msg=ending
                )
                numpy.testing.assert_allclose(world(template).min(axis=0), liver.points.min(axis=0), atol=0.1)
            bpy.ops.moulage.import_person(filepath=str(paths["ply"]))
            self.assertEqual([row.concern for row in template.moulage.doubts], ["unit"])
            bpy.ops.moulage.mend(index=0)
            self.assertEqual(template.moulage.findings, "")
            self.assertEqual(len(template.moulage.markers.data.polygons), len(liver.triangles))

    def test_what_is_no_mesh_is_refused_in_a_sentence(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "empty.obj"
            path.write_text("# nothing\n")
            with self.assertRaisesRegex(RuntimeError, "empty.obj holds no mesh"):
                bpy.ops.moulage.import_template(filepath=str(path))
        with self.assertRaisesRegex(RuntimeError, "is no .obj, .ply or .stl file"):
            bpy.ops.moulage.import_template(filepath=str(LIVER / "job.toml"))
        self.assertFalse(bpy.ops.moulage.import_person.poll())
