#!/usr/bin/env bash
# Builds the MeshLab filter from Debian's MeshLab sources and tests it in PyMeshLab.
#   tests/meshlab/run.sh [FOLDER]    sources, wheels and builds go into FOLDER (default: a temporary one)
set -euo pipefail
cd "$(dirname "$0")/../.."
work=${1:-}
if [ -z "$work" ]; then
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
fi
mkdir -p "$work"
work=$(realpath "$work")

cargo build --release
libraries=$(realpath "${CARGO_TARGET_DIR:-target}/release")
tests/meshlab/sources.sh "$work"

for build in 2025.07:double 2023.12:double 2025.07:float; do
    version=${build%:*} scalar=${build#*:}
    double=OFF
    [ "$scalar" = double ] && double=ON
    # The headers of 2025.07 serve 2023.12 too: what the filter uses has the same layout.
    cmake -S meshlab_plugin -B "$work/$version-$scalar" -DMESHLAB_SOURCE_DIR="$work/source" \
        -DMESHLAB_VERSION="$version" -DMESHLAB_BUILD_WITH_DOUBLE_SCALAR=$double \
        -DMOULAGE_LIBRARY="$libraries/libmoulage.a" >/dev/null
    cmake --build "$work/$version-$scalar" -j 2
    plugin=$work/$version-$scalar/libfilter_moulage.so
    if nm -D --defined-only "$plugin" | grep -E ' mlg_'; then
        echo "the library's functions must stay inside the filter"
        exit 1
    fi
done

export QT_QPA_PLATFORM=offscreen
for wheel in 2025.07:2025.7.post1 2023.12:2023.12.post3; do
    version=${wheel%:*} package=${wheel#*:}
    venv=$work/venv-$version
    [ -x "$venv/bin/python" ] || python3 -m venv "$venv"
    "$venv/bin/pip" install -q 'numpy<2' "pymeshlab==$package"
    # All symbols at once, so that one that is missing shows.
    LD_BIND_NOW=1 "$venv/bin/python" tests/meshlab/filters.py "$work/$version-double/libfilter_moulage.so" "$work" \
        "$libraries/moulage"
    other=$([ "$version" = 2025.07 ] && echo 2023.12 || echo 2025.07)
    "$venv/bin/python" tests/meshlab/refused.py "$work/2025.07-float/libfilter_moulage.so" \
        "different floating point precision"
    "$venv/bin/python" tests/meshlab/refused.py "$work/$other-double/libfilter_moulage.so" \
        "different version"
done
echo "meshlab: good"
