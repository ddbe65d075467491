"""Shapes, layers, files and the command line, for the tests of the filters."""

import os
import subprocess
import sys

import numpy as np
import pymeshlab

PLUGIN, WORK, CLI = sys.argv[1:]
OUT = os.path.join(WORK, "out")
os.makedirs(OUT, exist_ok=True)
RIGID = np.array([[0, -1, 0, 5], [1, 0, 0, -2], [0, 0, 1, 3], [0, 0, 0, 1.0]])

pymeshlab.load_plugin(PLUGIN)


def sphere(radii=(1, 1, 1), rings=12, sides=16):
    """Points and outward triangles of an ellipsoid."""
    polar = np.pi * np.arange(1, rings) / rings
    turn = 2 * np.pi * np.arange(sides) / sides
    p, t = np.meshgrid(polar, turn, indexing="ij")
    ring = np.stack([np.sin(p) * np.cos(t), np.sin(p) * np.sin(t), np.cos(p)], -1).reshape(-1, 3)
    points = np.vstack([[0, 0, 1], ring, [0, 0, -1]]) * radii
    at = lambda r, s: 1 + (r - 1) * sides + s % sides
    faces = []
    for s in range(sides):
        faces.append([0, at(1, s), at(1, s + 1)])
        for r in range(1, rings - 1):
            faces.append([at(r, s), at(r + 1, s), at(r + 1, s + 1)])
            faces.append([at(r, s), at(r + 1, s + 1), at(r, s + 1)])
        faces.append([len(points) - 1, at(rings - 1, s + 1), at(rings - 1, s)])
    return points, np.array(faces, dtype=np.int32)


def block(centre, half, n=9):
    """A box whose faces are grids."""
    points, faces = [], []
    line = np.linspace(-1, 1, n)
    for axis in range(3):
        for side in (1, -1):
            first = len(points)
            for a in line:
                for b in line:
                    p = np.zeros(3)
                    p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = side, side * a, b
                    points.append(p * half + centre)
            for i in range(n - 1):
                for j in range(n - 1):
                    a = first + i * n + j
                    faces += [[a, a + n, a + n + 1], [a, a + n + 1, a + 1]]
    return np.array(points), np.array(faces, dtype=np.int32)


def add(ms, points, faces=None, label="", **more):
    mesh = pymeshlab.Mesh(points) if faces is None else pymeshlab.Mesh(points, faces, **more)
    ms.add_mesh(mesh, label)
    return ms.current_mesh_id()


def save_ply(path, points, faces=None):
    """Text with all digits, for the command line."""
    with open(path, "w") as f:
        f.write(f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n")
        f.write("property double x\nproperty double y\nproperty double z\n")
        if faces is not None:
            f.write(f"element face {len(faces)}\nproperty list uchar int vertex_indices\n")
        f.write("end_header\n")
        f.writelines(" ".join(repr(float(c)) for c in p) + "\n" for p in points)
        if faces is not None:
            f.writelines("3 " + " ".join(map(str, t)) + "\n" for t in faces)
    return path


def vertices_of(path):
    ms = pymeshlab.MeshSet()
    ms.load_new_mesh(path)
    return ms.current_mesh().vertex_matrix()


def cli(*arguments):
    subprocess.run([CLI, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)


def fails(words, action):
    try:
        action()
    except pymeshlab.PyMeshLabException as error:
        assert words in str(error), f"{words!r} is not in: {error}"
    else:
        raise AssertionError(f"no error with: {words}")


def error_of(ms, filter_name, words, **parameters):
    """The filter must fail with these words and leave the current layer as it was."""
    before = ms.current_mesh().vertex_matrix()
    fails(words, lambda: ms.apply_filter(filter_name, **parameters))
    assert np.array_equal(before, ms.current_mesh().vertex_matrix())
