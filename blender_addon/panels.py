# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels of the tab "Moulage", in the order of work."""

import textwrap

import bpy

from . import heat_map, landmarks, library, properties, runs, scan, units
from .library import Wrong


class Panel:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Moulage"


class NeedsTemplate(Panel):
    @classmethod
    def poll(cls, context):
        return properties.template_of(context) is not None


def letters(context):
    """How many letters a line of the panel holds."""
    return max(20, int(context.region.width / (7.5 * context.preferences.system.ui_scale)) - 4)


def write(layout, context, text, icon="NONE", width=0):
    """A text in as many lines as the panel's width asks for, or of so many letters."""
    width = width or letters(context)
    column = layout.column(align=True)
    column.scale_y = 0.8
    for paragraph in text.splitlines():
        for number, line in enumerate(textwrap.wrap(paragraph, width)):
            column.label(text=line, icon=icon if number == 0 else ("BLANK1" if icon != "NONE" else "NONE"))


def field(layout, data, name, **search):
    """A property with its name above it: beside it the name would be cut off. `search`: where its value is looked for."""
    column = layout.column(align=True)
    title = column.row()
    title.scale_y = 0.7
    title.label(text=data.bl_rna.properties[name].name)
    if search:
        column.prop_search(data, name, search["of"], search["among"], text="")
    else:
        column.prop(data, name, text="")


def draw_doubts(layout, context, template, width=0):
    """What is suspicious, each sentence with the button that mends it."""
    width = width or letters(context) - 3
    for index, row in enumerate(template.moulage.doubts):
        box = layout.box().column()
        write(box, context, row.text, "INFO" if row.severity == "note" else "ERROR", width)
        if row.button:
            box.operator("moulage.mend", text=row.button).index = index


class MOULAGE_PT_template(Panel, bpy.types.Panel):
    bl_label = "Template"

    def draw(self, context):
        layout = self.layout
        problem = library.problem()
        if problem is not None:
            write(layout, context, problem, "ERROR")
            return
        column = layout.column()
        column.enabled = not runs.is_running()
        column.prop(context.scene.moulage, "template", text="")
        template = properties.template_of(context)
        if template is None:
            column.operator("moulage.import_template", icon="IMPORT")
            column.operator("moulage.set_template", icon="MESH_DATA")
            write(layout, context, "The mesh that is to take the person's shape.", "INFO")
            return
        if template.mode != "OBJECT":
            write(layout, context, "Go back to Object Mode.", "ERROR")
        self._check(context, column, template)

    def _check(self, context, column, template):
        data = template.moulage
        row = column.row(align=True)
        row.operator("moulage.check_template", icon="VIEWZOOM")
        row.operator("moulage.fix_template", icon="MODIFIER")
        if data.checked and not any(row.concern == "surface" for row in data.doubts):
            column.label(text="Closed and clean", icon="CHECKMARK")
        draw_doubts(column, context, template)
        if abs(context.scene.unit_settings.scale_length - 0.001) > 1e-6:
            column.operator("moulage.use_millimetres", icon="DRIVER_DISTANCE", text="Coordinates Are Millimetres")


class MOULAGE_PT_scan(Panel, bpy.types.Panel):
    bl_label = "Scan"

    def draw(self, context):
        layout = self.layout
        settings = context.scene.moulage
        layout.operator("moulage.load_scan", icon="IMPORT")
        there = scan.slices(context.scene)
        if not there:
            write(layout, context, "A CT or MRI, shown as slices on which markers can be clicked.", "INFO")
            return
        if scan.missing(context.scene):
            write(layout, context, scan.missing(context.scene), "ERROR")
        column = layout.column(align=True)
        for view, empty in there.items():
            row = column.row(align=True)
            if view in scan.AXES:
                row.prop(settings, view.lower())
            else:
                row.label(text="Oblique")
            looked_at = settings.looking_at == view
            row.operator("moulage.look_at_slice", text="", icon="VIEW_ORTHO", depress=looked_at).view = view
            row.prop(empty, "hide_viewport", text="")
        if settings.looking_at:
            layout.operator("moulage.look_at_slice", text="Back to All", icon="LOOP_BACK").view = settings.looking_at
        column = layout.column(align=True)
        column.prop(settings, "window_width")
        column.prop(settings, "window_level")
        column.operator_menu_enum("moulage.scan_window", "preset", text="Presets")
        layout.prop(settings, "scan_opacity")
        layout.prop(settings, "show_contour")
        layout.operator("moulage.click_markers", icon="EYEDROPPER")


class MOULAGE_PT_labels(NeedsTemplate, bpy.types.Panel):
    bl_label = "Markers from a Label Map"
    bl_parent_id = "MOULAGE_PT_scan"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        settings = context.scene.moulage
        layout.prop(settings, "label_map", text="")
        column = layout.column()
        column.enabled = bool(settings.label_map)
        column.prop(settings, "label", text="")
        column.row(align=True).prop(settings, "label_planes")
        column = column.column(align=True)
        column.prop(settings, "label_every")
        column.prop(settings, "label_spacing")
        if settings.label_map:
            try:
                scan.label_map(context.scene)
            except Wrong as wrong:
                write(layout, context, str(wrong), "ERROR")
        layout.operator("moulage.markers_from_label", icon="OUTLINER_OB_POINTCLOUD")


