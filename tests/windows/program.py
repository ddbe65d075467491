"""The program under Wine: the same bytes as on Linux, and paths as Windows has them.

    python3 tests/windows/program.py LINUX_PROGRAM WINDOWS_PROGRAM
"""

import filecmp
import os
import re
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
WORK = ROOT / "target/windows/program"
LINUX, WINDOWS = (Path(argument).resolve() for argument in sys.argv[1:3])
JOB = """
template = "leber.obj"
markers = "Klicks Ä.csv"
landmarks = "Landmarken.csv"
landmark_tolerance = 15.0
tolerance = 3.0
tets = "lattice"
out = "Ergebnis für Anna/leber.obj"
"""
SECONDS = re.compile(rb'"seconds": [0-9.e-]+')
# TetGen is not there under Wine.
WITHOUT_TETGEN = {**os.environ, "PATH": "/nowhere"}


def windows_path(path):
    """Where Wine has a file of the repository."""
    return "Z:\\moulage\\" + str(path.relative_to(ROOT)).replace("/", "\\")


def on_windows(*arguments, status=0):
    done = subprocess.run(
        [ROOT / "release/tree.sh", "wine", f"/moulage/{WINDOWS.relative_to(ROOT)}", *arguments],
        capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == status, (arguments, done)
    return done


def on_linux(*arguments):
    return subprocess.run([LINUX, *arguments], check=True, capture_output=True, text=True, cwd=ROOT, env=WITHOUT_TETGEN)


class Program(unittest.TestCase):
    def same_files(self, one, other):
        """That both folders hold the same files with the same bytes, but for the seconds it took; how many."""
        names = sorted(path.relative_to(one) for path in one.rglob("*") if path.is_file())
        self.assertEqual(names, sorted(path.relative_to(other) for path in other.rglob("*") if path.is_file()))
        for name in names:
            contents = [SECONDS.sub(b"", (folder / name).read_bytes()) for folder in (one, other)]
            self.assertEqual(contents[0], contents[1], name)
        return len(names)

    def one_style(self, printed):
        self.assertIn("\\", printed)
        lines = [line for line in printed.splitlines() if "\\" in line and "/" in line.replace("mm/", "")]
        self.assertEqual(lines, [])

    def test_the_liver_of_the_readme_has_the_bytes_of_linux(self):
        copies = []
        for name in ("linux", "windows"):
            copy = WORK / name / "liver"
            shutil.copytree(ROOT / "examples/liver", copy, ignore=shutil.ignore_patterns("result"))
            copies.append(copy)
        on_linux("reshape", str(copies[0] / "job.toml"))
        printed = on_windows("reshape", f"{copies[1].relative_to(ROOT)}/job.toml").stdout
        self.assertIn("liver.obj", printed)
        self.one_style(printed)
        for name in ("liver.obj", "liver.vtu"):
            self.assertTrue(filecmp.cmp(copies[0] / "result" / name, copies[1] / "result" / name, shallow=False), name)

    def test_a_hand_has_the_bytes_of_linux(self):
        hand = ["register", "examples/hand/skeleton.json", "--target", "examples/hand/target_surface.ply"]
        on_linux(*hand, "-o", str(WORK / "hand_linux"))
        printed = on_windows(*hand, "-o", windows_path(WORK / "hand_windows")).stdout
        self.one_style(printed)
        self.assertGreater(self.same_files(WORK / "hand_linux", WORK / "hand_windows"), 27)

    def test_blanks_umlauts_other_line_ends_and_letters_of_either_case(self):
        results = []
        for line_end, name in (("\n", "linux"), ("\r\n", "windows")):
            folder = WORK / name / "Leber für Änne"
            folder.mkdir(parents=True)
            for source, target in (("template.obj", "leber.obj"), ("markers.csv", "Klicks Ä.csv"), ("landmarks.csv", "Landmarken.csv")):
                text = (ROOT / "examples/liver" / source).read_text()
                (folder / target).write_text(text, newline=line_end)
            (folder / "job.toml").write_text(JOB, newline=line_end)
            results.append(folder)
        on_linux("reshape", str(results[0] / "job.toml"))
        printed = on_windows("reshape", windows_path(results[1]) + "\\JOB.toml").stdout
        self.one_style(printed)
        self.assertIn("Ergebnis für Anna\\leber.obj", printed)
        moved = [(folder / "Ergebnis für Anna/leber.obj").read_bytes() for folder in results]
        self.assertEqual(moved[0], moved[1].replace(b"\r\n", b"\n"))

    def test_a_mistake_names_the_file_as_windows_does(self):
        said = on_windows("check", "examples/liver/nothing.obj", status=1)
        self.assertIn("examples\\liver\\nothing.obj", said.stdout + said.stderr)


if __name__ == "__main__":
    shutil.rmtree(WORK, ignore_errors=True)
    WORK.mkdir(parents=True)
    unittest.main(argv=sys.argv[:1], verbosity=2)
