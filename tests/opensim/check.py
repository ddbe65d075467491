"""Looks at a person's model with OpenSim's own eyes: it loads, it lies as the person, its muscles can pull, and a
walk plays on it.

    check.py TEMPLATE.osim RESULT.skeleton.json PERSON.osim [--mass KG] [--motion WALK.mot] [--flip NAME...]
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

import numpy as np
import opensim as osim

from bones import read_obj

# A coordinate that inverse kinematics finds again, degrees.
FOUND_AGAIN = 0.1


class Model:
    """A model at its default pose."""

    def __init__(self, path):
        self.path = Path(path)
        self.model = osim.Model(str(path))
        self.state = self.model.initSystem()

    def body_place(self, name):
        """Rotation and origin of a body in the ground."""
        transform = self.model.getBodySet().get(name).getTransformInGround(self.state)
        rotation = transform.R().asMat33()
        rotation = np.array([[rotation.get(i, j) for j in range(3)] for i in range(3)])
        return rotation, vector(transform.p())

    def joint_centres(self):
        """Places of the joints' child frames in the ground."""
        joints = self.model.getJointSet()
        return {
            joint.getName(): vector(joint.getChildFrame().getPositionInGround(self.state))
            for joint in (joints.get(k) for k in range(joints.getSize()))
        }

    def coordinates(self):
        every = self.model.getCoordinateSet()
        return {c.getName(): c for c in (every.get(k) for k in range(every.getSize()))}

    def meshes(self):
        """The vertices of each body's meshes in the ground."""
        found = {}
        bodies = self.model.getBodySet()
        for body in (bodies.get(k) for k in range(bodies.getSize())):
            rotation, origin = self.body_place(body.getName())
            points = []
            for k in range(body.getPropertyByName("attached_geometry").size()):
                mesh = osim.Mesh.safeDownCast(body.get_attached_geometry(k))
                if mesh is not None:
                    scale = vector(mesh.get_scale_factors())
                    file = self.path.parent / "Geometry" / mesh.get_mesh_file()
                    points.append(read_obj(file)[0] * scale)
            if points:
                found[body.getName()] = np.concatenate(points) @ rotation.T + origin
        return found

    def put(self, values):
        """Puts coordinates to values, radians or metres; what follows others follows."""
        known = self.coordinates()
        for name, value in values.items():
            coordinate = known[name]
            if not coordinate.isDependent(self.state) and not coordinate.get_locked():
                coordinate.setValue(self.state, value, False)
        self.model.assemble(self.state)
        self.model.realizePosition(self.state)


def vector(v):
    return np.array([v.get(k) for k in range(3)])


def rigid(source, target):
    """The rigid motion that carries points best to others, as a function."""
    a, b = source.mean(axis=0), target.mean(axis=0)
    u, _, vt = np.linalg.svd((target - b).T @ (source - a))
    rotation = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return lambda points: (points - a) @ rotation.T + b


def check_loading(model, mass):
    for name, coordinate in model.coordinates().items():
        low, high = coordinate.getRangeMin(), coordinate.getRangeMax()
        assert low <= coordinate.getDefaultValue() <= high, f"{name} is not in its range"
    total = model.model.getTotalMass(model.state)
    if mass is not None:
        assert abs(total - mass) < 1e-6, f"{total} kg instead of {mass}"
    print(f"loads; {total:.3f} kg")


def check_pose(model, result):
    """Joint centres and meshes lie to each other as in the registration's result."""
    document = json.loads(result.read_text())
    unit = {"mm": 1e-3, "cm": 1e-2}.get(document.get("units"), 1.0)
    centres = model.joint_centres()
    names = [joint["name"] for joint in document["joints"]]
    wanted = [joint["child_frame"]["t"] for joint in document["joints"]]
    meshes = model.meshes()
    bones = {b["name"]: read_obj(result.parent / b["mesh"])[0] * unit for b in document["bones"]}
    every = np.concatenate([bones[name] for name in bones])
    own = np.concatenate([meshes[name] for name in bones])
    assert every.shape == own.shape, "meshes are missing"
    carried = rigid(every, own)
    apart = np.linalg.norm(carried(every) - own, axis=1).max()
    assert apart < 2e-5, f"meshes are {apart * 1e3} mm off"
    found = np.array([centres[name] for name in names])
    off = np.linalg.norm(carried(np.array(wanted) * unit) - found, axis=1).max()
    assert off < 2e-5, f"joint centres are {off * 1e3} mm off"
    print(f"{len(names)} joints within {off * 1e3:.4f} mm, {len(own)} vertices within {apart * 1e3:.4f} mm")


def check_muscles(template, person):
    """No muscle is shorter than its slack length, and tendons have grown with their muscles."""
    person.model.realizePosition(person.state)
    short, growth = [], []
    for muscle in person.model.getMuscles():
        if muscle.getLength(person.state) < muscle.getTendonSlackLength():
            short.append(muscle.getName())
    assert not short, f"shorter than their slack length: {', '.join(short)}"
    pose = {name: c.getDefaultValue() for name, c in template.coordinates().items()}
    person.put(pose)
    for own in template.model.getMuscles():
        muscle = person.model.getMuscles().get(own.getName())
        length = muscle.getLength(person.state) / own.getLength(template.state)
        tendon = muscle.getTendonSlackLength() / own.getTendonSlackLength()
        growth.append((abs(tendon / length - 1.0), own.getName()))
    worst, name = max(growth)
    print(f"{len(growth)} muscles, tendons as their paths within {worst * 100:.1f} % ({name})")
    assert worst < 0.1, f"the tendon of {name} did not grow with its path"


