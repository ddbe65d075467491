# SPDX-License-Identifier: GPL-3.0-or-later
"""The scan: load it, choose a window, show its slices."""

import bpy
from bpy_extras.io_utils import ImportHelper

from .. import scan
from ..library import Wrong
from .base import tells


class MOULAGE_OT_load_scan(bpy.types.Operator, ImportHelper):
    """Load an image volume: NIfTI, NRRD, MetaImage, or any one file of a DICOM series"""

    bl_idname = "moulage.load_scan"
    bl_label = "Load Scan"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ""
    filter_glob: bpy.props.StringProperty(default="*.nii;*.gz;*.nrrd;*.nhdr;*.mha;*.mhd;*.dcm;*.ima;*", options={"HIDDEN"})

    @tells
    def execute(self, context):
        settings = context.scene.moulage
        before = settings.scan
        settings.scan = self.filepath
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


class MOULAGE_OT_scan_window(bpy.types.Operator):
    """Set window and level to what suits a tissue"""

    bl_idname = "moulage.scan_window"
    bl_label = "Window"
    bl_options = {"REGISTER", "UNDO"}

    preset: bpy.props.EnumProperty(
        name="Window", items=[(key, name, f"Window {width}, level {level}") for key, (name, width, level) in scan.PRESETS.items()]
    )

    def execute(self, context):
        _name, width, level = scan.PRESETS[self.preset]
        context.scene.moulage.window_width, context.scene.moulage.window_level = width, level
        return {"FINISHED"}


class MOULAGE_OT_look_at_slice(bpy.types.Operator):
    """Look straight at the slice; the axial one from the feet, as radiologists do"""

    bl_idname = "moulage.look_at_slice"
    bl_label = "Look at Slice"

    view: bpy.props.EnumProperty(name="Slice", items=[(v, v.capitalize(), "") for v in scan.VIEWS])

    @classmethod
    def poll(cls, context):
        return context.region_data is not None and bool(scan.slices(context.scene))

    @tells
    def execute(self, context):
        empty = scan.slices(context.scene).get(self.view)
        if empty is None:
            raise Wrong("That slice was deleted: load the scan again.")
        empty.hide_viewport = False
        view = context.region_data
        view.view_perspective = "ORTHO"
        view.view_rotation = empty.matrix_world.to_quaternion()
        view.view_location = empty.matrix_world.translation
        view.view_distance = 1.6 * empty.empty_display_size
        return {"FINISHED"}


classes = (MOULAGE_OT_load_scan, MOULAGE_OT_scan_window, MOULAGE_OT_look_at_slice)
