#!/usr/bin/env bash
# The add-on in every Blender that runs here, from the built zips; called by tests/run.sh.
set -euo pipefail
cd "$(dirname "$0")/../.."
dist=target/blender/dist
built=$(tests/build.sh)
rm -rf "$dist"
blender_addon/build.sh "$dist" "$built"
export MOULAGE_PROGRAM=$built/moulage

for version in 4.2.23 4.5.15 5.0.1; do
    # Blender's wheels are for Python 3.11.
    venv=$(tests/venv.sh "bpy-$version" python3.11 "bpy==$version" numpy)
    tool=$(echo "$venv"/lib/python3*/site-packages/bpy/*/scripts/addons_core/bl_pkg/cli/blender_ext.py)
    "$venv/bin/python" "$tool" validate "$dist"/moulage-*-linux-x64.zip
    "$venv/bin/python" tests/blender/run.py "$dist"
done

# Debian's, with fresh settings.
for folder in CONFIG SCRIPTS DATAFILES; do
    export "BLENDER_USER_$folder=$(mktemp -d)"
done
blender -b --factory-startup --python-exit-code 1 --python tests/blender/run.py -- "$dist"
