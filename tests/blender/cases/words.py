"""What is read: lengths in the scene's unit, heat maps and their legends."""

import unittest

import bpy
import numpy

import scenes
from scenes import part


class Lengths(unittest.TestCase):
    def setUp(self):
        scenes.empty_scene()
        self.settings = bpy.context.scene.unit_settings

    def texts(self, *lengths):
        return part("units").texts(bpy.context.scene, *lengths)

    def test_lengths_are_in_the_scene_s_unit_and_lengths_side_by_side_in_one(self):
        for system, name, scale, lengths, words in (
            ("METRIC", "MILLIMETERS", 0.001, (0.3141, 20.0), ["0.314 mm", "20 mm"]),
            ("METRIC", "CENTIMETERS", 0.001, (3.0,), ["0.3 cm"]),
            # Blender's own default.
            ("METRIC", "METERS", 1.0, (0.0003, 0.02), ["0.3 mm", "20 mm"]),
            ("METRIC", "METERS", 1.0, (3.54, 13.5), ["3.54 m", "13.5 m"]),
            ("METRIC", "ADAPTIVE", 1.0, (9.0,), ["9000 mm"]),
            ("IMPERIAL", "INCHES", 0.001, (25.4,), ["1 in"]),
            ("NONE", "ADAPTIVE", 1.0, (0.25,), ["0.25"]),
        ):
            with self.subTest(system=system, name=name):
                self.settings.system, self.settings.scale_length = system, scale
                if system != "NONE":
                    self.settings.length_unit = name
                self.assertEqual(self.texts(*lengths), words)

    def test_a_preset_of_the_tolerance_is_in_millimetres(self):
        template = scenes.ball_and_markers()
        for scale, tolerance in ((0.001, 0.3), (1.0, 0.0003)):
            bpy.context.scene.unit_settings.scale_length = scale
            bpy.ops.moulage.tolerance_preset(source="BONE")
            self.assertAlmostEqual(template.moulage.tolerance, tolerance, places=6)


class Volumes(unittest.TestCase):
    def test_a_volume_is_in_millilitres_where_lengths_are_millimetres(self):
        scenes.empty_scene()
        scene = bpy.context.scene
        settings = scene.unit_settings
        settings.system, settings.length_unit = "METRIC", "MILLIMETERS"
        volume = part("units").volume
        for scale, size in ((1.0, 0.00152), (0.001, 1_520_000.0)):
            settings.scale_length = scale
            self.assertEqual(volume(scene, size), "1520 ml")
        settings.length_unit = "CENTIMETERS"
        self.assertEqual(volume(scene, 1_520_000.0), "1520 cm\u00b3")
        settings.system = "NONE"
        self.assertEqual(volume(scene, 12.0), "12")


class HeatMaps(unittest.TestCase):
    def test_a_range_is_that_of_the_values_or_what_is_asked_for(self):
        value_range = part("heat_map").value_range
        values = numpy.append(numpy.linspace(0, 1, 1000), 50.0)
        low, high = value_range("DISTANCE", values)
        self.assertEqual(low, 0.0)
        self.assertAlmostEqual(high, 0.99, delta=0.01)
        self.assertEqual(value_range("DISTANCE", values, 5.0), (0.0, 5.0))
        self.assertEqual(value_range("STRETCH", values + 0.5, 4.0), (0.25, 4.0))
        self.assertEqual(value_range("DISTANCE", numpy.full(3, -1.0)), (0.0, 1e-12))

    def test_ticks_are_round_and_reach_from_end_to_end(self):
        ticks = part("legend").ticks
        numpy.testing.assert_allclose(ticks("DISTANCE", 0, 0.289), [0, 0.1, 0.2])
        numpy.testing.assert_allclose(ticks("DISTANCE", 0, 8.0), [0, 2, 4, 6, 8])
        numpy.testing.assert_allclose(sorted(ticks("STRETCH", 1 / 1.5, 1.5)), [1 / 1.4, 1 / 1.2, 1, 1.2, 1.4])

    def test_the_range_of_a_map_can_be_set_and_the_largest_value_is_known(self):
        template = scenes.ball_and_markers(iterations=2)
        bpy.ops.moulage.reshape()
        bpy.ops.moulage.show_heat_map(kind="DISTANCE")
        data = template.moulage
        before = numpy.array(data.result.heat_range)
        self.assertGreater(before[1], 0)
        largest = part("legend").largest_value(template, "DISTANCE")
        self.assertAlmostEqual(largest, data.result.max_distance, places=4)
        data.heat_limit = 3 * before[1]
        numpy.testing.assert_allclose(data.result.heat_range, 3 * before, rtol=1e-6)
        self.assertGreater(part("legend").largest_value(template, "STRETCH"), 1.0)


class Tooltips(unittest.TestCase):
    maxDiff = None

    def test_every_property_every_choice_and_every_operator_is_explained(self):
        operators = [getattr(bpy.ops.moulage, name).get_rna_type() for name in dir(bpy.ops.moulage)]
        groups = [cls.bl_rna for cls in bpy.types.PropertyGroup.__subclasses__() if cls.__name__.startswith("MOULAGE")]
        self.assertGreater(min(len(operators), len(groups)), 15)
        silent = [found.identifier for found in operators if not found.description]
        for found in operators + groups:
            silent += [f"{found.identifier}.{name}" for prop in found.properties for name in self.unexplained(prop)]
        self.assertEqual("\n".join(silent), "")

    def unexplained(self, prop):
        # Blender's own, and what is not shown.
        if prop.identifier in {"rna_type", "filepath", "files", "directory", "filter_glob", "check_existing"} or prop.is_hidden:
            return
        if not prop.description:
            yield prop.identifier
        if prop.type == "ENUM":
            yield from (f"{prop.identifier}: {item.identifier}" for item in prop.enum_items if not item.description)
