"""The pages of the documentation as programs: what a reader would type, in the repository's folder.

    python tests/python/pages.py OUT_FOLDER    writes the program of docs/python.md
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def program(page):
    """All Python of a page, one block after the other."""
    return "\n".join(re.findall(r"^```python\n(.*?)^```$", page.read_text(), re.M | re.S))


if __name__ == "__main__":
    (Path(sys.argv[1]) / "python_page.py").write_text(program(ROOT / "docs" / "python.md"))
