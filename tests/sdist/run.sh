#!/usr/bin/env bash
# The Python package as pip builds it from its source, where no wheel fits: minutes of compiling; called by tests/run.sh.
set -euo pipefail
cd "$(dirname "$0")/../.."
built=$(tests/build.sh)
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
python/build.sh "$out" "$built"
python3 -m venv "$out/pip"
# Elsewhere than here, so that nothing but the archive is there to build from.
(cd "$out" && "$out/pip/bin/pip" wheel --quiet --no-cache-dir --no-deps --wheel-dir "$out/made" "$out"/*.tar.gz)
tests/python/installed.sh "$out"/made/*.whl
