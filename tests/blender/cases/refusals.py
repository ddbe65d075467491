"""What cannot work is said in a sentence."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import bpy

import scenes
from scenes import part


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
        self.refused("their files are in two units")

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
