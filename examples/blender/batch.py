"""Reshapes the liver of examples/liver without a window and saves the scene. The add-on must be enabled.

    blender -b --python examples/blender/batch.py -- FOLDER OUT.blend
    python examples/blender/batch.py FOLDER OUT.blend        # with the Python module bpy

FOLDER holds template.obj, markers.csv and landmarks.csv, in millimetres.
"""

import sys
from pathlib import Path

import bpy


def main(folder, out, max_iterations=0):
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.moulage.import_template(filepath=str(folder / "template.obj"))
    template = bpy.context.scene.moulage.template
    bpy.ops.moulage.import_person(directory=str(folder), files=[{"name": "markers.csv"}, {"name": "landmarks.csv"}])
    print(template.moulage.findings or "The template is closed and clean.")

    template.moulage.tolerance = 0.3
    template.moulage.landmark_tolerance = 15.0
    template.moulage.max_iterations = max_iterations
    bpy.ops.moulage.reshape()
    bpy.ops.moulage.show_heat_map(kind="STRETCH")

    result = template.moulage.result
    print(f"{result.ending} {result.iterations} steps, {result.seconds:.0f} s")
    bpy.ops.wm.save_as_mainfile(filepath=str(out))


if __name__ == "__main__":
    given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    if len(given) != 2:
        sys.exit(__doc__)
    main(Path(given[0]).resolve(), Path(given[1]).resolve())
