#!/usr/bin/env bash
# The add-on in Debian's Blender in a window, by clicks and keys; called by tests/run.sh.
#   tests/window/run.sh [SCREENSHOTS]
set -euo pipefail
cd "$(dirname "$0")/../.."
pictures=${1:-target/window/pictures}
dist=target/window/dist
built=$(tests/build.sh)
rm -rf "$pictures" "$dist"
blender_addon/build.sh "$dist" "$built"

for folder in CONFIG SCRIPTS DATAFILES; do
    export "BLENDER_USER_$folder=$(mktemp -d)"
done
export LIBGL_ALWAYS_SOFTWARE=1 MOULAGE_PROGRAM=$built/moulage
xvfb-run -a -s "-screen 0 1400x1000x24 +extension GLX +render -noreset" \
    blender --factory-startup --enable-event-simulate --window-geometry 0 0 1400 1000 \
    --python tests/window/session.py -- "$dist" "$pictures"
for picture in start check tets template_and_markers landmarks attachments attached running result heat_map_distance \
    heat_map_stretch slices scan label_map skeleton_start skeleton_running skeleton separate; do
    colours=$(identify -format %k "$pictures/$picture.png")
    [ "$colours" -gt 500 ] || { echo "$pictures/$picture.png shows next to nothing"; exit 1; }
done
echo "window: good"