class MOULAGE_UL_landmarks(bpy.types.UIList):
    def draw_item(self, context, layout, _data, item, _icon, _active, _property):
        half = item.template is None or item.target is None
        split = layout.split(factor=0.8, align=True) if half or item.residual >= 0 else layout
        row = split.row(align=True)
        row.active = item.use
        row.prop(item, "name", text="", emboss=False, icon=properties.HOLD_ICONS[item.hold])
        if half:
            split.label(text="half")
        elif item.residual >= 0:
            # The unit would not fit; the line below the list has it.
            size, _name = units.unit(context.scene, item.residual)
            split.label(text=units.number(item.residual / size))


class MOULAGE_PT_markers(NeedsTemplate, bpy.types.Panel):
    bl_label = "Markers"

    def draw(self, context):
        layout = self.layout
        data = properties.template_of(context).moulage
        layout.operator("moulage.import_person", icon="IMPORT")
        write(layout, context, "Points of the person's surface, in no order.")
        field(layout, data, "markers")
        field(layout, data, "marker_empties")
        row = layout.row(align=True)
        row.operator("moulage.import_markers", text="Import", icon="IMPORT")
        row.operator("moulage.export_markers", text="Export", icon="EXPORT")
        layout.prop(data, "show_markers")


class MOULAGE_PT_landmarks(NeedsTemplate, bpy.types.Panel):
    bl_label = "Landmarks"

    def draw(self, context):
        layout = self.layout
        template = properties.template_of(context)
        data = template.moulage
        row = layout.row(align=True)
        row.operator("moulage.pick_landmarks", icon="EYEDROPPER")
        if data.landmarks:
            row.operator("moulage.remove_landmark", text="", icon="REMOVE").all = False
            row.operator("moulage.remove_landmark", text="", icon="TRASH").all = True
            layout.template_list("MOULAGE_UL_landmarks", "", data, "landmarks", data, "active_landmark", rows=4)
            if data.active_landmark < len(data.landmarks):
                item = data.landmarks[data.active_landmark]
                if item.residual >= 0:
                    write(layout, context, f"{item.name}: {units.text(context.scene, item.residual)} off")
                row = layout.row(align=True)
                row.prop(item, "use", text="")
                row.prop(item, "hold", text="")
                if item.hold == "WITHIN":
                    layout.prop(item, "within")
                elif item.hold == "HINT":
                    layout.prop(item, "weight")
        row = layout.row(align=True)
        row.operator("moulage.import_landmarks", text="Import", icon="IMPORT")
        row.operator("moulage.export_landmarks", text="Export", icon="EXPORT")
        if landmarks.without_partner(template):
            layout.operator("moulage.mirror_landmarks", icon="MOD_MIRROR")
        column = layout.column(align=True)
        column.operator("moulage.place_template", text="Place", icon="ORIENTATION_GLOBAL").scale = False
        column.operator("moulage.place_template", text="Place and Scale", icon="FULLSCREEN_ENTER").scale = True
        missing = 3 - len(landmarks.used(template))
        if missing > 0 and data.markers is None and data.marker_empties is None:
            write(layout, context, f"Click {missing} more pair{'s' if missing > 1 else ''}, or add markers.", "INFO")


class MOULAGE_PT_attachments(NeedsTemplate, bpy.types.Panel):
    bl_label = "Attachments"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        template = properties.template_of(context)
        data = template.moulage
        row = layout.row()
        row.template_list("UI_UL_list", "moulage_attachments", data, "attachments", data, "active_attachment", rows=2)
        side = row.column(align=True)
        side.operator("moulage.add_attachment", text="", icon="ADD")
        side.operator("moulage.remove_attachment", text="", icon="REMOVE")
        if data.active_attachment < len(data.attachments):
            item = data.attachments[data.active_attachment]
            for name in ("bone", "target", "by"):
                field(layout, item, name)
            if item.by == "GROUP":
                field(layout, item, "group", of=template, among="vertex_groups")
            else:
                layout.prop(item, "distance")
        layout.prop(data, "hard_attachments")
        field(layout, data, "fixed_group", of=template, among="vertex_groups")


