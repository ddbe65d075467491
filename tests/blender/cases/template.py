"""The template: looked at, put right, filled with tets."""

import unittest

import bpy

import scenes
from scenes import points_of


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
