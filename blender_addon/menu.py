# SPDX-License-Identifier: GPL-3.0-or-later
"""A menu in the 3D view's Object menu, so that the search (F3) finds every step; File > Import and Export."""

import bpy


class MOULAGE_MT_object(bpy.types.Menu):
    bl_label = "Moulage"

    def draw(self, _context):
        layout = self.layout
        layout.operator("moulage.import_template")
        layout.operator("moulage.import_person")
        layout.operator("moulage.set_template")
        layout.operator("moulage.check_template", text="Check Template")
        layout.operator("moulage.fix_template", text="Fix Template")
        layout.operator("moulage.use_millimetres", text="Coordinates Are Millimetres")
        layout.separator()
        layout.operator("moulage.pick_landmarks", text="Click Landmark Pairs")
        layout.operator_menu_enum("moulage.look_at_slice", "view")
        layout.operator_menu_enum("moulage.scan_window", "preset", text="Window of the Scan")
        layout.operator("moulage.click_markers")
        layout.operator("moulage.markers_from_label")
        layout.operator("moulage.mirror_landmarks", text="Mirror Landmark Names")
        layout.operator("moulage.place_template")
        layout.operator("moulage.add_attachment")
        layout.operator("moulage.add_carried")
        layout.separator()
        layout.operator("moulage.tetrahedralize")
        layout.operator("moulage.reshape")
        layout.operator("moulage.stop", text="Stop the Run")
        layout.separator()
        layout.operator("moulage.register", text="Register Skeleton")
        layout.operator("moulage.add_soft_tissue", text="Carry Selected with Skeleton")
        layout.operator("moulage.separate", text="Separate Overlapping Meshes")
        layout.separator()
        layout.operator_menu_enum("moulage.show_heat_map", "kind")
        layout.operator("moulage.copy_result", text="Copy Result as New Object")


def _in_object_menu(self, _context):
    self.layout.separator()
    self.layout.menu("MOULAGE_MT_object")


def _in_import_menu(self, _context):
    self.layout.operator("moulage.import_markers", text="Moulage Markers")
    self.layout.operator("moulage.import_landmarks", text="Moulage Landmarks")
    self.layout.operator("moulage.load_scan", text="Moulage Scan")
    self.layout.operator("moulage.import_skeleton", text="Moulage Skeleton (.skeleton.json, .osim)")


def _in_export_menu(self, _context):
    self.layout.operator("moulage.export_markers", text="Moulage Markers")
    self.layout.operator("moulage.export_landmarks", text="Moulage Landmarks")
    self.layout.operator("moulage.export_skeleton", text="Moulage Skeleton (.skeleton.json, .glb)")


_PLACES = (
    ("VIEW3D_MT_object", _in_object_menu), ("TOPBAR_MT_file_import", _in_import_menu),
    ("TOPBAR_MT_file_export", _in_export_menu),
)

classes = (MOULAGE_MT_object,)


def register():
    for menu, draw in _PLACES:
        getattr(bpy.types, menu).append(draw)


def unregister():
    for menu, draw in _PLACES:
        getattr(bpy.types, menu).remove(draw)
