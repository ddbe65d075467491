#!/usr/bin/env bash
# The Python package as its users get it: installed alone, then with all that it works with.
#   tests/python/installed.sh WHEEL
set -euo pipefail
wheel=$(realpath "$1")
cd "$(dirname "$0")/../.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Fetched while the first tests run.
packages=(python python3 pyvista trimesh nibabel SimpleITK tqdm ipykernel mypy nbclient numpydoc pillow)
tests/venv.sh "${packages[@]}" >"$work/all" &
fetching=$!

echo "== with numpy alone"
python3 -m venv "$work/alone"
"$work/alone/bin/pip" install --quiet --no-cache-dir "$wheel"
"$work/alone/bin/python" tests/python/test_reach.py
"$work/alone/bin/python" tests/python/every_class.py

echo "== with what it works with"
wait "$fetching"
all=$(cat "$work/all")/bin
"$all/pip" install --quiet --no-cache-dir --force-reinstall --no-deps "$wheel"
"$all/pip" install --quiet --no-cache-dir "$wheel[all]"
"$all/python" tests/python/test_exchange.py
"$all/python" tests/python/documented.py

echo "== docs/python.md and the notebook, as written"
ln -s "$PWD/examples" "$work/examples"
"$all/python" tests/python/pages.py "$work"
(cd "$work" && "$all/python" python_page.py)
"$all/mypy" --strict "$work/python_page.py" tests/python/every_class.py
PATH=$all:$PATH "$all/python" tests/python/notebook.py
