# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes from files, with texture coordinates and materials, by Blender's own importers. Their numbers are taken as they
are: medical files have Z up, whatever the format usually has."""

import bpy

from .library import Wrong, refusal

ENDINGS = (".obj", ".ply", ".stl")


def is_mesh(path):
    """Whether a file holds faces; a .ply may hold points alone."""
    ending = path.suffix.lower()
    if ending != ".ply":
        return ending in ENDINGS
    with open(path, "rb") as file:
        head = file.read(4096).split(b"end_header")[0]
    counts = [line.split() for line in head.splitlines() if line.startswith(b"element face")]
    return any(int(words[2]) > 0 for words in counts if len(words) == 3)


def load(context, path, y_up=False):
    """One mesh object, selected and active. `y_up`: Y is up in the file."""
    if path.suffix.lower() not in ENDINGS:
        raise Wrong(f"{path.name} is no {', '.join(ENDINGS[:-1])} or {ENDINGS[-1]} file.")
    before = set(bpy.data.objects)
    bpy.ops.object.select_all(action="DESELECT")
    try:
        _importer(path, ("NEGATIVE_Z", "Y") if y_up else ("Y", "Z"))
    except RuntimeError as error:
        raise Wrong(f"{path.name} cannot be read: {refusal(error)}") from None
    made = [ob for ob in bpy.data.objects if ob not in before]
    meshes = [ob for ob in made if ob.type == "MESH" and len(ob.data.vertices) > 0]
    for ob in made:
        if ob not in meshes:
            bpy.data.objects.remove(ob)
    if not meshes:
        raise Wrong(f"{path.name} holds no mesh.")
    for ob in meshes:
        ob.select_set(True)
    context.view_layer.objects.active = meshes[0]
    if len(meshes) > 1:
        bpy.ops.object.join()
    meshes[0].name = meshes[0].data.name = path.name.split(".")[0]
    context.view_layer.update()
    return meshes[0]


def _importer(path, axes):
    ending = path.suffix.lower()[1:]
    name = f"{ending}_import"
    if name in dir(bpy.ops.wm):
        getattr(bpy.ops.wm, name)(filepath=str(path), forward_axis=axes[0], up_axis=axes[1])
        return
    # Before Blender 4.2; its importer of .ply leaves the axes alone.
    turned = {"axis_forward": axes[0].replace("NEGATIVE_", "-"), "axis_up": axes[1]} if ending == "stl" else {}
    getattr(bpy.ops.import_mesh, ending)(filepath=str(path), **turned)
