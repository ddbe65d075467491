#!/usr/bin/env bash
# The Python package: its wheel in a fresh environment; called by tests/run.sh.
set -euo pipefail
cd "$(dirname "$0")/../.."
built=$(tests/build.sh)
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
python3 python/make_interface.py --check
python/build.sh "$out" "$built"
python3 -m venv "$out/venv"
"$out/venv/bin/pip" install --quiet --no-cache-dir "$out"/*.whl
"$out/venv/bin/python" tests/python/test_reach.py
