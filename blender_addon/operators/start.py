# SPDX-License-Identifier: GPL-3.0-or-later
"""The first two steps: the template from a file, and the person from files; in millimetres, upright, framed, set."""

import bpy

from .. import mesh_files, preflight, properties, scan, units, views
from ..library import Wrong, refusal
from .base import Imports, poll_object_mode, tells
from .files import READ
from .template import set_millimetres

_MESHES = ";".join(f"*{ending}" for ending in mesh_files.ENDINGS)
_UNITS = {"MILLIMETRES": 1.0, "CENTIMETRES": 10.0, "METRES": 1000.0}


class _Starts(Imports):
    @classmethod
    def poll(cls, context):
        return poll_object_mode(cls, context.mode)


class MOULAGE_OT_import_template(_Starts, bpy.types.Operator):
    """Read the template from a file (.obj, .ply, .stl): in millimetres, in the axes of medical images, in view, set"""

    bl_idname = "moulage.import_template"
    bl_label = "Import Template"

    filter_glob: bpy.props.StringProperty(default=_MESHES, options={"HIDDEN"})
    unit: bpy.props.EnumProperty(
        name="Unit", description="What one unit of the file is",
        items=[
            ("AUTO", "By its size", "Metres where it is smaller than 3 units, else millimetres"),
            ("MILLIMETRES", "Millimetres", "Coordinates are taken as they are"),
            ("CENTIMETRES", "Centimetres", "Made ten times larger"), ("METRES", "Metres", "Made a thousand times larger"),
        ],
    )
    y_up: bpy.props.BoolProperty(
        name="Y Is Up", description="The file comes from a program in which Y is up; in medical files Z is"
    )

    @tells
    def execute(self, context):
        template = mesh_files.load(context, self.paths()[0], self.y_up)
        size = max(template.dimensions)
        unit = ("METRES" if size < 3.0 else "MILLIMETRES") if self.unit == "AUTO" else self.unit
        template.scale *= _UNITS[unit]
        set_millimetres(context)
        context.view_layer.update()
        context.scene.moulage.template = template
        preflight.look(context, template)
        views.frame_selected(context)
        said = f"The template is {units.text(context.scene, max(template.dimensions))} long."
        self.report({"INFO"}, " ".join([said, *(row.text for row in template.moulage.doubts)]))
        return {"FINISHED"}


class MOULAGE_OT_import_person(_Starts, bpy.types.Operator):
    """Read what is known of the person, from one file or several at once: a surface, markers, landmarks, a scan"""

    bl_idname = "moulage.import_person"
    bl_label = "Import Person"

    filter_glob: bpy.props.StringProperty(
        default=";".join((_MESHES, READ, *(f"*{ending}" for ending in scan.ENDINGS))), options={"HIDDEN"}
    )

    @classmethod
    def poll(cls, context):
        if properties.template_of(context) is None:
            cls.poll_message_set("Import the template first: the person is compared with it")
            return False
        return super().poll(context)

    @tells
    def execute(self, context):
        template = properties.template_of(context)
        paths = self.paths()
        # Where there are no markers a surface's vertices are.
        for path in sorted(paths, key=lambda path: not mesh_files.is_mesh(path)):
            self._read(context, template, path)
        bpy.ops.object.select_all(action="DESELECT")
        for ob in filter(None, (template, template.moulage.markers)):
            ob.select_set(True)
        context.view_layer.objects.active = template
        views.frame_selected(context)
        preflight.look(context, template)
        doubts = [row.text for row in template.moulage.doubts]
        self.report({"INFO"}, " ".join(doubts or [f"{len(paths)} file{'s' if len(paths) > 1 else ''} read."]))
        return {"FINISHED"}

    def _read(self, context, template, path):
        if path.is_dir() or path.suffix.lower() in scan.ENDINGS:
            self._call(bpy.ops.moulage.load_scan, path)
        elif mesh_files.is_mesh(path):
            person = mesh_files.load(context, path)
            template.moulage.markers = person
        elif _holds_pairs(path):
            self._call(bpy.ops.moulage.import_landmarks, path)
        else:
            self._call(bpy.ops.moulage.import_markers, path)

    def _call(self, operator, path):
        try:
            operator(filepath=str(path))
        except RuntimeError as error:
            raise Wrong(refusal(error)) from None


def _holds_pairs(path):
    """Whether a table has places on the template beside those on the person."""
    if path.suffix.lower() not in {".csv", ".txt"}:
        return False
    with open(path, encoding="utf-8", errors="replace") as file:
        lines = (line.strip() for line in file)
        return "target_x" in next((line for line in lines if line and not line.startswith("#")), "").lower()


classes = (MOULAGE_OT_import_template, MOULAGE_OT_import_person)
