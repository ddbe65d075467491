"""What other open tools make of the same points: as-rigid-as-possible (libigl), a thin-plate spline
(scipy), nricp_sumner (trimesh), each in rounds of closest points.

    pip install numpy scipy trimesh rtree libigl
    python benches/peers.py TEMPLATE.obj MARKERS.csv TRUE_SURFACE.ply [RESULT.obj [FIXED.csv]]

RESULT.obj is a result of `moulage reshape` on the same input; FIXED.csv lists vertices that stay. One line a tool: mean/95 %/largest
distance of the markers, then of 6,000 points of the true surface, to the result; new folds; seconds.
"""
import csv
import sys
import time

import igl
import numpy as np
import trimesh
from scipy.interpolate import RBFInterpolator
from trimesh.proximity import closest_point

ROUNDS = 8


def read_obj(path):
    points, faces = [], []
    for line in open(path, errors="replace"):
        word = line.split()
        if word[:1] == ["v"]:
            points.append([float(c) for c in word[1:4]])
        elif word[:1] == ["f"]:
            corners = [int(c.split("/")[0]) - 1 for c in word[1:]]
            faces += [[corners[0], corners[i], corners[i + 1]] for i in range(1, len(corners) - 1)]
    return np.array(points), np.array(faces)


def rows(path):
    return list(csv.DictReader(line for line in open(path) if not line.startswith("#")))


def read_markers(path):
    table = rows(path)
    keys = ["x_mm", "y_mm", "z_mm"] if "x_mm" in table[0] else ["x", "y", "z"]
    return np.array([[float(row[key]) for key in keys] for row in table])


def contacts(points, faces, markers):
    """Triangle, barycentric coordinates and position of the closest point of each marker."""
    mesh = trimesh.Trimesh(points, faces, process=False)
    near, _, triangle = closest_point(mesh, markers)
    return triangle, trimesh.triangles.points_to_barycentric(points[faces[triangle]], near), near


def arap(points, faces, markers, fixed):
    """Vertices nearest to the contacts are the handles."""
    shape = points
    for _ in range(ROUNDS):
        triangle, weights, near = contacts(shape, faces, markers)
        nearest = faces[triangle, weights.argmax(1)]
        handles, first = np.unique(np.append(fixed, nearest), return_index=True)
        goals = np.vstack([points[fixed], shape[nearest] + markers - near])[first]
        data = igl.ARAPData()
        data.max_iter = 100
        igl.arap_precomputation(points, faces, 3, handles.astype(np.int32), data)
        shape = igl.arap_solve(goals, data, shape)
    return shape


def thin_plate(points, faces, markers, fixed):
    shape = points
    for _ in range(ROUNDS):
        triangle, weights, _ = contacts(shape, faces, markers)
        start = np.vstack([points[fixed], (weights[:, :, None] * points[faces[triangle]]).sum(1)])
        goals = np.vstack([points[fixed], markers])
        _, first = np.unique(start.round(6), axis=0, return_index=True)
        shape = RBFInterpolator(start[first], goals[first], smoothing=1.0)(points)
    return shape


def sumner(points, faces, markers, fixed):
    shape = points
    goals = np.vstack([points[fixed], markers])
    cloud = trimesh.PointCloud(goals)
    corner = {vertex: (f, k) for f, face in enumerate(faces) for k, vertex in enumerate(face)}
    fixed_at = np.array([corner[v] for v in fixed], dtype=int).reshape(-1, 2)
    source = trimesh.Trimesh(points, faces, process=False)
    for _ in range(ROUNDS):
        triangle, weights, _ = contacts(shape, faces, markers)
        landmarks = (
            np.append(fixed_at[:, 0], triangle),
            np.vstack([np.eye(3)[fixed_at[:, 1]], weights]),
        )
        shape = trimesh.registration.nricp_sumner(
            source, cloud, source_landmarks=landmarks, target_positions=goals,
            steps=[[0, 0.001, 1, 1000, 0]],
        )
    return np.asarray(shape)


def folds(points, faces):
    mesh = trimesh.Trimesh(points, faces, process=False)
    pairs = mesh.face_normals[mesh.face_adjacency]
    return int((np.einsum("ij,ij->i", pairs[:, 0], pairs[:, 1]) < -0.5).sum())


def spread(distances):
    return f"{distances.mean():.3f}/{np.percentile(distances, 95):.2f}/{distances.max():.2f}"


def main(template, markers, truth, result=None, fixed=None):
    points, faces = read_obj(template)
    markers = read_markers(markers)
    fixed = [int(row["vertex"]) for row in rows(fixed)] if fixed else []
    fixed = np.array(fixed, dtype=int)
    samples = trimesh.sample.sample_surface(trimesh.load(truth, process=False), 6000, seed=1)[0]

    def report(name, shape, seconds):
        mesh = trimesh.Trimesh(shape, faces, process=False)
        to = [spread(closest_point(mesh, p)[1]) for p in (markers, samples)]
        new = folds(shape, faces) - folds(points, faces)
        print(f"{name}: markers {to[0]}, truth {to[1]}, {new} new folds, {seconds:.1f} s", flush=True)

    report("template", points, 0)
    for name, tool in [("arap", arap), ("thin plate", thin_plate), ("sumner", sumner)]:
        start = time.process_time()
        shape = tool(points, faces, markers, fixed)
        report(name, shape, time.process_time() - start)
    if result:
        report("moulage", read_obj(result)[0], 0)


if __name__ == "__main__":
    main(*sys.argv[1:])
