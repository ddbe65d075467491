#!/usr/bin/env python3
"""Makes a hand of 27 bones and 17 muscles, for `moulage anatomy`.

    examples/anatomy/make_hand.py FOLDER
    moulage anatomy FOLDER/job.toml

The bones are those of examples/hand (MyoHand, Apache-2.0): the template's, and another person's in
the same vertex order. The muscles are synthetic lofts (CC0) with the place and rough size of the
named ones, not their anatomy. Each is built twice by the same rule, between the template's bones and
between the person's; markers are points of the latter with noise of 0.1 mm, as if clicked on a scan.
Neighbours overlap by about half a millimetre, so that there is something to separate. Needs numpy.
"""
import json
import sys
from pathlib import Path

import numpy as np

HAND = Path(__file__).resolve().parent.parent / "hand"
RINGS, AROUND = 24, 16
NOISE = 0.1
# A muscle is wider than it is high; how deep centre lines let muscles overlap; rounds of moving them.
WIDTH, OVERLAP, SETTLING = 1.15, 0.5, 60

# name: origin (bone, share of its length from the wrist, towards), insertion, largest radius in mm.
# "towards" names a bone to whose side the muscle lies, or is "palm".
MUSCLES = {
    "dorsal_interosseous_1": (("2mc", 0.45, "1mc"), ("2proxph", 0.15, "1mc"), 3.2),
    "dorsal_interosseous_2": (("3mc", 0.45, "2mc"), ("3proxph", 0.15, "2mc"), 2.6),
    "dorsal_interosseous_3": (("3mc", 0.45, "4mc"), ("3proxph", 0.15, "4mc"), 2.6),
    "dorsal_interosseous_4": (("4mc", 0.45, "5mc"), ("4proxph", 0.15, "5mc"), 2.4),
    "palmar_interosseous_1": (("2mc", 0.5, "palm 3mc"), ("2proxph", 0.15, "palm 3mc"), 2.2),
    "palmar_interosseous_2": (("4mc", 0.5, "palm 3mc"), ("4proxph", 0.15, "palm 3mc"), 2.2),
    "palmar_interosseous_3": (("5mc", 0.5, "palm 4mc"), ("5proxph", 0.15, "palm 4mc"), 2.0),
    "lumbrical_1": (("2mc", 0.15, "palm"), ("2proxph", 0.2, "palm 1mc"), 1.8),
    "lumbrical_2": (("3mc", 0.15, "palm"), ("3proxph", 0.2, "palm 2mc"), 1.8),
    "lumbrical_3": (("4mc", 0.15, "palm"), ("4proxph", 0.2, "palm 3mc"), 1.8),
    "lumbrical_4": (("5mc", 0.15, "palm"), ("5proxph", 0.2, "palm 4mc"), 1.7),
    "adductor_pollicis": (("3mc", 0.6, "palm"), ("thumbprox", 0.2, "2mc"), 4.0),
    "abductor_pollicis_brevis": (("scaphoid", 0.5, "palm"), ("thumbprox", 0.2, "palm"), 3.2),
    "opponens_pollicis": (("trapezium", 0.5, "palm"), ("1mc", 0.7, "palm"), 3.0),
    "flexor_pollicis_brevis": (("trapezoid", 0.5, "palm"), ("thumbprox", 0.15, "palm 2mc"), 3.0),
    "abductor_digiti_minimi": (("pisiform", 0.5, "palm"), ("5proxph", 0.15, "palm"), 3.2),
    "flexor_digiti_minimi": (("hamate", 0.5, "palm"), ("5mc", 0.75, "palm 4mc"), 2.6),
}


def read_obj(path):
    points, faces = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append([float(w) for w in words[1:4]])
        elif words[:1] == ["f"]:
            faces.append([int(w.split("/")[0]) - 1 for w in words[1:4]])
    return np.array(points), np.array(faces)


def write_obj(path, points, faces):
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in points]
    lines += [f"f {a} {b} {c}" for a, b, c in np.asarray(faces) + 1]
    path.write_text("\n".join(lines) + "\n")


