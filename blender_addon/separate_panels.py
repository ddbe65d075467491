# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels of Separate."""

import bpy

from . import runs, separate_properties
from .panels import Panel, draw_run, field, write
from .result import SEPARATED


class MOULAGE_PT_separate(Panel, bpy.types.Panel):
    bl_label = "Separate"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        if runs.is_running():
            draw_run(context, layout)
            return
        settings = context.scene.moulage_separate
        soft, hard = separate_properties.chosen(context)
        field(layout, settings, "bones")
        layout.prop(settings, "gap")
        if len(soft) + len(hard) < 2 or not soft:
            write(layout, context, "Select the muscles or organs that overlap.", "INFO")
        else:
            stay = f", {len(hard)} stay" if hard else ""
            layout.label(text=f"{len(soft)} selected{stay}", icon="MOD_SOFT")
        row = layout.row()
        row.scale_y = 1.5
        row.operator("moulage.separate", icon="PLAY")
        self._result(context, layout, settings)

    def _result(self, context, layout, settings):
        if settings.report:
            first, *others = settings.report.splitlines()
            write(layout, context, first, "CHECKMARK" if settings.clear else "ERROR")
            write(layout, context, "\n".join(others))
        ob = context.active_object
        keys = ob.data.shape_keys if ob is not None and ob.type == "MESH" else None
        if keys is not None and SEPARATED in keys.key_blocks:
            layout.prop(keys.key_blocks[SEPARATED], "value", text="Before to After", slider=True)


class MOULAGE_PT_separate_settings(Panel, bpy.types.Panel):
    bl_label = "Tets and Settings"
    bl_parent_id = "MOULAGE_PT_separate"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.enabled = not runs.is_running()
        write(layout, context, "Meshes that were not reshaped here are filled with tets.")
        settings = context.scene.moulage_separate
        field(layout, settings, "method")
        column = layout.column()
        for name in ("tet_count", "rings", "live"):
            column.prop(settings, name)


classes = (MOULAGE_PT_separate, MOULAGE_PT_separate_settings)
