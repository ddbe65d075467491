# SPDX-License-Identifier: GPL-3.0-or-later
"""The scan: an image volume shown as slices, which are empties with an image. Scans are in millimetres."""

import os

import bpy
import mathutils
import numpy

from . import library
from .library import Wrong, calls

COLLECTION = "Scan"
# Of image volumes; a file of a DICOM series may have none.
ENDINGS = (".nii", ".gz", ".nrrd", ".nhdr", ".mha", ".mhd", ".dcm", ".ima")
# Axis along which each view is looked, in RAS.
AXES = {"AXIAL": (0, 0, 1), "CORONAL": (0, 1, 0), "SAGITTAL": (1, 0, 0)}
VIEWS = (*AXES, "OBLIQUE")
# Width and level, in Hounsfield units for the CT ones.
PRESETS = {
    "SOFT": ("Soft Tissue", 400, 40), "BONE": ("Bone", 2000, 400), "LUNG": ("Lung", 1500, -600),
    "LIVER": ("Liver", 150, 60),
}

# The volume read last: its file's path and time, itself, and its info.
_loaded = {}
# The label map read last, in the same way.
_labels = {}
# Where each slice's empty was when it was drawn, by the empty's name.
_drawn = {}


def unit(scene):
    """Length in the scene of one millimetre."""
    return 0.001 / scene.unit_settings.scale_length


def missing(scene):
    """What is to be done if the scan's file is not there, else None."""
    path = bpy.path.abspath(scene.moulage.scan)
    if not path:
        return "Load a scan first."
    return None if os.path.exists(path) else f"The scan {path} is not there any more: load it from where it is now."


def volume(scene):
    """The scene's volume and its info, read once; Wrong if it cannot be."""
    if missing(scene):
        raise Wrong(missing(scene))
    path = bpy.path.abspath(scene.moulage.scan)
    stamp = (path, os.path.getmtime(path))
    if _loaded.get("stamp") != stamp:
        with calls() as package:
            read = package.Volume(path)
            _loaded.update(stamp=stamp, volume=read, info=read.info)
    return _loaded["volume"], _loaded["info"]


def label_map(scene):
    """The label map of the panel and its labels, read once; Wrong if it cannot be."""
    path = bpy.path.abspath(scene.moulage.label_map)
    if not path or not os.path.exists(path):
        raise Wrong("Choose the file of the label map first." if not path else f"There is no {path}.")
    stamp = (path, os.path.getmtime(path))
    if _labels.get("stamp") != stamp:
        with calls() as package:
            read = package.Volume(path)
            _labels.update(stamp=stamp, volume=read, labels=read.labels, names=read.label_names)
    return _labels["volume"], _labels["labels"]


def label_name(label):
    """What the label map that was read last calls a label, such as "Liver (5)"."""
    name = _labels.get("names", {}).get(label)
    return f"{name.replace('_', ' ').capitalize()} ({label})" if name else f"Label {label}"


def forget():
    _loaded.clear()
    _labels.clear()
    _drawn.clear()


def slices(scene):
    """The slices' empties that are there, by view."""
    collection = scene.collection.children.get(COLLECTION)
    found = collection.objects if collection is not None else ()
    return {ob.moulage_slice: ob for ob in found if ob.moulage_slice}


def make_slices(context):
    """Makes the empties that are missing, and puts all in the middle of the scan."""
    scene = context.scene
    _read, info = volume(scene)
    collection = scene.collection.children.get(COLLECTION)
    if collection is None:
        collection = bpy.data.collections.new(COLLECTION)
        scene.collection.children.link(collection)
    there = slices(scene)
    for view in VIEWS:
        if view not in there:
            empty = bpy.data.objects.new(view.capitalize(), None)
            empty.empty_display_type = "IMAGE"
            empty.use_empty_image_alpha = True
            empty.moulage_slice = view
            collection.objects.link(empty)
            empty.hide_viewport = view == "OBLIQUE"
    middle = (info["box_low"] + info["box_high"]) / 2
    slices(scene)["OBLIQUE"].matrix_world = mathutils.Matrix.Translation(mathutils.Vector(middle * unit(scene)))
    for view, axis in AXES.items():
        # Setting a slider draws its slice.
        setattr(scene.moulage, _slider(view), float(numpy.dot(axis, middle)))
    draw(context, "OBLIQUE")


def _slider(view):
    return view.lower()


