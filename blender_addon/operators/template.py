# SPDX-License-Identifier: GPL-3.0-or-later
"""The template: choose, check, put right, fill with tets."""

import bmesh
import bpy

from .. import preflight, problem, properties, runs, scan, solve, views
from ..library import Wrong, sentence
from .base import NeedsTemplate, tells


class MOULAGE_OT_set_template(bpy.types.Operator):
    """Take the active mesh as the template"""

    bl_idname = "moulage.set_template"
    bl_label = "Active Mesh as Template"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if context.object is None or context.object.type != "MESH":
            cls.poll_message_set("Select a mesh")
            return False
        return not runs.is_running()

    def execute(self, context):
        context.scene.moulage.template = context.object
        preflight.look(context, context.object)
        return {"FINISHED"}


class MOULAGE_OT_check_template(NeedsTemplate, bpy.types.Operator):
    """Look for holes, flipped faces and doubled vertices, and for units, axes, landmarks and a place that do not go
    together"""

    bl_idname = "moulage.check_template"
    bl_label = "Check"

    @tells
    def execute(self, context):
        template = properties.template_of(context)
        preflight.look(context, template)
        doubts = template.moulage.doubts
        self.report({"INFO"}, doubts[0].text if doubts else "The template is closed and clean, and nothing is suspicious.")
        return {"FINISHED"}


class MOULAGE_OT_fix_template(NeedsTemplate, bpy.types.Operator):
    """Put right what the check found. Steps that add or remove vertices are left out once the mesh has
    shape keys"""

    bl_idname = "moulage.fix_template"
    bl_label = "Fix"

    normals: bpy.props.BoolProperty(name="Faces outward", description="Turn faces that look inward", default=True)
    doubles: bpy.props.BoolProperty(
        name="Merge doubled vertices", description="Those that lie at one place become one", default=True
    )
    loose: bpy.props.BoolProperty(
        name="Remove loose vertices", description="Those that no face has", default=True
    )
    holes: bpy.props.BoolProperty(name="Close holes", description="Fill them with faces", default=True)

    @tells
    def execute(self, context):
        template = properties.template_of(context)
        mesh = template.data
        if mesh.library is not None:
            raise Wrong("The template's mesh is linked from another file: make it local first.")
        before = len(mesh.vertices)
        work = bmesh.new()
        work.from_mesh(mesh)
        if mesh.shape_keys is None:
            self._change_vertices(work)
        if self.normals:
            bmesh.ops.recalc_face_normals(work, faces=work.faces)
        work.to_mesh(mesh)
        work.free()
        mesh.update()
        preflight.look(context, template)
        self.report({"INFO"}, f"{before} vertices before, {len(mesh.vertices)} now.")
        return {"FINISHED"}

    def _change_vertices(self, work):
        if self.doubles:
            size = max((v.co.length for v in work.verts), default=1.0)
            bmesh.ops.remove_doubles(work, verts=work.verts, dist=1e-6 * size)
        if self.loose:
            loose = [v for v in work.verts if not v.link_faces]
            bmesh.ops.delete(work, geom=loose, context="VERTS")
        if self.holes:
            border = [e for e in work.edges if e.is_boundary]
            if border:
                filled = bmesh.ops.holes_fill(work, edges=border, sides=0)["faces"]
                bmesh.ops.triangulate(work, faces=filled)


def set_millimetres(context):
    settings = context.scene.unit_settings
    before = settings.scale_length
    settings.system = "METRIC"
    settings.scale_length = 0.001
    settings.length_unit = "MILLIMETERS"
    views.reach_far(context)
    scan.follow_unit(context, before)


class MOULAGE_OT_use_millimetres(bpy.types.Operator):
    """Let one unit of the scene be a millimetre, and let the 3D views reach far enough"""

    bl_idname = "moulage.use_millimetres"
    bl_label = "Millimetres"
    bl_options = {"REGISTER", "UNDO"}

    @tells
    def execute(self, context):
        set_millimetres(context)
        template = properties.template_of(context)
        if template is not None and not runs.is_running():
            preflight.look(context, template)
        return {"FINISHED"}


class MOULAGE_OT_tetrahedralize(NeedsTemplate, bpy.types.Operator):
    """Fill the template with tets and measure them. Reshape does this by itself; here you see how good they are"""

    bl_idname = "moulage.tetrahedralize"
    bl_label = "Fill with Tets"

    @tells
    def execute(self, context):
        template = properties.template_of(context)
        inputs = problem.gather_shape(context, template)
        tets = solve.tets_of(inputs)
        quality, how = tets.quality, {"tetgen": "TetGen", "lattice": "the lattice"}[tets.method]
        lines = [
            f"{quality['tet_count']} tets by {how}",
            f"Angles {quality['min_dihedral']:.0f}° to {quality['max_dihedral']:.0f}°, "
            f"mean quality {quality['mean_radius_ratio']:.2f} of 1",
        ]
        lines += [sentence(line) for line in tets.warnings]
        template.moulage.tets_text = "\n".join(lines)
        self.report({"INFO"}, lines[0])
        return {"FINISHED"}


classes = (
    MOULAGE_OT_set_template, MOULAGE_OT_check_template, MOULAGE_OT_fix_template, MOULAGE_OT_use_millimetres,
    MOULAGE_OT_tetrahedralize,
)
