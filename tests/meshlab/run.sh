#!/usr/bin/env bash
# Builds the MeshLab filter from Debian's MeshLab sources and tests it in PyMeshLab; called by tests/run.sh.
# Sources and environments stay in target/cache.
set -euo pipefail
cd "$(dirname "$0")/../.."
built=$(tests/build.sh)
work=$(realpath -m target/meshlab)
sources=$(realpath -m target/cache/meshlab)
rm -rf "$work"
mkdir -p "$work" "$sources"
tests/meshlab/sources.sh "$sources"

# Side by side: each of them reads headers and links most of the time, one step after the other.
building=()
for build in "2025.07 double" "2023.12 double" "2025.07 float"; do
    meshlab_plugin/build.sh "$sources/source" $build "$built" "$work/${build/ /-}" &
    building+=($!)
done
for process in "${building[@]}"; do wait "$process"; done

export QT_QPA_PLATFORM=offscreen
for wheel in 2025.07:2025.7.post1 2023.12:2023.12.post3; do
    version=${wheel%:*} package=${wheel#*:}
    python=$(tests/venv.sh "pymeshlab-$package" python3 'numpy<2' "pymeshlab==$package")/bin/python
    # All symbols at once, so that one that is missing shows.
    LD_BIND_NOW=1 "$python" tests/meshlab/filters.py "$work/$version-double/libfilter_moulage.so" "$work" "$built/moulage"
    other=$([ "$version" = 2025.07 ] && echo 2023.12 || echo 2025.07)
    "$python" tests/meshlab/refused.py "$work/2025.07-float/libfilter_moulage.so" "different floating point precision"
    "$python" tests/meshlab/refused.py "$work/$other-double/libfilter_moulage.so" "different version"
done
echo "meshlab: good"
