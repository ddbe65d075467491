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

from . import (
    live_edit, menu, once, operators, overlay, panels, preferences, properties, runs, scan, separate_panels,
    separate_properties, skeleton_panels, skeleton_properties, solve,
)
from .library import Wrong

_classes = (
    *preferences.classes, *skeleton_properties.classes, *properties.classes, *separate_properties.classes,
    *operators.classes, *panels.classes, *skeleton_panels.classes, *separate_panels.classes, *menu.classes,
)


@persistent
def _before_another_file(*_arguments):
    live_edit.shut_down()
    runs.shut_down()
    solve.forget()
    scan.forget()


@persistent
def _draw_slices(*_arguments):
    """After a file was opened and after undo: images made here are not kept in either."""
    try:
        scan.draw_all(bpy.context)
    except Wrong:
        # The panel says it.
        pass


@persistent
def _after_undo(*_arguments):
    live_edit.after_undo(bpy.context)


@persistent
def _after_loading(*_arguments):
    # What live editing goes on from is not kept in files: it is found once more when it is switched on.
    bpy.context.window_manager.moulage.live_edit = False


@persistent
def _follow_slices(*_arguments):
    try:
        scan.follow(bpy.context)
    except Wrong:
        pass


_handlers = (
    *((name, once.forget) for name in ("load_post", "undo_post", "redo_post", "depsgraph_update_post", "frame_change_post")),
    ("load_pre", _before_another_file), ("load_post", _draw_slices), ("load_post", _after_loading),
    ("undo_post", _draw_slices), ("undo_post", _after_undo),
    ("redo_post", _draw_slices), ("redo_post", _after_undo), ("depsgraph_update_post", _follow_slices),
)


def register():
    for cls in _classes:
        bpy.utils.register_class(cls)
    skeleton_properties.register()
    properties.register()
    separate_properties.register()
    menu.register()
    for name, handler in _handlers:
        getattr(bpy.app.handlers, name).append(handler)
    if not bpy.app.background:
        overlay.register()


def unregister():
    live_edit.shut_down()
    runs.shut_down()
    solve.forget()
    overlay.unregister()
    once.forget()
    for name, handler in _handlers:
        getattr(bpy.app.handlers, name).remove(handler)
    scan.forget()
    menu.unregister()
    separate_properties.unregister()
    properties.unregister()
    skeleton_properties.unregister()
    for cls in reversed(_classes):
        bpy.utils.unregister_class(cls)
