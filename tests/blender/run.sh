#!/usr/bin/env bash
# The add-on in every Blender that runs here, from the built zips; called by tests/run.sh.
#   tests/blender/run.sh DIST [SCREENSHOTS]
set -euo pipefail
cd "$(dirname "$0")/../.."
dist=$1
pictures=${2:-target/blender/pictures}
mkdir -p target/blender

# Debian's Blender in a window, while the others go on without one.
in_a_window() {
    for folder in CONFIG SCRIPTS DATAFILES; do
        export "BLENDER_USER_$folder=$(mktemp -d)"
    done
    LIBGL_ALWAYS_SOFTWARE=1 timeout 2400 xvfb-run -a -s "-screen 0 1400x1000x24 +extension GLX +render -noreset" \
        blender --factory-startup --enable-event-simulate --window-geometry 0 0 1400 1000 \
        --python tests/blender/window/session.py -- "$dist" "$pictures"
}
rm -rf "$pictures"
in_a_window >target/blender/window.log 2>&1 &
window=$!
trap 'kill "$window" 2>/dev/null || true' EXIT

for version in 4.2.23 4.5.15 5.0.1; do
    # One after the other: each takes a gigabyte. Blender's wheels are for Python 3.11.
    venv=target/blender/bpy
    rm -rf "$venv"
    python3.11 -m venv "$venv"
    "$venv/bin/pip" install -q --no-cache-dir "bpy==$version" numpy
    tool=$(echo "$venv"/lib/python3*/site-packages/bpy/*/scripts/addons_core/bl_pkg/cli/blender_ext.py)
    "$venv/bin/python" "$tool" validate "$dist"/moulage-*-linux-x64.zip
    timeout 900 "$venv/bin/python" tests/blender/run.py "$dist"
done
rm -rf target/blender/bpy

for folder in CONFIG SCRIPTS DATAFILES; do
    export "BLENDER_USER_$folder=$(mktemp -d)"
done
timeout 900 blender -b --factory-startup --python-exit-code 1 --python tests/blender/run.py -- "$dist"

ended=0
wait "$window" || ended=$?
cat target/blender/window.log
[ "$ended" -eq 0 ] || { echo "the session in a window ended with $ended"; exit 1; }
for picture in start check tets template_and_markers landmarks attachments attached running result heat_map_distance \
    heat_map_stretch slices scan label_map skeleton_start skeleton_running skeleton separate; do
    colours=$(identify -format %k "$pictures/$picture.png")
    [ "$colours" -gt 500 ] || { echo "$pictures/$picture.png shows next to nothing"; exit 1; }
done
