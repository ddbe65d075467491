"""Reports of a reshape, a registration and an anatomy in a headless Chromium.

    pages.py SCRATCH PICTURES
"""

import os
import subprocess
import sys
import unittest
from pathlib import Path

from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parents[2]
SCRATCH, PICTURES = map(Path, sys.argv[1:3])
# WebGL without a graphics card, and nothing that a browser does by itself in the network.
FLAGS = [
    "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-quic",
]
READY = "performance.getEntriesByName('moulage-view').length > 0"


def moulage(*arguments):
    subprocess.run([os.environ["MOULAGE_PROGRAM"], *map(str, arguments)], check=True, stdout=subprocess.DEVNULL, cwd=ROOT)


def make_reports():
    """Folders with a report.html each, by name."""
    moulage("reshape", "examples/liver/job.toml", "-o", SCRATCH / "liver.obj", "--report", SCRATCH / "reshape")
    moulage("register", "examples/hand/skeleton.json", "--target", "examples/hand/target_surface.ply", "--iterations", 5,
            "-o", SCRATCH / "hand", "--report", SCRATCH / "register")
    liver = ROOT / "examples/liver"
    (SCRATCH / "anatomy.toml").write_text(f"""
bones = ['{ROOT / "examples/hand/template_bones/3mc.obj"}']
template_bones = ['{ROOT / "examples/hand/template_bones/3mc.obj"}']
[[object]]
name = 'liver'
template = '{liver / "template.obj"}'
markers = '{liver / "markers.csv"}'
tets = 'lattice'
tet_count = 800
tolerance = 3
""")
    moulage("anatomy", SCRATCH / "anatomy.toml", "-o", SCRATCH / "anatomy")


class Pages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        make_reports()
        cls.playwright = sync_playwright().start()
        cls.browser = cls.launch()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        cls.playwright.stop()

    @classmethod
    def launch(cls, *more):
        return cls.playwright.chromium.launch(executable_path="/usr/bin/chromium", args=[*FLAGS, *more])

    def open(self, name, browser=None):
        """The page of a report; nothing but its one file may be asked for, and nothing may go wrong."""
        page = (browser or self.browser).new_page(viewport={"width": 1200, "height": 900})
        # The watchdog of tests/run.sh looks for what hangs; a slow machine is no failure.
        page.set_default_timeout(0)
        self.asked, self.wrong = [], []
        page.on("request", lambda request: self.asked.append(request.url))
        page.on("console", lambda message: message.type == "error" and self.wrong.append(message.text))
        page.on("pageerror", lambda error: self.wrong.append(str(error)))
        file = SCRATCH / name / "report.html"
        page.goto(file.as_uri())
        if browser is None:
            page.wait_for_function(f"{READY} || document.querySelector('.missing')")
            self.assertEqual((self.wrong, page.locator(".missing figcaption").all_inner_texts()), ([], []))
            seconds = page.evaluate("performance.getEntriesByName('moulage-view')[0].startTime / 1000")
            print(f"{name}: {file.stat().st_size / 1e6:.2f} MB, drawn after {seconds:.2f} s", flush=True)
        self.assertEqual([url for url in self.asked if not url.startswith("blob:")], [file.as_uri()])
        self.addCleanup(page.close)
        self.canvas = page.locator(".view3d canvas")
        return page

    def one(self, locator):
        """What a locator finds, which is there once."""
        self.assertEqual(locator.count(), 1, locator)
        return locator

    def picture(self, name):
        """What is drawn; a screenshot of it is kept to be looked at."""
        self.canvas.screenshot(path=PICTURES / f"{name}.png")
        return self.canvas.evaluate("canvas => canvas.toDataURL()")

    def drag(self, page, right, down):
        box = self.canvas.bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + right, y + down, steps=5)
        page.mouse.up()

    def test_a_reshape_turns(self):
        page = self.open("reshape")
        seen = [self.picture("reshape")]
        self.drag(page, 200, 60)
        seen.append(self.picture("reshape-turned"))
        self.one(page.get_by_role("button", name="front")).click()
        self.assertEqual(self.picture("reshape"), seen[0], "a button leads back")
        for name in ["Stretch", "Distance", "How sure"]:
            self.one(page.get_by_label(name, exact=True)).check()
            seen.append(self.picture(f"reshape-{name.lower().replace(' ', '-')}"))
        self.one(page.get_by_label("markers")).uncheck()
        seen.append(self.picture("reshape-without-markers"))
        slider = self.one(page.get_by_role("slider"))
        slider.fill("0")
        seen.append(self.picture("reshape-template"))
        slider.fill("1")
        self.canvas.focus()
        page.keyboard.press("ArrowLeft")
        seen.append(self.picture("reshape-by-key"))
        self.assertEqual(len(set(seen)), len(seen), "each step changes the picture")
        self.assertFalse(page.locator("details.still").get_attribute("open"))
        page.screenshot(path=PICTURES / "reshape-page.png", full_page=True)

    def test_the_wheel_scrolls_the_page_until_the_view_is_clicked(self):
        page = self.open("reshape")
        self.canvas.hover()
        before, scrolled = self.picture("wheel"), page.evaluate("scrollY")
        page.mouse.wheel(0, 40)
        page.wait_for_function(f"scrollY > {scrolled}")
        self.assertEqual(self.picture("wheel"), before)
        self.canvas.click()
        scrolled = page.evaluate("scrollY")
        page.mouse.wheel(0, -200)
        self.assertNotEqual(self.picture("wheel-zoomed"), before)
        self.assertEqual(page.evaluate("scrollY"), scrolled)

    def test_a_place_tells_its_value(self):
        page = self.open("reshape")
        self.one(page.get_by_label("Stretch")).check()
        self.canvas.hover()
        self.assertRegex(page.locator(".under").inner_text(), r"^surface: \d")
        self.assertIn("largest stretch", page.locator(".legend").inner_text())

    def test_a_registration_shows_bones_verdict_and_target(self):
        page = self.open("register")
        seen = [self.picture("register")]
        self.one(page.get_by_label("Verdict")).check()
        seen.append(self.picture("register-verdict"))
        self.assertEqual(page.locator(".legend").inner_text().split("\n"), ["verdict", "good", "doubtful", "failed"])
        self.one(page.get_by_label("Distance")).check()
        seen.append(self.picture("register-distance"))
        self.one(page.get_by_label("target")).check()
        seen.append(self.picture("register-target"))
        self.one(page.get_by_text("27 parts")).click()
        self.one(page.get_by_role("button", name="hide all")).click()
        seen.append(self.picture("register-hidden"))
        self.one(page.get_by_label("capitate")).check()
        seen.append(self.picture("register-one-bone"))
        self.assertEqual(len(set(seen)), len(seen), "each step changes the picture")
        page.screenshot(path=PICTURES / "register-page.png", full_page=True)

    def test_an_anatomy_shows_objects_and_bones(self):
        page = self.open("anatomy")
        seen = [self.picture("anatomy")]
        self.one(page.get_by_label("Verdict")).check()
        seen.append(self.picture("anatomy-verdict"))
        self.one(page.get_by_text("2 parts")).click()
        self.one(page.get_by_label("liver")).uncheck()
        seen.append(self.picture("anatomy-bone"))
        self.assertEqual(len(set(seen)), len(seen), "each step changes the picture")

    def test_without_webgl_the_still_pictures_are_there(self):
        browser = self.launch("--disable-3d-apis")
        page = self.open("reshape", browser)
        page.wait_for_selector("details.still[open]")
        self.assertIn("WebGL", page.locator(".view3d figcaption").inner_text())
        browser.close()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