def read_motion(path, flip):
    """Times, and each coordinate's values, radians or metres."""
    lines = Path(path).read_text().splitlines()
    head = next(k for k, line in enumerate(lines) if line.strip() == "endheader")
    degrees = any(line.replace(" ", "").lower() == "indegrees=yes" for line in lines[:head])
    names = lines[head + 1].split()
    rows = np.array([[float(x) for x in line.split()] for line in lines[head + 2 :] if line.strip()])
    values = {}
    for name, column in zip(names[1:], rows.T[1:]):
        turns = not name.endswith(("_tx", "_ty", "_tz"))
        factor = np.pi / 180 if degrees and turns else 1.0
        values[name] = column * factor * (-1 if name in flip else 1)
    return rows[:, 0], values


def check_walk(model, motion, flip):
    """Markers on the moving person, and OpenSim's inverse kinematics from them back to the motion."""
    times, values = read_motion(motion, flip)
    known = model.coordinates()
    values = {name: column for name, column in values.items() if name in known}
    assert any(np.ptp(column) > 0.1 for column in values.values()), "the motion moves nothing"
    stations = {}
    for body, points in model.meshes().items():
        rotation, origin = model.body_place(body)
        points = (points - origin) @ rotation
        for k in range(3):
            stations[f"{body}_{k}"] = (body, points[np.argmax(points[:, k])])
            stations[f"{body}_{k + 3}"] = (body, points[np.argmin(points[:, k])])
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        marked = osim.Model(str(model.path))
        for name, (body, place) in stations.items():
            frame = marked.getBodySet().get(body)
            marked.addMarker(osim.Marker(name, frame, osim.Vec3(*place)))
        marked.finalizeConnections()
        frames, given = [], []
        for k in range(len(times)):
            model.put({name: column[k] for name, column in values.items()})
            given.append({n: c.getValue(model.state) for n, c in known.items()})
            places = {body: model.body_place(body) for body, _ in stations.values()}
            frames.append(
                np.concatenate([places[b][0] @ p + places[b][1] for b, p in stations.values()])
            )
        write_markers(folder / "markers.trc", times, list(stations), frames)
        tool = osim.InverseKinematicsTool()
        tool.setModel(marked)
        tool.setMarkerDataFileName(str(folder / "markers.trc"))
        tool.setOutputMotionFileName(str(folder / "found.mot"))
        tool.setResultsDir(str(folder))
        tool.set_accuracy(1e-9)
        for name in stations:
            task = osim.IKMarkerTask()
            task.setName(name)
            task.setWeight(1.0)
            tool.upd_IKTaskSet().cloneAndAppend(task)
        tool.setStartTime(times[0])
        tool.setEndTime(times[-1])
        assert tool.run(), "inverse kinematics failed"
        found_times, found = read_motion(folder / "found.mot", [])
        assert len(found_times) == len(times)
    off = []
    for name in values:
        if not name.endswith(("_tx", "_ty", "_tz")) and not known[name].get_locked():
            wanted = np.array([row[name] for row in given])
            off.append((np.degrees(np.abs(found[name] - wanted).max()), name))
    worst, name = max(off)
    assert worst < FOUND_AGAIN, f"inverse kinematics is {worst:.3f} degrees off, {name}"
    print(f"{len(times)} frames of a walk, found again within {worst:.4f} degrees ({name})")


def write_markers(path, times, names, frames):
    rate = (len(times) - 1) / (times[-1] - times[0])
    with path.open("w") as out:
        print(f"PathFileType\t4\t(X/Y/Z)\t{path.name}", file=out)
        heads = "DataRate CameraRate NumFrames NumMarkers Units OrigDataRate OrigDataStartFrame OrigNumFrames"
        print("\t".join(heads.split()), file=out)
        own = [rate, rate, len(times), len(names), "m", rate, 1, len(times)]
        print("\t".join(map(str, own)), file=out)
        print("Frame#\tTime\t" + "\t\t\t".join(names), file=out)
        axes = [f"{axis}{k + 1}" for k in range(len(names)) for axis in "XYZ"]
        print("\t\t" + "\t".join(axes) + "\n", file=out)
        for k, (time, row) in enumerate(zip(times, frames)):
            numbers = "\t".join(f"{x:.9f}" for x in row)
            print(f"{k + 1}\t{time:.6f}\t{numbers}", file=out)


def check(template, result, person, mass=None, motion=None, flip=()):
    template, person = Model(template), Model(person)
    check_loading(person, mass)
    check_pose(person, Path(result))
    check_muscles(template, person)
    if motion:
        check_walk(person, motion, flip)


if __name__ == "__main__":
    osim.Logger.setLevelString("warn")
    arguments = argparse.ArgumentParser()
    arguments.add_argument("template")
    arguments.add_argument("result")
    arguments.add_argument("person")
    arguments.add_argument("--mass", type=float)
    arguments.add_argument("--motion")
    arguments.add_argument("--flip", nargs="*", default=[])
    given = arguments.parse_args()
    try:
        check(given.template, given.result, given.person, given.mass, given.motion, given.flip)
    except AssertionError as error:
        sys.exit(f"FAILED: {error}")
