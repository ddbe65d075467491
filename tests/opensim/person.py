"""A small OpenSim model goes to a skeleton, the skeleton to a person, the person back into the model, and OpenSim
looks at it. Folder of scratch files: the first argument."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import opensim as osim

import bones
from check import check

PROGRAM = os.environ["MOULAGE_PROGRAM"]
HERE = Path(__file__).parent
BELOW_KNEE = ["tibia", "patella", "foot"]


def moulage(*words, folder):
    run = subprocess.run([PROGRAM, *map(str, words)], cwd=folder, capture_output=True, text=True)
    assert run.returncode == 0, f"moulage {words}: {run.returncode}\n{run.stdout}{run.stderr}"
    return run.stdout + run.stderr


def knee_bent(points, centre, axis, angle):
    axis = axis / np.linalg.norm(axis)
    p = points - centre
    turned = p * np.cos(angle) + np.cross(axis, p) * np.sin(angle)
    return turned + np.outer(p @ axis, axis) * (1 - np.cos(angle)) + centre


def larger(points):
    """Another size along each axis."""
    return points * np.array([1.12, 1.06, 0.95])


def frame(entry):
    """Origin and third axis of a joint's frame."""
    w, x, y, z = entry["q"]
    third = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    return np.array(entry["t"]), third


def make_person(folder, skeleton, bend, to):
    """A surface per bone of a person whose knee is bent by an angle more than the template's."""
    document = json.loads(skeleton.read_text())
    knee = next(joint for joint in document["joints"] if joint["name"] == "knee")
    centre, axis = frame(knee["parent_frame"])
    for bone in document["bones"]:
        points, triangles = bones.read_obj(folder / bone["mesh"])
        points = larger(points)
        if bone["name"] in BELOW_KNEE:
            points = knee_bent(points, larger(centre[None])[0], axis, bend)
        bones.write_obj(to / f"{bone['name']}.obj", points, triangles)


def write_walk(path):
    """Two seconds of something like a walk."""
    times = np.linspace(0, 2, 41)
    swing = np.sin(np.pi * times)
    columns = {
        "pelvis_tilt": 3 * swing,
        "pelvis_tx": times,
        "pelvis_ty": 0.95 + 0.02 * swing,
        "hip_flexion": 10 + 25 * swing,
        "hip_adduction": 4 * swing,
        "knee_angle": -35 - 30 * np.cos(np.pi * times),
    }
    with path.open("w") as out:
        print("walk\nversion=1\ninDegrees=yes\nendheader", file=out)
        print("time\t" + "\t".join(columns), file=out)
        for row in zip(times, *columns.values()):
            print("\t".join(f"{x:.9f}" for x in row), file=out)


def default_of(path, coordinate):
    model = osim.Model(str(path))
    return model.getCoordinateSet().get(coordinate).getDefaultValue()


def main(folder):
    osim.Logger.setLevelString("warn")
    shutil.copy(HERE / "leg.osim", folder / "leg.osim")
    shutil.copy(HERE / "leg.osim", folder / "second.osim")
    bones.write_geometry(folder / "Geometry")
    moulage("convert", "leg.osim", "leg.skeleton.json", folder=folder)
    moulage("convert", "second.osim", "second.skeleton.json", folder=folder)
    own = [json.loads((folder / f"{name}.skeleton.json").read_text()) for name in ("leg", "second")]
    files = [{bone["mesh"] for bone in document["bones"]} for document in own]
    assert not files[0] & files[1], "two models in one folder share their bones"
    write_walk(folder / "walk.mot")
    cases = {"bent": -0.5, "overstretched": 0.35}
    for name, bend in cases.items():
        make_person(folder, folder / "leg.skeleton.json", bend, folder / name)
        words = ["--labels", name, "--limits", "soft", "-o", f"{name}_result"]
        moulage("register", "leg.skeleton.json", *words, folder=folder)
        result = folder / f"{name}_result" / "result.skeleton.json"
        words = [result, f"{name}.osim", "--model", "leg.osim", "--mass", 71.5]
        said = moulage("convert", *words, folder=folder)
        check(folder / "leg.osim", result, folder / f"{name}.osim", 71.5, folder / "walk.mot")
        knee = default_of(folder / f"{name}.osim", "knee_angle")
        wanted = min(-0.2 + bend, 0.0)
        print(f"{name}: the knee is at {knee:.3f} instead of {wanted:.3f}")
        assert abs(knee - wanted) < 0.05
        assert ("coordinate knee_angle: the person lies" in said) == (-0.2 + bend > 0.0), said
        print(f"{name}: good")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