class MOULAGE_PT_reshape(NeedsTemplate, bpy.types.Panel):
    bl_label = "Reshape"

    def draw(self, context):
        layout = self.layout
        if runs.is_running():
            draw_run(context, layout)
            return
        template = properties.template_of(context)
        data = template.moulage
        column = layout.column(align=True)
        column.operator_menu_enum("moulage.tolerance_preset", "source", text="Presets")
        column.prop(data, "tolerance")
        column.prop(data, "landmark_tolerance")
        if data.attachments:
            column.prop(data, "attachment_tolerance")
        if data.tolerance == 0.0:
            usual = units.text(context.scene, template.dimensions.length / 1000)
            write(layout, context, f"0: a thousandth of the template's size, about {usual}.")
        row = layout.row()
        row.scale_y = 1.5
        row.operator("moulage.reshape", icon="PLAY")


def draw_run(context, layout):
    """Where the present run stands, and the button that stops it."""
    state = context.window_manager.moulage
    if hasattr(layout, "progress"):
        layout.progress(factor=state.fraction, text=f"{100 * state.fraction:.0f} %  {state.stage}")
    else:
        layout.prop(state, "fraction", text=state.stage, slider=True)
    if state.details:
        write(layout, context, state.details)
    row = layout.row()
    row.scale_y = 1.5
    row.operator("moulage.stop", icon="CANCEL", text="Stop and Keep the Best")


class MOULAGE_PT_tets(NeedsTemplate, bpy.types.Panel):
    bl_label = "Tets and Settings"
    bl_parent_id = "MOULAGE_PT_reshape"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.enabled = not runs.is_running()
        data = properties.template_of(context).moulage
        field(layout, data, "method")
        column = layout.column()
        column.prop(data, "tet_count")
        column.operator("moulage.tetrahedralize", icon="MESH_ICOSPHERE")
        if data.tets_text:
            write(layout, context, data.tets_text)
        column = layout.column()
        for name in ("smoothness", "max_iterations", "reverse_term", "live", "new_key"):
            column.prop(data, name)


class MOULAGE_PT_carried(NeedsTemplate, bpy.types.Panel):
    bl_label = "Carried Meshes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        data = properties.template_of(context).moulage
        write(layout, context, "Vessels inside, a finer version: they move with the template.")
        if data.carried:
            row = layout.row()
            row.template_list("MOULAGE_UL_carried", "", data, "carried", data, "active_carried", rows=2)
            row.operator("moulage.remove_carried", text="", icon="REMOVE")
        layout.operator("moulage.add_carried", icon="ADD")


class MOULAGE_UL_carried(bpy.types.UIList):
    def draw_item(self, _context, layout, _data, item, _icon, _active, _property):
        layout.prop(item, "object", text="", emboss=False)


class MOULAGE_PT_result(NeedsTemplate, bpy.types.Panel):
    bl_label = "Result"

    def draw(self, context):
        layout = self.layout
        template = properties.template_of(context)
        data, kept = template.moulage, template.moulage.result
        keys = template.data.shape_keys
        key = keys.key_blocks.get(kept.key) if keys and kept.key else None
        if key is None:
            write(layout, context, "No result yet: reshape first.", "INFO")
            return
        layout.prop(key, "value", text="Template to Person", slider=True)
        write(layout, context, kept.ending)
        self._figures(context, layout, kept)
        if kept.warnings:
            write(layout, context, kept.warnings, "ERROR")
        grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
        for kind, label in (("NONE", "Plain"), ("DISTANCE", "Distance"), ("STRETCH", "Stretch"), ("SURE", "How Sure")):
            grid.operator("moulage.show_heat_map", text=label, depress=data.heat == kind).kind = kind
        if data.heat != "NONE":
            layout.prop(data, heat_map.LIMITS[data.heat])
        layout.operator("moulage.copy_result", icon="DUPLICATE")
        row = layout.row()
        row.prop(context.window_manager.moulage, "live_edit", toggle=True, icon="MOD_SIMPLEDEFORM")

    def _figures(self, context, layout, kept):
        column = layout.column(align=True)
        column.scale_y = 0.8
        if kept.mean_distance >= 0:
            mean, largest = units.texts(context.scene, kept.mean_distance, kept.max_distance)
            column.label(text=f"Markers: mean {mean},")
            column.label(text=f"largest {largest}")
            if kept.mean_before >= 0:
                column.label(text=f"before editing {units.text(context.scene, kept.mean_before)}")
        volume, deviation = kept.volume
        if volume >= 0:
            column.label(text=f"Volume {units.volume(context.scene, volume)},")
            column.label(text=f"sd {units.volume(context.scene, deviation)}")
        column.label(text=f"{kept.iterations} step{'s' if kept.iterations != 1 else ''}, {kept.seconds:.0f} s")
        if kept.inverted_tets:
            column.label(text=f"{kept.inverted_tets} inverted tets: folded there", icon="ERROR")


classes = (
    MOULAGE_UL_landmarks, MOULAGE_UL_carried, MOULAGE_PT_template, MOULAGE_PT_scan, MOULAGE_PT_labels, MOULAGE_PT_markers, MOULAGE_PT_landmarks,
    MOULAGE_PT_attachments, MOULAGE_PT_carried, MOULAGE_PT_reshape, MOULAGE_PT_tets, MOULAGE_PT_result,
)
