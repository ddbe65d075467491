"""Scenes for the tests: small templates with known persons, and the liver of examples/."""

import importlib
import os
import runpy
import unittest
from pathlib import Path

import bmesh
import bpy
import numpy

ROOT = Path(__file__).resolve().parents[2]
LIVER = ROOT / "examples" / "liver"
# The add-on's module under its name in this Blender; run.py sets it.
MODULE = os.environ.get("MOULAGE_MODULE", "")
# For what asks the library, not Blender.
in_the_newest = unittest.skipIf(bpy.app.version < (5, 0, 0), "depends on no version: the newest runs it")


def part(name):
    """A module of the installed add-on, such as `solve`."""
    return importlib.import_module(f"{MODULE}.{name}")


def empty_scene():
    """An empty scene without the add-on's leftovers."""
    for ob in list(bpy.data.objects):
        if ob.type == "MESH" and ob.data.shape_keys:
            ob.shape_key_clear()
        bpy.data.objects.remove(ob)
    for collection in list(bpy.data.collections):
        bpy.data.collections.remove(collection)
    for mesh in list(bpy.data.meshes):
        bpy.data.meshes.remove(mesh)
    # Shape keys that outlive their mesh would stop the next save (Blender 4.2).
    bpy.data.orphans_purge(do_recursive=True)
    bpy.context.scene.unit_settings.scale_length = 1.0
    # A typed length has the unit that is shown.
    bpy.context.scene.unit_settings.system = "METRIC"
    bpy.context.scene.unit_settings.length_unit = "METERS"


def add_mesh(name, points, faces):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(numpy.asarray(points).tolist(), [], numpy.asarray(faces).tolist())
    mesh.update()
    ob = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(ob)
    return ob


def ball(name="ball", subdivisions=3):
    """A sphere of radius 1 with texture coordinates and a vertex group."""
    mesh = bpy.data.meshes.new(name)
    work = bmesh.new()
    bmesh.ops.create_icosphere(work, subdivisions=subdivisions, radius=1.0)
    layer = work.loops.layers.uv.new("UVMap")
    for face in work.faces:
        for loop in face.loops:
            loop[layer].uv = loop.vert.co.xy * 0.5
    work.to_mesh(mesh)
    work.free()
    ob = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(ob)
    top = ob.vertex_groups.new(name="top")
    top.add([v.index for v in mesh.vertices if v.co.z > 0.8], 1.0, "REPLACE")
    return ob


def points_of(mesh):
    flat = numpy.empty(3 * len(mesh.vertices), numpy.float32)
    mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def shape_of(ob):
    """The vertices of a result, in the object's coordinates."""
    key = ob.data.shape_keys.key_blocks[ob.moulage.result.key]
    flat = numpy.empty(3 * len(key.data), numpy.float32)
    key.data.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def egg(points):
    """The person of the ball: longer along x, flatter along z, and bent."""
    x, y, z = numpy.asarray(points, dtype=float).T
    return numpy.stack([1.3 * x + 0.1, y + 0.15 * x * x, 0.8 * z + 0.25 * x * x], axis=1)


def egg_image():
    """2 mm around the origin at 0.1 mm (z, y, x): 1000 inside the egg, 0 outside."""
    grid = numpy.linspace(-2, 2, 41)
    z, y, x = numpy.meshgrid(grid, grid, grid, indexing="ij")
    # Back from the egg to the ball.
    bx = (x - 0.1) / 1.3
    by, bz = y - 0.15 * bx * bx, (z - 0.25 * bx * bx) / 0.8
    return numpy.where(bx**2 + by**2 + bz**2 < 1, 1000, 0).astype("<i2")


def write_egg_scan(path, values=None, fields=""):
    """The egg as NRRD, with fields of one's own."""
    values = egg_image() if values is None else values.astype("<i2")
    head = (
        "NRRD0004\ntype: short\ndimension: 3\nspace: right-anterior-superior\nsizes: 41 41 41\n"
        "space directions: (0.1,0,0) (0,0.1,0) (0,0,0.1)\nspace origin: (-2,-2,-2)\nencoding: raw\n"
        f"endian: little\n{fields}\n"
    )
    path.write_bytes(head.encode() + values.tobytes())
    return path


def write_egg_dicom(folder):
    """The egg as a series of DICOM files in no order of their names, in the frame LPS."""
    for k, slice_ in enumerate(egg_image()):
        # Rows go to the back, columns to the left.
        pixels = numpy.ascontiguousarray(slice_[::-1, ::-1])
        file = b"\0" * 128 + b"DICM"
        meta = _dicom_element(2, 0x10, b"UI", b"1.2.840.10008.1.2.1")
        file += _dicom_element(2, 0, b"UL", len(meta).to_bytes(4, "little")) + meta
        short = {(0x28, 2): 1, (0x28, 0x10): 41, (0x28, 0x11): 41, (0x28, 0x100): 16, (0x28, 0x101): 16, (0x28, 0x102): 15,
                 (0x28, 0x103): 1}
        entries = [(0x20, 0x0E, b"UI", b"1.2.3"), (0x20, 0x32, b"DS", f"-2\\-2\\{-2 + 0.1 * k:.4f}".encode()),
                   (0x20, 0x37, b"DS", b"1\\0\\0\\0\\1\\0"), (0x28, 4, b"CS", b"MONOCHROME2"), (0x28, 0x30, b"DS", b"0.1\\0.1")]
        entries += [(*tag, b"US", value.to_bytes(2, "little")) for tag, value in short.items()]
        for entry in sorted(entries):
            file += _dicom_element(*entry)
        file += _dicom_element(0x7FE0, 0x10, b"OW", pixels.tobytes())
        (folder / f"{(k * 17) % 41:03d}").write_bytes(file)


def _dicom_element(group, number, kind, value):
    value += (b"\0" if kind == b"UI" else b" ") * (len(value) % 2)
    length = b"\0\0" + len(value).to_bytes(4, "little") if kind == b"OW" else len(value).to_bytes(2, "little")
    return group.to_bytes(2, "little") + number.to_bytes(2, "little") + kind + length + value


def ball_and_markers(subdivisions=3, tet_count=600, iterations=6):
    """A ball that is to become an egg, with quick settings."""
    empty_scene()
    template = ball(subdivisions=subdivisions)
    person = ball("person points", 2)
    marks = add_mesh("marks", egg(points_of(person.data)), [])
    bpy.data.objects.remove(person)
    bpy.context.scene.moulage.template = template
    data = template.moulage
    data.markers = marks
    data.method, data.tet_count, data.max_iterations = "lattice", tet_count, iterations
    return template


def run_example_script(out, max_iterations):
    """examples/blender/batch.py on the liver; returns the template."""
    script = runpy.run_path(str(ROOT / "examples" / "blender" / "batch.py"))
    script["main"](LIVER, out, max_iterations)
    return bpy.context.scene.moulage.template
