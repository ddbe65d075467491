# SPDX-License-Identifier: GPL-3.0-or-later
"""Moulage: puts a template organ or bone into one person's shape, in Blender."""

bl_info = {
    "name": "Moulage",
    "author": "The moulage authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Moulage",
    "description": "Put a template organ or bone into one person's shape",
    "category": "Mesh",
}

import bpy
from bpy.app.handlers import persistent

from . import menu, operators, overlay, panels, preferences, properties, solve

_classes = (*preferences.classes, *properties.classes, *operators.classes, *panels.classes, *menu.classes)


@persistent
def _before_another_file(*_arguments):
    solve.shut_down()


def register():
    for cls in _classes:
        bpy.utils.register_class(cls)
    properties.register()
    menu.register()
    bpy.app.handlers.load_pre.append(_before_another_file)
    if not bpy.app.background:
        overlay.register()


def unregister():
    solve.shut_down()
    overlay.unregister()
    bpy.app.handlers.load_pre.remove(_before_another_file)
    menu.unregister()
    properties.unregister()
    for cls in reversed(_classes):
        bpy.utils.unregister_class(cls)