def follow_unit(context, before):
    """After a change of the scene's unit, which was `before` metres: the slices lie where they are on the person."""
    oblique = slices(context.scene).get("OBLIQUE")
    if oblique is not None:
        oblique.location *= before / context.scene.unit_settings.scale_length
    draw_all(context)


def draw_all(context):
    for view in slices(context.scene):
        draw(context, view)


def draw(context, view):
    """Draws one slice where its slider, or for the oblique one its empty, is."""
    scene = context.scene
    empty = slices(scene).get(view)
    if empty is None or empty.hide_viewport:
        return
    read, info = volume(scene)
    with calls():
        if view in AXES:
            plane = read.plane(AXES[view], getattr(scene.moulage, _slider(view)))
            _place(scene, empty, plane)
        else:
            plane = _plane_of(scene, empty, info)
        pixels = read.slice(plane, (scene.moulage.window_width, scene.moulage.window_level))
    _show(empty, plane, pixels, scene)
    _drawn[empty.name] = empty.matrix_world.copy()


def _place(scene, empty, plane):
    right, up = plane.right / numpy.linalg.norm(plane.right), -plane.down / numpy.linalg.norm(plane.down)
    frame = numpy.eye(4)
    frame[:3, 0], frame[:3, 1], frame[:3, 2] = right, up, numpy.cross(right, up)
    frame[:3, 3] = plane.centre * unit(scene)
    empty.matrix_world = mathutils.Matrix(frame.tolist())


def _plane_of(scene, empty, info):
    """The plane of an empty that was moved and turned by hand, as large as the scan's diagonal."""
    pixel = float(info["spacing"].min())
    count = int(numpy.linalg.norm(info["box_high"] - info["box_low"]) / pixel) + 1
    frame = numpy.array(empty.matrix_world.normalized())
    right, down = frame[:3, 0] * pixel, -frame[:3, 1] * pixel
    corner = frame[:3, 3] / unit(scene) - (right + down) * (count - 1) / 2
    return library.moulage().Plane(corner, right, down, count, count)


def _show(empty, plane, pixels, scene):
    image = empty.data
    if image is None or tuple(image.size) != (plane.width, plane.height):
        if image is not None:
            bpy.data.images.remove(image)
        image = bpy.data.images.new(f"Slice {empty.name}", plane.width, plane.height, alpha=True)
        empty.data = image
    # Blender's rows begin at the bottom.
    image.pixels.foreach_set((pixels[::-1].astype(numpy.float32) / 255.0).ravel())
    image.update()
    pixel = float(numpy.linalg.norm(plane.right)) * unit(scene)
    empty.empty_display_size = max(plane.width, plane.height) * pixel
    empty.empty_image_offset = (-0.5, -0.5)
    empty.color[3] = scene.moulage.scan_opacity


def follow(context):
    """Redraws slices that were moved or shown again; for the handler after each change of the scene."""
    scene = context.scene
    for view, empty in slices(scene).items():
        if empty.hide_viewport:
            _drawn.pop(empty.name, None)
        elif empty.name not in _drawn:
            draw(context, view)
        elif _moved(scene, empty):
            if view in AXES:
                axis = mathutils.Vector(AXES[view])
                # The slider puts the empty back into its plane and draws it.
                setattr(scene.moulage, _slider(view), axis.dot(empty.matrix_world.translation) / unit(scene))
            else:
                draw(context, view)


def _moved(scene, empty):
    change = numpy.abs(numpy.array(_drawn[empty.name]) - numpy.array(empty.matrix_world)).max()
    # A thousandth of a millimetre; less is rounding.
    return change > 1e-3 * unit(scene)


def hit(context, origin, direction):
    """Where a ray first meets a visible slice, or None."""
    best, nearest = None, float("inf")
    for empty in slices(context.scene).values():
        if empty.hide_viewport or not empty.visible_get() or empty.data is None:
            continue
        inverse = empty.matrix_world.inverted_safe()
        start = inverse @ origin
        along = (inverse @ (origin + direction)) - start
        if abs(along.z) < 1e-9:
            continue
        time = -start.z / along.z
        place = start + time * along
        width, height = empty.data.size
        pixel = empty.empty_display_size / max(width, height)
        inside = abs(place.x) <= width * pixel / 2 and abs(place.y) <= height * pixel / 2
        if time > 0 and inside and time < nearest:
            best, nearest = empty.matrix_world @ place, time
    return best