def read_ply_points(path):
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    count = int(data[:end].split(b"element vertex ")[1].split()[0])
    return np.frombuffer(data, "<f4", 3 * count, end).reshape(-1, 3).astype(float)


def normals(points, faces):
    a, b, c = (points[faces[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)
    sums = np.zeros_like(points)
    for k in range(3):
        np.add.at(sums, faces[:, k], area)
    return sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-30)


def unit(v):
    return v / np.linalg.norm(v)


class Hand:
    """One hand's bones: name -> (points, faces)."""

    def __init__(self, bones):
        self.bones = bones
        self.middle = {name: points.mean(0) for name, (points, _) in bones.items()}
        self.wrist = np.mean([self.middle[n] for n in ("lunate", "capitate", "hamate")], axis=0)
        across = self.middle["5mc"] - self.middle["2mc"]
        along = self.middle["3mc"] - self.wrist
        palm = unit(np.cross(across, along))
        self.palm = palm * np.sign(palm @ (self.middle["pisiform"] - self.wrist))

    def towards(self, bone, where):
        direction = np.zeros(3)
        for word in where.split():
            direction += self.palm if word == "palm" else unit(self.middle[word] - self.middle[bone])
        return unit(direction)

    def vertex(self, bone, share, where):
        """The vertex that sticks out farthest to one side of the slice at a share of the length."""
        points, _ = self.bones[bone]
        axis = unit(np.linalg.svd(points - points.mean(0))[2][0])
        axis *= np.sign(axis @ (points.mean(0) - self.wrist))
        along = points @ axis
        level = along.min() + share * (along.max() - along.min())
        slab = np.flatnonzero(abs(along - level) < 0.06 * (along.max() - along.min()) + 0.5)
        side = self.towards(bone, where)
        return slab[np.argmax(points[slab] @ side)]


def settle(centres, radii, bones, lofts):
    """Moves a line of centres off bones and earlier muscles; its ends stay."""
    points = np.vstack([b[0] for b in bones])
    outward = np.vstack([normals(*b) for b in bones])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    for _ in range(SETTLING):
        for k in range(1, len(centres) - 1):
            near = np.argmin(np.linalg.norm(points - centres[k], axis=1))
            lack = radii[k] - (centres[k] - points[near]) @ outward[near]
            if lack > 0:
                centres[k] += 0.5 * lack * outward[near]
            for others, wide in lofts:
                far = np.linalg.norm(others - centres[k], axis=1)
                m = np.argmin(far - wide)
                lack = radii[k] + wide[m] - OVERLAP - far[m]
                if lack > 0:
                    centres[k] += 0.5 * lack * (centres[k] - others[m]) / max(far[m], 1e-9)
        centres[1:-1] = 0.5 * centres[1:-1] + 0.25 * (centres[:-2] + centres[2:])
    return centres


def loft(hand, origin, insertion, radius, lofts):
    """A spindle from a vertex of one bone to one of another, lying on both."""
    ends = []
    for bone, vertex in (origin, insertion):
        points, faces = hand.bones[bone]
        ends.append((points[vertex], unit(normals(points, faces)[vertex])))
    (p, n), (q, m) = ends
    t = np.linspace(0, 1, RINGS)[:, None]
    r = radius * (0.4 + 0.6 * np.sin(np.pi * t) ** 1.5)
    lift = (1 - t) * n + t * m
    lift /= np.linalg.norm(lift, axis=1, keepdims=True)
    centres = (1 - t) * p + t * q + lift * (r + 0.3)
    centres = settle(centres, WIDTH * r[:, 0], list(hand.bones.values()), lofts)
    lofts.append((centres, WIDTH * r[:, 0]))
    tangent = unit(q - p)
    side = np.cross(tangent, lift)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, tangent)
    turn = 2 * np.pi * np.arange(AROUND) / AROUND
    ring = [c + (np.outer(np.cos(turn), s) * WIDTH + np.outer(np.sin(turn), u)) * a
            for c, s, u, a in zip(centres, side, up, r[:, 0])]
    points = np.vstack([centres[:1] - tangent * 0.3, *ring, centres[-1:] + tangent * 0.3])
    faces, last = [], len(points) - 1
    at = lambda i, j: 1 + i * AROUND + j % AROUND
    for j in range(AROUND):
        faces.append([0, at(0, j + 1), at(0, j)])
        faces.append([last, at(RINGS - 1, j), at(RINGS - 1, j + 1)])
        for i in range(RINGS - 1):
            faces.append([at(i, j), at(i, j + 1), at(i + 1, j + 1)])
            faces.append([at(i, j), at(i + 1, j + 1), at(i + 1, j)])
    faces = np.array(faces)
    a, b, c = (points[faces[:, k]] for k in range(3))
    if np.einsum("ij,ij->", a, np.cross(b, c)) < 0:
        faces = faces[:, ::-1]
    return points, faces


