# SPDX-License-Identifier: GPL-3.0-or-later
"""Clicking landmark pairs in the 3D view: template, person, template, person ..."""

import bpy
import mathutils
import numpy
from bpy_extras import view3d_utils

from .. import landmarks, markers, mesh_data, properties, scan, slice_view
from .base import NeedsTemplate

# A click this near to a marker, in pixels, means the marker.
_SNAP = 25


def point_on_template(context, template, origin, direction):
    """Where a ray meets the template as it is shown, told as the place at rest in world coordinates;
    None if it misses."""
    depsgraph = context.evaluated_depsgraph_get()
    shown = template.evaluated_get(depsgraph)
    inverse = template.matrix_world.inverted_safe()
    start = inverse @ origin
    hit, place, _normal, face = shown.ray_cast(start, (inverse @ (origin + direction)) - start)
    if not hit:
        return None
    rest = mesh_data.rest_points(template.data)
    if len(shown.data.vertices) != len(rest):
        # A modifier changed the mesh: the place as it is shown is all there is.
        return template.matrix_world @ place
    corners = list(shown.data.polygons[face].vertices)
    weights = mathutils.interpolate.poly_3d_calc([shown.data.vertices[v].co for v in corners], place)
    at_rest = sum(w * rest[v].astype(numpy.float64) for w, v in zip(weights, corners))
    return template.matrix_world @ mathutils.Vector(at_rest)


def point_on_person(context, template, origin, direction):
    """Where a ray meets the first visible mesh that is not the template, or slice; None if it misses all."""
    depsgraph = context.evaluated_depsgraph_get()
    own = {item.object for item in template.moulage.carried} | {template}
    best, distance = None, float("inf")
    for ob in context.visible_objects:
        if ob.type != "MESH" or ob in own or len(ob.data.polygons) == 0:
            continue
        inverse = ob.matrix_world.inverted_safe()
        start = inverse @ origin
        hit, place, _normal, _face = ob.evaluated_get(depsgraph).ray_cast(start, (inverse @ (origin + direction)) - start)
        place = ob.matrix_world @ place
        if hit and (place - origin).length < distance:
            best, distance = place, (place - origin).length
    on_slice = scan.hit(context, origin, direction)
    if on_slice is not None and (on_slice - origin).length < distance:
        return on_slice
    return best


def nearest_marker(template, region, view, mouse):
    """The marker that is drawn nearest to the mouse, or None if none is near."""
    points = markers.points(template)
    if len(points) == 0:
        return None
    projection = numpy.array(view.perspective_matrix)
    clip = numpy.column_stack([points, numpy.ones(len(points))]) @ projection.T
    front = clip[:, 3] > 0
    screen = clip[:, :2] / numpy.where(front, clip[:, 3], 1.0)[:, None]
    pixels = (screen + 1) / 2 * (region.width, region.height)
    gaps = numpy.where(front, numpy.linalg.norm(pixels - mouse, axis=1), numpy.inf)
    nearest = int(gaps.argmin())
    return mathutils.Vector(points[nearest]) if gaps[nearest] <= _SNAP else None


class _Clicks(NeedsTemplate):
    """A modal operator that takes clicks in a 3D view until Esc; the view can be moved meanwhile."""

    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        if bpy.app.background:
            cls.poll_message_set("Needs a window")
            return False
        return super().poll(context)

    def invoke(self, context, _event):
        context.window_manager.modal_handler_add(self)
        context.window.cursor_modal_set("CROSSHAIR")
        landmarks.hide_parent_lines(context)
        self._tell(context)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        template = properties.template_of(context)
        # The release of the Enter that chose this in the search is still to come.
        asked = event.type in {"ESC", "RET"} and event.value == "PRESS"
        if asked or template is None or template.mode != "OBJECT":
            return self._end(context)
        if event.type == "LEFTMOUSE" and event.value == "PRESS":
            place = _view_under(context, event)
            if place is not None:
                area, region = place
                mouse = (event.mouse_x - region.x, event.mouse_y - region.y)
                view = area.spaces.active.region_3d
                origin = view3d_utils.region_2d_to_origin_3d(region, view, mouse)
                direction = view3d_utils.region_2d_to_vector_3d(region, view, mouse)
                if self.click(context, template, (region, view, mouse), origin, direction):
                    # Each click can be undone by itself.
                    bpy.ops.ed.undo_push(message=self.bl_label)
                self._tell(context)
                return {"RUNNING_MODAL"}
        return {"PASS_THROUGH"}

    def cancel(self, context):
        self._end(context)

    def _end(self, context):
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)
        return {"FINISHED"}

    def _tell(self, context):
        context.workspace.status_text_set(f"Click {self.what(properties.template_of(context))}.   Esc: end")
        for area in context.screen.areas:
            area.tag_redraw()


class MOULAGE_OT_pick_landmarks(_Clicks, bpy.types.Operator):
    """Click a place on the template, then the same place on the person (a mesh, a slice, or a marker); and so on.
    Esc ends"""

    bl_idname = "moulage.pick_landmarks"
    bl_label = "Click Pairs"

    def invoke(self, context, event):
        # The template is clicked as well.
        slice_view.leave(context)
        return super().invoke(context, event)

    def what(self, template):
        waiting = landmarks.incomplete(template)
        return f"the same place of the person for '{waiting.name}'" if waiting else "a place on the template"

    def click(self, context, template, screen, origin, direction):
        waiting = landmarks.incomplete(template)
        if waiting is None:
            point = point_on_template(context, template, origin, direction)
            if point is None:
                self.report({"WARNING"}, "The click missed the template.")
                return False
            landmarks.add(context, template, template_point=point)
            return True
        point = nearest_marker(template, *screen) or point_on_person(context, template, origin, direction)
        if point is None:
            self.report({"WARNING"}, "Nothing of the person is there: click a mesh, a slice or near a marker.")
            return False
        landmarks.set_target(context, template, waiting, point)
        return True


class MOULAGE_OT_click_markers(_Clicks, bpy.types.Operator):
    """Click points of the organ's outline on the slices of the scan; each becomes a marker. Esc ends"""

    bl_idname = "moulage.click_markers"
    bl_label = "Click Markers on Slices"

    @classmethod
    def poll(cls, context):
        if not scan.slices(context.scene):
            cls.poll_message_set("Load a scan first")
            return False
        return super().poll(context)

    def what(self, template):
        return f"the outline of '{template.name}' on a slice, {len(markers.points(template))} markers so far"

    def click(self, context, template, screen, origin, direction):
        point = scan.hit(context, origin, direction)
        if point is None:
            self.report({"WARNING"}, "No slice of the scan is there.")
            return False
        markers.add_point(context, template, point)
        return True


def _view_under(context, event):
    """The 3D view and its main region under the mouse, or None."""
    for area in context.screen.areas:
        if area.type != "VIEW_3D":
            continue
        inside = {"WINDOW": None}
        for region in area.regions:
            hit = region.x <= event.mouse_x < region.x + region.width
            if hit and region.y <= event.mouse_y < region.y + region.height and region.width > 1:
                inside[region.type] = region
        # Side bars lie over the main region.
        if inside["WINDOW"] is not None and not inside.keys() & {"UI", "TOOLS", "HEADER", "TOOL_HEADER"}:
            return area, inside["WINDOW"]
    return None


classes = (MOULAGE_OT_pick_landmarks, MOULAGE_OT_click_markers)
