#!/usr/bin/env bash
# The Python package: its wheel, named for the systems it fits, in a fresh environment; called by tests/run.sh.
set -euo pipefail
cd "$(dirname "$0")/../.."
built=$(tests/build.sh)
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
python3 python/make_interface.py --check
python/build.sh "$out" "$built"
wheel=$(echo "$out"/*.whl)
"$(tests/venv.sh wheel)/bin/auditwheel" show "$wheel" | tee "$out/tag"
grep -q "manylinux_2_17_$(uname -m)" "$out/tag"
[[ $wheel == *manylinux_2_17_$(uname -m)* ]] || { echo "the wheel is named $wheel"; exit 1; }
tests/python/installed.sh "$wheel"
