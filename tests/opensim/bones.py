"""The bones of leg.osim, which are made here."""

from pathlib import Path

import numpy as np

# Centre and half lengths of each mesh file, metres; y is up, x forward, z right. The model halves the sacrum.
SIZES = {
    "half": ((0.0, 0.0, 0.07), (0.06, 0.1, 0.05)),
    "sacrum": ((-0.14, 0.06, 0.0), (0.04, 0.12, 0.08)),
    "femur": ((0.0, -0.2, 0.0), (0.03, 0.22, 0.04)),
    "tibia": ((0.0, -0.19, 0.0), (0.035, 0.2, 0.03)),
    "fibula": ((-0.01, -0.2, 0.06), (0.012, 0.19, 0.01)),
    "patella": ((0.0, 0.0, 0.0), (0.012, 0.025, 0.02)),
    "foot": ((0.06, -0.03, 0.0), (0.12, 0.03, 0.04)),
}


def egg(centre, half):
    """An egg with a knob, so that it has neither a symmetry nor a flat side: vertices and triangles."""
    rows, columns = 16, 20
    vertices = [(0.0, 1.0, 0.0)]
    for i in range(1, rows):
        for j in range(columns):
            u, v = np.pi * i / rows, 2 * np.pi * j / columns
            vertices.append((np.sin(u) * np.cos(v), np.cos(u), np.sin(u) * np.sin(v)))
    vertices.append((0.0, -1.0, 0.0))
    ring = [[1 + i * columns + j for j in range(columns)] for i in range(rows - 1)]
    last = len(vertices) - 1
    triangles = []
    for j in range(columns):
        k = (j + 1) % columns
        triangles += [(0, ring[0][k], ring[0][j]), (last, ring[-1][j], ring[-1][k])]
        for above, below in zip(ring, ring[1:]):
            triangles += [(above[j], above[k], below[j]), (above[k], below[k], below[j])]
    p = np.array(vertices)
    p[:, 0] *= 1 + 0.25 * p[:, 1]
    knob = np.sum((p - np.array([0.6, 0.7, 0.3])) ** 2, axis=1)
    p *= 1 + 0.3 * np.exp(-8 * knob)[:, None]
    return np.asarray(centre) + p * np.asarray(half), np.array(triangles)


def write_obj(path, vertices, triangles):
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w") as out:
        out.writelines("v %.9f %.9f %.9f\n" % tuple(v) for v in vertices)
        out.writelines("f %d %d %d\n" % tuple(t + 1) for t in triangles)


def read_obj(path):
    """Vertices and triangles."""
    vertices, triangles = [], []
    for line in open(path):
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(x) for x in words[1:4]])
        elif words[:1] == ["f"]:
            triangles.append([int(word.split("/")[0]) - 1 for word in words[1:4]])
    return np.array(vertices), np.array(triangles)


def write_geometry(folder):
    for name, (centre, half) in SIZES.items():
        write_obj(Path(folder) / f"{name}.obj", *egg(centre, half))
