# SPDX-License-Identifier: GPL-3.0-or-later
"""Files: markers and landmarks of 3D Slicer, MeshLab and tables, in and out."""

import bpy
import numpy
from bpy_extras.io_utils import ExportHelper, ImportHelper

from .. import landmarks, markers, preflight, problem, properties
from ..library import Wrong, calls
from .base import DropsIntoView, Imports, NeedsTemplate, tells

READ = "*.mrk.json;*.json;*.fcsv;*.pp;*.csv;*.xyz;*.txt;*.ply"
_WRITTEN = (
    (".mrk.json", "3D Slicer markups (.mrk.json)"), (".fcsv", "3D Slicer fiducials (.fcsv)"),
    (".pp", "MeshLab picked points (.pp)"), (".csv", "Table (.csv)"),
)


SCALE = bpy.props.FloatProperty(
    name="Scale", description="Length in the scene of one unit of the file: 0.001 for millimetres in a scene in metres",
    default=1.0, min=1e-9, soft_min=0.001, soft_max=1000.0,
)


class MOULAGE_OT_import_markers(Imports, bpy.types.Operator):
    """Read points of the person's surface: 3D Slicer, MeshLab, tables. Slicer's are turned into RAS"""

    bl_idname = "moulage.import_markers"
    bl_label = "Import Markers"

    filter_glob: bpy.props.StringProperty(default=READ, options={"HIDDEN"})
    as_empties: bpy.props.BoolProperty(name="As empties", description="One empty per marker, to move them by hand")
    scale: SCALE

    @tells
    def execute(self, context):
        names = self.paths()
        with calls() as library:
            positions = numpy.vstack([library.Markers.load(name).points for name in names]) * self.scale
        name = names[0].name.split(".")[0]
        template = properties.template_of(context)
        if self.as_empties:
            size = float(numpy.linalg.norm(numpy.ptp(positions, axis=0))) / 200 or 1.0
            made = markers.add_empties(context, name, positions, size)
            if template is not None:
                template.moulage.marker_empties = made
        else:
            made = markers.add_object(context, name, positions)
            if template is not None:
                template.moulage.markers = made
        if template is not None:
            preflight.look(context, template)
        self.report({"INFO"}, f"{len(positions)} markers read.")
        return {"FINISHED"}


class MOULAGE_OT_import_landmarks(NeedsTemplate, bpy.types.Operator, ImportHelper):
    """Read landmarks: a table of pairs, or two marker files (the template's and the person's) that are paired
    by their labels"""

    bl_idname = "moulage.import_landmarks"
    bl_label = "Import Landmarks"

    filename_ext = ""
    filter_glob: bpy.props.StringProperty(default=READ, options={"HIDDEN"})
    person: bpy.props.StringProperty(
        name="Person's file", description="The file with the same labels on the person; empty for a table of pairs",
        subtype="FILE_PATH",
    )
    scale: SCALE

    @tells
    def execute(self, context):
        template = properties.template_of(context)
        person = bpy.path.abspath(self.person) or None
        inputs = problem.gather_shape(context, template)
        # Places in the file are in its own unit.
        with calls() as library:
            surface = library.TriMesh(inputs.points / self.scale, inputs.triangles)
            found = library.Pairs.load_landmarks(surface, self.filepath, person)
        rows = zip(
            found.labels, found.template_points * self.scale, found.targets * self.scale, found.weights,
            found.within * self.scale,
        )
        for label, point, target, weight, within in rows:
            landmark = landmarks.add(context, template, label, point, target)
            landmark.weight = weight
            if within >= 0:
                landmark.hold, landmark.within = "WITHIN" if within > 0 else "EXACT", within
        landmarks.hide_parent_lines(context)
        preflight.look(context, template)
        self.report({"INFO"}, f"{len(found.weights)} landmarks read. {found.warning or ''}".strip())
        return {"FINISHED"}


class _Export(NeedsTemplate, ExportHelper):
    bl_options = {"REGISTER"}
    check_extension = None

    def invoke(self, context, event):
        if not self.filepath:
            template = properties.template_of(context)
            self.filepath = f"{template.name} {self.what}{self.format}"
        return ExportHelper.invoke(self, context, event)

    def check(self, _context):
        """Keeps the name's ending in step with the format."""
        stem = self.filepath
        for ending, _ in _WRITTEN:
            if stem.lower().endswith(ending):
                stem = stem[: -len(ending)]
        changed = stem + self.format != self.filepath
        self.filepath = stem + self.format
        return changed

    def save(self, positions, labels):
        with calls() as library:
            library.Markers(positions / self.scale, labels=labels).save(self.filepath)
        self.report({"INFO"}, f"{len(positions)} points written to {self.filepath}.")
        return {"FINISHED"}


_FORMAT = bpy.props.EnumProperty(
    name="Format", description="Which program is to read the file",
    items=[(ending, text, f"A file ending in {ending}") for ending, text in _WRITTEN],
)


class MOULAGE_OT_export_markers(_Export, bpy.types.Operator):
    """Write the markers for 3D Slicer, MeshLab or as a table"""

    bl_idname = "moulage.export_markers"
    bl_label = "Export Markers"

    what = "markers"
    filename_ext = ""
    format: _FORMAT
    scale: SCALE

    @tells
    def execute(self, context):
        positions = markers.points(properties.template_of(context))
        if len(positions) == 0:
            raise Wrong("The template has no markers.")
        return self.save(positions, None)


class MOULAGE_OT_export_landmarks(_Export, bpy.types.Operator):
    """Write one side of the landmarks for 3D Slicer, MeshLab or as a table"""

    bl_idname = "moulage.export_landmarks"
    bl_label = "Export Landmarks"

    what = "landmarks"
    filename_ext = ""
    format: _FORMAT
    side: bpy.props.EnumProperty(
        name="Side", description="Which of the two places is written",
        items=[("TARGET", "Person", "Their places on the person"), ("TEMPLATE", "Template", "Their places on the template")],
    )
    scale: SCALE

    @tells
    def execute(self, context):
        empties = [
            (l.name, l.target if self.side == "TARGET" else l.template)
            for l in properties.template_of(context).moulage.landmarks
        ]
        whole = [(name, landmarks.position(empty)) for name, empty in empties if empty is not None]
        if not whole:
            raise Wrong("There are no landmarks on this side.")
        return self.save(numpy.array([p for _, p in whole]), [n for n, _ in whole])


classes = (
    MOULAGE_OT_import_markers, MOULAGE_OT_import_landmarks, MOULAGE_OT_export_markers, MOULAGE_OT_export_landmarks,
)

if bpy.app.version >= (4, 1, 0):

    class MOULAGE_FH_markers(DropsIntoView, bpy.types.FileHandler):
        """Marker files can be dropped into the 3D view."""

        bl_idname = "MOULAGE_FH_markers"
        bl_label = "Moulage markers"
        bl_import_operator = "moulage.import_markers"
        bl_file_extensions = ".json;.fcsv;.pp;.csv;.xyz"

    classes += (MOULAGE_FH_markers,)
