#!/usr/bin/env python3
"""How good standard deviations are on cases of known truth (docs/uncertainty.md).

    pip install numpy scipy
    PYTHONPATH=python python benches/uncertainty.py CASES [MARKERS...]

CASES holds a folder for each case: template.obj; target_surface.ply, whose vertex i is where the template's vertex i belongs; markers_N.csv for each number N of markers;
landmarks.csv; case.json with `tolerance_mm`. Printed for each: the share of vertices inside the 95 % band (the error across the surface, the distance to
the true surface), Spearman's rank correlation of the standard deviation with both, and of `sd` with the distance to the true place, the share of the run's time.
"""

import json
import sys
import time
from pathlib import Path

import numpy
from scipy.stats import spearmanr

import moulage


def normals_of(points, triangles):
    corners = points[triangles]
    areas = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = numpy.zeros_like(points)
    for k in range(3):
        numpy.add.at(sums, triangles[:, k], areas)
    return sums / numpy.maximum(numpy.linalg.norm(sums, axis=1, keepdims=True), 1e-300)


def figures(case, markers):
    template, truth = moulage.TriMesh.load(case / "template.obj"), moulage.TriMesh.load(case / "target_surface.ply")
    began = time.perf_counter()
    problem = moulage.Reshaping(moulage.Tetrahedralization(template))
    problem.set_markers(moulage.Markers.load(case / f"markers_{markers}.csv"))
    problem.set_landmarks(moulage.Pairs.load_landmarks(template, case / "landmarks.csv"))
    result = problem.run(moulage.ReshapingOptions(tolerance=json.loads((case / "case.json").read_text())["tolerance_mm"]))
    reshaped = time.perf_counter()
    sure = result.uncertainty()
    share = (time.perf_counter() - reshaped) / (reshaped - began)
    off = result.points - truth.points
    across = abs((off * normals_of(result.points, template.triangles)).sum(axis=1))
    surface, place = truth.distances_of(result.points), numpy.linalg.norm(off, axis=1)
    band = 1.96 * sure.sd_normal
    return [
        (across < band).mean(), (surface < band).mean(), spearmanr(sure.sd_normal, across)[0],
        spearmanr(sure.sd_normal, surface)[0], spearmanr(sure.sd, place)[0], share,
    ]


def main():
    cases = sorted(path.parent for path in Path(sys.argv[1]).glob("*/case.json"))
    print("case              markers  inside: across surface  rank: across surface place  time")
    for markers in map(int, sys.argv[2:] or (40, 150)):
        rows = []
        for case in cases:
            rows.append(figures(case, markers))
            print(f"{case.name:20}{markers:5}", *(f"{value:8.3f}" for value in rows[-1]), flush=True)
        print(f"{'mean':20}{markers:5}", *(f"{value:8.3f}" for value in numpy.mean(rows, axis=0)))


main()
