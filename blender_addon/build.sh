#!/usr/bin/env bash
# Builds the add-on and the Python package for this machine's system, into dist/:
#   moulage-VERSION-py3-none-PLATFORM.whl   the package `moulage` with the native library
#   moulage-VERSION-PLATFORM.zip            the extension for Blender 4.2 and newer
#   moulage-VERSION-PLATFORM-legacy.zip     the same as an add-on for Blender 3.4 to 4.1
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release --lib
python3 python/build_wheel.py dist
python3 blender_addon/pack.py dist
