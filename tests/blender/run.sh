#!/usr/bin/env bash
# The add-on in every Blender that runs here, from the built zips; called by tests/run.sh.
#   tests/blender/run.sh [SCREENSHOTS]
set -euo pipefail
cd "$(dirname "$0")/../.."
pictures=${1:-target/blender/pictures}
dist=target/blender/dist
built=$(tests/build.sh)
rm -rf "$pictures" "$dist"
blender_addon/build.sh "$dist" "$built"
export MOULAGE_PROGRAM=$built/moulage

fresh_settings() {
    for folder in CONFIG SCRIPTS DATAFILES; do
        export "BLENDER_USER_$folder=$(mktemp -d)"
    done
}

# Debian's Blender in a window, while the others go on without one.
in_a_window() {
    fresh_settings
    export LIBGL_ALWAYS_SOFTWARE=1
    # exec: whoever ends this function ends the watchdog, and it the rest.
    exec tests/watchdog.py xvfb-run -a -s "-screen 0 1400x1000x24 +extension GLX +render -noreset" \
        blender --factory-startup --enable-event-simulate --window-geometry 0 0 1400 1000 \
        --python tests/blender/window/session.py -- "$dist" "$pictures"
}
in_a_window >target/blender/window.log 2>&1 &
window=$!
trap 'kill "$window" 2>/dev/null || true' EXIT

for version in 4.2.23 4.5.15 5.0.1; do
    # Blender's wheels are for Python 3.11.
    venv=$(tests/venv.sh "bpy-$version" python3.11 "bpy==$version" numpy)
    tool=$(echo "$venv"/lib/python3*/site-packages/bpy/*/scripts/addons_core/bl_pkg/cli/blender_ext.py)
    "$venv/bin/python" "$tool" validate "$dist"/moulage-blender-*-linux-x64.zip
    "$venv/bin/python" tests/blender/run.py "$dist"
done

fresh_settings
blender -b --factory-startup --python-exit-code 1 --python tests/blender/run.py -- "$dist"

# The parts of the session go on being told while it is waited for.
tail -n +1 -f --pid="$window" target/blender/window.log
wait "$window" || { echo "the session in a window ended with $?"; exit 1; }
for picture in start doubts check tets template_and_markers landmarks attachments attached running result pin undone_meanwhile heat_map_distance \
    heat_map_stretch heat_map_sure slices scan label_map skeleton_start skeleton_running skeleton separate; do
    colours=$(identify -format %k "$pictures/$picture.png")
    [ "$colours" -gt 500 ] || { echo "$pictures/$picture.png shows next to nothing"; exit 1; }
done
echo "window: good"
