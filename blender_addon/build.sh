#!/usr/bin/env bash
# Builds the add-on and the Python package (with tools from PyPI) for this machine's system:
#   blender_addon/build.sh [FOLDER [LIBRARIES]]    into FOLDER (default: dist), with the library in LIBRARIES (default: built now)
#   moulage-VERSION-py3-none-PLATFORM.whl         the package `moulage` with the native library, and its source (python/build.sh)
#   moulage-blender-VERSION-PLATFORM.zip          the extension for Blender 4.2 and newer
#   moulage-blender-VERSION-PLATFORM-legacy.zip   the same as an add-on for Blender 3.4 to 4.1
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-dist}
rm -f "$out"/moulage-*.whl
python/build.sh "$out" "${@:2}"
python3 blender_addon/pack.py "$out"/moulage-*.whl