def winding(points, faces, queries):
    """How often a surface goes around each point."""
    total = np.zeros(len(queries))
    for a, b, c in zip(*(points[faces[:, k]] for k in range(3))):
        u, v, w = a - queries, b - queries, c - queries
        lu, lv, lw = (np.linalg.norm(x, axis=1) for x in (u, v, w))
        below = (lu * lv * lw + np.einsum("ij,ij->i", u, v) * lw
                 + np.einsum("ij,ij->i", v, w) * lu + np.einsum("ij,ij->i", w, u) * lv)
        total += 2 * np.arctan2(np.einsum("ij,ij->i", u, np.cross(v, w)), below)
    return total / (4 * np.pi)


def main(folder):
    skeleton = json.loads((HAND / "skeleton.json").read_text())
    template, person, start = {}, {}, 0
    surface = read_ply_points(HAND / "target_surface.ply")
    for bone in skeleton["bones"]:
        points, faces = read_obj(HAND / bone["file"])
        template[bone["bone"]] = (points, faces)
        person[bone["bone"]] = (surface[start:start + len(points)], faces)
        start += len(points)
    for name in template:
        write_obj(folder / "template_bones" / f"{name}.obj", *template[name])
        write_obj(folder / "bones" / f"{name}.obj", *person[name])
    here, there = Hand(template), Hand(person)
    noise = np.random.default_rng(17)
    job = ["out = 'result'", "bones = 'bones'", "template_bones = 'template_bones'",
           "\n[defaults]", "align = 'rigid'", "tolerance = 0.2", "tet_count = 4000",
           "attachment_distance = 1.5"]
    lofts_here, lofts_there = [], []
    for name, (origin, insertion, radius) in MUSCLES.items():
        anchors = [(bone, here.vertex(bone, share, where)) for bone, share, where in (origin, insertion)]
        points, faces = loft(here, *anchors, radius, lofts_here)
        write_obj(folder / "templates" / f"{name}.obj", points, faces)
        target, _ = loft(there, *anchors, radius * noise.uniform(0.95, 1.2), lofts_there)
        clicks = target[::3] + noise.normal(0, NOISE, target[::3].shape)
        hidden = np.zeros(len(clicks), bool)
        for bone in person.values():
            near = np.all((clicks > bone[0].min(0) - 1) & (clicks < bone[0].max(0) + 1), axis=1)
            if near.any():
                hidden[near] |= winding(*bone, clicks[near]) > 0.5
        rows = "".join(f"{x:.4f},{y:.4f},{z:.4f}\n" for x, y, z in clicks[~hidden])
        write_obj(folder / "truth" / f"{name}.obj", target, faces)
        (folder / "markers").mkdir(exist_ok=True)
        (folder / "markers" / f"{name}.csv").write_text("x,y,z\n" + rows)
        job += ["\n[[object]]", f"name = '{name}'", f"template = 'templates/{name}.obj'",
                f"markers = 'markers/{name}.csv'",
                f"attached_to = ['{anchors[0][0]}', '{anchors[1][0]}']"]
    (folder / "job.toml").write_text("\n".join(job) + "\n")
    print(f"{len(template)} bones and {len(MUSCLES)} muscles in {folder}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: make_hand.py FOLDER")
    main(Path(sys.argv[1]))
