"""Wall seconds of `moulage reshape` at about 10,000 tets and of trimesh's nricp_sumner on the same points, one after the other; the
fastest of three each, with the distance of 6,000 points of the true surface to the result.

    cargo build --release; pip install numpy scipy trimesh rtree libigl
    python benches/race.py FOLDER...

A folder holds template.obj, markers.csv and target_surface.ply, and may hold landmarks.csv, attachments.csv, fixed.csv.
"""
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import trimesh
from peers import closest_point, read_markers, read_obj, rows, spread, sumner

ROUNDS = 3
PROGRAM = Path(__file__).parent.parent / "target/release/moulage"


def fastest(work):
    seconds = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        shape = work()
        seconds.append(time.perf_counter() - start)
    return min(seconds), shape


def race(folder):
    points, faces = read_obj(folder / "template.obj")
    markers = read_markers(folder / "markers.csv")
    fixed = folder / "fixed.csv"
    fixed = np.array([int(row["vertex"]) for row in rows(fixed)] if fixed.exists() else [], dtype=int)
    truth = trimesh.load(folder / "target_surface.ply", process=False)
    samples = trimesh.sample.sample_surface(truth, 6000, seed=1)[0]
    with tempfile.TemporaryDirectory() as out:
        result = Path(out) / "result.obj"
        command = [PROGRAM, "reshape", "--template", folder / "template.obj", "--tets", "tetgen"]
        command += ["--tet-count", "10000", "--tolerance", "0.3", "--out", result]
        for kind in ["markers", "landmarks", "attachments", "fixed"]:
            if (folder / f"{kind}.csv").exists():
                command += [f"--{kind}", folder / f"{kind}.csv"]

        def ours():
            subprocess.run(command, check=True, capture_output=True)
            return read_obj(result)[0]

        for name, work in [("moulage", ours), ("sumner", lambda: sumner(points, faces, markers, fixed))]:
            seconds, shape = fastest(work)
            distances = closest_point(trimesh.Trimesh(shape, faces, process=False), samples)[1]
            print(f"{folder.name}, {name}: {seconds:.1f} s, truth {spread(distances)}", flush=True)


for argument in sys.argv[1:]:
    race(Path(argument))
