"""A registered hand with a sleeve around its forefinger bends: the Khronos validator takes the scene, and in
a browser the sleeve moves with the bones.

    scenes.py SCRATCH PICTURES
"""

import base64
import math
import subprocess
import sys
import unittest

from pages import FLAGS, PICTURES, ROOT, SCRATCH, moulage
from playwright.sync_api import sync_playwright

FINGER = ["2proxph", "2midph", "2distph"]
SIDES, RADIUS = 24, 8.0  # of the sleeve; mm


def vertices(path):
    return [tuple(map(float, line.split()[1:4])) for line in path.read_text().splitlines() if line.startswith("v ")]


def middle(points):
    return [sum(p[k] for p in points) / len(points) for k in range(3)]


def write_sleeve(path):
    """A tube through the middles of the finger's bones, longer by a bit at the ends."""
    middles = [middle(vertices(ROOT / f"examples/hand/template_bones/{bone}.obj")) for bone in FINGER]
    beyond = [[2 * b - a for a, b in zip(other, end)] for other, end in [middles[1::-1], middles[1:]]]
    line = [beyond[0], *middles, beyond[1]]
    rings = []
    for a, b in zip(line, line[1:]):
        rings += [[a[k] + (b[k] - a[k]) * n / 12 for k in range(3)] for n in range(12)]
    # The finger runs along z.
    corners = [2 * math.pi * n / SIDES for n in range(SIDES)]
    lines = [f"v {x + RADIUS * math.cos(t)} {y + RADIUS * math.sin(t)} {z}" for x, y, z in rings for t in corners]
    for ring in range(len(rings) - 1):
        for n in range(SIDES):
            a, b = [ring * SIDES + k + 1 for k in (n, (n + 1) % SIDES)]
            lines += [f"f {a} {b} {b + SIDES}", f"f {a} {b + SIDES} {a + SIDES}"]
    path.write_text("\n".join(lines) + "\n")


class Scenes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        sleeve, motion = SCRATCH / "sleeve.obj", SCRATCH / "bend.mot"
        write_sleeve(sleeve)
        bend = "\n".join(f"{n / 10} {6 * n} {6 * n} {4 * n}" for n in range(11))
        motion.write_text(f"bend\ninDegrees=yes\nendheader\ntime mcp2_flexion pm2_flexion md2_flexion\n{bend}\n")
        cls.hand = SCRATCH / "bending"
        moulage("register", "examples/hand/skeleton.json", "--target", "examples/hand/target_surface.ply", "--iterations",
                5, "--carry", sleeve, "--motion", motion, "-o", cls.hand)
        moulage("convert", cls.hand / "result.skeleton.json", SCRATCH / "again.glb", "--motion", motion)
        moulage("convert", "examples/hand/skeleton.json", SCRATCH / "bones.glb")

    def test_the_validator_takes_the_scenes(self):
        scenes = [self.hand / "skeleton.glb", SCRATCH / "again.glb", SCRATCH / "bones.glb"]
        checked = subprocess.run(["node", SCRATCH / "scene/validate.js", *scenes], capture_output=True, text=True)
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)
        print(checked.stdout)

    def test_the_sleeve_bends_with_the_finger(self):
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
            page = browser.new_page(viewport={"width": 900, "height": 700})
            page.set_default_timeout(0)
            wrong = []
            page.on("pageerror", lambda error: wrong.append(str(error)))
            page.add_script_tag(content=(SCRATCH / "viewer/scene.js").read_text())
            scene = base64.b64encode((self.hand / "skeleton.glb").read_bytes()).decode()
            page.evaluate("([scene, names]) => open_scene(scene, [0.5, 0.2, 1], names)", [scene, ["sleeve"]])
            seen, places = [], []
            for name, seconds in [("straight", 0.0), ("half", 0.5), ("bent", 1.0)]:
                page.evaluate("seconds => draw_at(seconds)", seconds)
                page.screenshot(path=PICTURES / f"finger-{name}.png")
                seen.append(page.evaluate("document.querySelector('canvas').toDataURL()"))
                places.append({name: page.evaluate("name => vertices_of(name)", name) for name in ["sleeve", *FINGER]})
            browser.close()
        self.assertEqual(wrong, [])
        self.assertEqual(len(set(seen)), 3, "each pose draws another picture")
        straight, _, bent = places
        # The end goes where the tip's bone goes: it keeps its distances to the bone's vertices.
        end = len(straight["sleeve"]) - 1
        self.assertGreater(math.dist(straight["sleeve"][end], bent["sleeve"][end]), 0.05, "metres")
        for bone in straight["2distph"], bent["2distph"]:
            self.assertGreater(len(bone), 100)
        for v in range(0, len(straight["2distph"]), 20):
            before, after = [math.dist(place["sleeve"][end], place["2distph"][v]) for place in (straight, bent)]
            self.assertLess(abs(before - after), 0.001)
        # Between the bones it bends and does not tear.
        edges = [(v, v + SIDES) for v in range(len(straight["sleeve"]) - SIDES)]
        before, after = [[math.dist(place["sleeve"][a], place["sleeve"][b]) for a, b in edges] for place in (straight, bent)]
        stretch = [b / a for a, b in zip(before, after)]
        self.assertLess(max(stretch), 3)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
