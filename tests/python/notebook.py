"""Runs examples/python/notebook.ipynb from its first cell to its last, in the repository's folder.

    python tests/python/notebook.py [--update]    --update: keeps what the cells printed and drew
"""

import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOK = ROOT / "examples" / "python" / "notebook.ipynb"


def run():
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(notebook)
    NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(NOTEBOOK.parent)}}).execute()
    return notebook


if __name__ == "__main__":
    done = run()
    outputs = [output for cell in done.cells if cell.cell_type == "code" for output in cell.outputs]
    pictures = sum("image/png" in output.get("data", {}) for output in outputs)
    assert pictures >= 2, f"the notebook drew {pictures} pictures"
    if "--update" in sys.argv:
        for cell in done.cells:
            cell.metadata.pop("execution", None)
            if cell.cell_type == "code":
                # What this machine says of its graphics, and pictures that are there twice.
                cell.outputs = [output for output in cell.outputs if output.output_type != "stream"]
                for output in cell.outputs:
                    output.data.pop("image/jpeg", None)
        nbformat.write(done, NOTEBOOK)
    print(f"notebook: {len(done.cells)} cells, {pictures} pictures")
