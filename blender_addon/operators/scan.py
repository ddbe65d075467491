# SPDX-License-Identifier: GPL-3.0-or-later
"""The scan: load it, choose a window, show its slices."""

import bpy

from .. import markers, properties, scan, slice_view
from ..library import Wrong, calls
from .base import DropsIntoView, Imports, NeedsTemplate, tells


class MOULAGE_OT_load_scan(Imports, bpy.types.Operator):
    """Load an image volume: NIfTI, NRRD, MetaImage, or DICOM: a folder with one series, or any one file of a series"""

    bl_idname = "moulage.load_scan"
    bl_label = "Load Scan"

    filter_glob: bpy.props.StringProperty(default=";".join((*(f"*{ending}" for ending in scan.ENDINGS), "*")), options={"HIDDEN"})

    @tells
    def execute(self, context):
        settings = context.scene.moulage
        before = settings.scan
        settings.scan = str(self.paths()[0])
        try:
            read, info = scan.volume(context.scene)
            settings.window_width, settings.window_level = (float(v) for v in info["window"])
            scan.make_slices(context)
        except Wrong:
            settings.scan = before
            raise
        size = " x ".join(str(n) for n in info["size"])
        self.report({"INFO"}, " ".join([f"{size} voxels read.", *read.notes]))
        return {"FINISHED"}


class MOULAGE_OT_markers_from_label(NeedsTemplate, bpy.types.Operator):
    """Put markers on the outlines of a label of the map, as a person would click them on slices; they replace the
    template's marker object"""

    bl_idname = "moulage.markers_from_label"
    bl_label = "Markers from Label"

    @classmethod
    def poll(cls, context):
        if not context.scene.moulage.label_map:
            cls.poll_message_set("Choose a label map first")
            return False
        return super().poll(context)

    @tells
    def execute(self, context):
        settings = context.scene.moulage
        volume, labels = scan.label_map(context.scene)
        if not labels:
            raise Wrong("The label map is empty: it has no label above 0.")
        if not settings.label_planes:
            raise Wrong("Choose at least one kind of slice.")
        axes = [scan.AXES[view] for view in scan.AXES if view in settings.label_planes]
        with calls() as library:
            found = volume.label_markers(
                int(settings.label), axes, library.Clicks(every=settings.label_every, spacing=settings.label_spacing)
            )
        positions = found.points * scan.unit(context.scene)
        name = scan.label_name(int(settings.label))
        made = markers.add_object(context, name, positions)
        properties.template_of(context).moulage.markers = made
        self.report({"INFO"}, f"{len(positions)} markers on the outlines of {name}.")
        return {"FINISHED"}


class MOULAGE_OT_scan_window(bpy.types.Operator):
    """Set window and level to what suits a tissue"""

    bl_idname = "moulage.scan_window"
    bl_label = "Window"
    bl_options = {"REGISTER", "UNDO"}

    preset: bpy.props.EnumProperty(
        name="Window", description="The tissue that is to be seen well", items=[(key, name, f"Window {width}, level {level}") for key, (name, width, level) in scan.PRESETS.items()]
    )

    def execute(self, context):
        _name, width, level = scan.PRESETS[self.preset]
        context.scene.moulage.window_width, context.scene.moulage.window_level = width, level
        return {"FINISHED"}


class MOULAGE_OT_look_at_slice(bpy.types.Operator):
    """Look straight at the slice and hide all but it, its outline and the markers near it; the axial one from the
    feet, as radiologists do. Once more: back to all"""

    bl_idname = "moulage.look_at_slice"
    bl_label = "Look at Slice"
    bl_options = {"REGISTER", "UNDO"}

    view: bpy.props.EnumProperty(
        name="Slice", description="Which slice is looked at",
        items=[(view, view.capitalize(), f"The {view.lower()} slice") for view in scan.VIEWS],
    )

    @classmethod
    def poll(cls, context):
        scene = context.scene
        return context.region_data is not None and bool(scan.slices(scene) or scene.moulage.looking_at)

    @tells
    def execute(self, context):
        if context.scene.moulage.looking_at == self.view:
            slice_view.leave(context)
            return {"FINISHED"}
        empty = scan.slices(context.scene).get(self.view)
        if empty is None:
            raise Wrong("That slice was deleted: load the scan again.")
        slice_view.enter(context, self.view)
        view = context.region_data
        view.view_perspective = "ORTHO"
        view.view_rotation = empty.matrix_world.to_quaternion()
        view.view_location = empty.matrix_world.translation
        view.view_distance = 1.6 * empty.empty_display_size
        return {"FINISHED"}


classes = (MOULAGE_OT_load_scan, MOULAGE_OT_markers_from_label, MOULAGE_OT_scan_window, MOULAGE_OT_look_at_slice)

if bpy.app.version >= (4, 1, 0):

    class MOULAGE_FH_scan(DropsIntoView, bpy.types.FileHandler):
        """Images can be dropped into the 3D view."""

        bl_idname = "MOULAGE_FH_scan"
        bl_label = "Moulage scan"
        bl_import_operator = "moulage.load_scan"
        bl_file_extensions = ";".join(scan.ENDINGS)

    classes += (MOULAGE_FH_scan,)
