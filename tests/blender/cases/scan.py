"""The scan: slices, windows, clicks."""

import tempfile
import unittest
from pathlib import Path

import bpy
import numpy
from mathutils import Vector

import scenes
from scenes import part, shape_of


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

    def test_looking_at_a_slice_shows_it_and_what_is_near_it(self):
        settings, slice_view = self.settings, part("slice_view")
        settings.axial = 0.5
        for name, z in (("near", 0.5), ("far", 0.0)):
            bpy.ops.moulage.add_landmark(name=name, template_point=(0, 0, 1), target=(0.2, 0.3, z))
        near, far = (landmark.target for landmark in self.template.moulage.landmarks)
        self.template.select_set(True)
        there = [ob for ob in bpy.context.scene.objects if ob.visible_get()]
        slice_view.enter(bpy.context, "AXIAL")
        axial = part("scan").slices(bpy.context.scene)["AXIAL"]
        self.assertEqual({ob for ob in bpy.context.scene.objects if ob.visible_get()}, {axial, near})
        self.assertIsNotNone(part("scan").hit(bpy.context, Vector((0.2, 0.3, 9)), Vector((0, 0, -1))))
        slab = slice_view.slab(bpy.context.scene)
        # A voxel is 0.1 high.
        self.assertEqual(list(slab.holds(numpy.array([(1, 1, 0.45), (0, 0, 0.58), (0, 0, 0.65)]))), [True, True, False])
        slice_view.enter(bpy.context, "SAGITTAL")
        self.assertFalse(axial.visible_get())
        slice_view.leave(bpy.context)
        self.assertEqual([ob for ob in bpy.context.scene.objects if ob.visible_get()], there)
        self.assertTrue(self.template.select_get())
        self.assertIsNone(slice_view.slab(bpy.context.scene))
        self.assertFalse(far.hide_get())

    def test_a_folder_of_dicom_slices_and_one_of_its_files_are_the_same_scan(self):
        folder = Path(self.folder.name) / "series"
        folder.mkdir()
        scenes.write_egg_dicom(folder)
        for path in (folder, folder / "000"):
            with self.subTest(path=path):
                bpy.ops.moulage.load_scan(filepath=str(path))
                self.settings.axial = 0.0
                self.assertGreater(self.brightness("AXIAL", (1.3, 0, 0)), 0.8)
                self.assertLess(self.brightness("AXIAL", (-1.5, 0, 0)), 0.2)
                self.assertGreater(self.brightness("CORONAL", (1.0, 0, 0.6)), 0.8)

    def test_a_file_that_is_dropped_is_loaded(self):
        self.settings.scan = ""
        bpy.ops.moulage.load_scan(directory=self.folder.name, files=[{"name": "egg.nrrd"}])
        self.assertEqual(self.settings.scan, str(self.path))

    def test_a_label_map_becomes_markers(self):
        labels = (scenes.egg_image() > 0) * 5
        names = "Segment0_Name:=left_kidney\nSegment0_LabelValue:=5\n"
        scenes.write_egg_scan(Path(self.folder.name) / "labels.nrrd", labels, names)
        with self.assertRaisesRegex(RuntimeError, "poll"):
            bpy.ops.moulage.markers_from_label()
        self.settings.label_map = str(Path(self.folder.name) / "labels.nrrd")
        self.assertEqual(self.settings.label, "5")
        self.settings.label_every, self.settings.label_spacing = 0.4, 0.2
        bpy.ops.moulage.markers_from_label()
        self.assertEqual(self.template.moulage.markers.name, "Left kidney (5)")
        axial = part("markers").points(self.template)
        self.settings.label_planes = {"AXIAL", "SAGITTAL"}
        bpy.ops.moulage.markers_from_label()
        both = part("markers").points(self.template)
        self.assertGreater(len(both), 1.5 * len(axial))
        x, y, z = both.T
        bx = (x - 0.1) / 1.3
        radius = numpy.sqrt(bx**2 + (y - 0.15 * bx**2) ** 2 + ((z - 0.25 * bx**2) / 0.8) ** 2)
        numpy.testing.assert_allclose(radius, 1.0, atol=0.15)
        self.template.moulage.method, self.template.moulage.tet_count = "lattice", 600
        self.assertEqual(bpy.ops.moulage.reshape(), {"FINISHED"})
        self.assertGreater(numpy.ptp(shape_of(self.template), axis=0)[0], 2.4)

    def test_an_image_that_is_no_label_map_is_refused(self):
        path = Path(self.folder.name) / "noise.nrrd"
        scenes.write_egg_scan(path, numpy.arange(41**3).reshape(41, 41, 41) % 9000 - 500)
        self.settings.label_map = str(path)
        with self.assertRaisesRegex(RuntimeError, "not a label map"):
            bpy.ops.moulage.markers_from_label()

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
