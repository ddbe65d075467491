# SPDX-License-Identifier: GPL-3.0-or-later
"""The 3D views of all windows."""

import bpy


def spaces(context):
    """Each 3D view once, with its window and area."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                yield window, area, area.spaces.active


def reach_far(context):
    """Lets the views show what is measured in millimetres."""
    for _window, _area, space in spaces(context):
        space.clip_start, space.clip_end = max(space.clip_start, 0.1), max(space.clip_end, 100_000.0)


def show(context, objects, shown):
    """Shows objects or hides them, in the 3D views."""
    for ob in objects:
        if ob.name in context.view_layer.objects:
            ob.hide_set(not shown)


def select_only(context, ob):
    """Selects an object alone and makes it the active one, in Object Mode; a hidden one is shown."""
    if context.mode != "OBJECT":
        return
    for other in context.selected_objects:
        other.select_set(False)
    show(context, [ob], True)
    ob.select_set(True)
    context.view_layer.objects.active = ob


def frame_selected(context):
    """Brings what is selected into view."""
    for window, area, _space in spaces(context):
        region = next(region for region in area.regions if region.type == "WINDOW")
        with context.temp_override(window=window, area=area, region=region):
            bpy.ops.view3d.view_selected()
