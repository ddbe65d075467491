"""Installs the built zip into this Blender and runs the tests of cases/.

    PYTHON-WITH-bpy tests/blender/run.py DIST [THEME[.CLASS[.TEST]]...]
    blender -b --factory-startup --python-exit-code 1 --python tests/blender/run.py -- DIST [THEME[.CLASS[.TEST]]...]
"""

import os
import sys
import tempfile
import unittest
from pathlib import Path

if "bpy" not in sys.modules:
    # Before bpy is loaded: settings and add-ons of the user stay out of it.
    os.environ["BLENDER_USER_RESOURCES"] = tempfile.mkdtemp(prefix="moulage_blender_")

import bpy

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))


def install(dist):
    """Installs and enables the add-on from its zip; returns its module's name."""
    if bpy.app.version >= (4, 2, 0):
        (archive,) = (p for p in dist.glob("moulage-blender-*.zip") if not p.stem.endswith("legacy"))
        bpy.ops.extensions.package_install_files(
            filepath=str(archive), repo="user_default", enable_on_install=True
        )
        name = "bl_ext.user_default.moulage"
    else:
        (archive,) = dist.glob("moulage-blender-*-legacy.zip")
        bpy.ops.preferences.addon_install(filepath=str(archive))
        name = "moulage_blender"
        bpy.ops.preferences.addon_enable(module=name)
    # The operators report success also when the add-on could not be installed.
    if name not in bpy.context.preferences.addons:
        sys.exit(f"{archive} could not be installed")
    return name


def main():
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    os.environ["MOULAGE_MODULE"] = install(Path(arguments[0]).resolve())
    themes = sorted(p.stem for p in (HERE / "cases").glob("*.py") if p.stem != "__init__")
    suite = unittest.defaultTestLoader.loadTestsFromNames(f"cases.{name}" for name in arguments[1:] or themes)
    print(f"Blender {bpy.app.version_string}, {suite.countTestCases()} tests", flush=True)
    passed = unittest.TextTestRunner(stream=sys.stdout, verbosity=2).run(suite).wasSuccessful()
    sys.stdout.flush()
    # bpy 4.5 can hang when it ends by itself.
    os._exit(0 if passed else 1)


if __name__ == "__main__":
    main()
