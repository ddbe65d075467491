#!/usr/bin/env bash
# Builds the filter for one version of MeshLab and one precision, as FOLDER/libfilter_moulage.so.
#   meshlab_plugin/build.sh SOURCES VERSION float|double LIBRARIES FOLDER
# SOURCES: of MeshLab 2025.07, whose headers serve 2023.12 too: what the filter uses has the same layout. float is the desktop
# program's precision, double PyMeshLab's. LIBRARIES: the folder of libmoulage.a.
set -euo pipefail
sources=$1 version=$2 scalar=$3 libraries=$4 folder=$5
cmake -S "$(dirname "$0")" -B "$folder" -DMESHLAB_SOURCE_DIR="$sources" -DMESHLAB_VERSION="$version" \
    -DMESHLAB_BUILD_WITH_DOUBLE_SCALAR="$([ "$scalar" = double ] && echo ON || echo OFF)" \
    -DMOULAGE_LIBRARY="$libraries/libmoulage.a" >/dev/null
cmake --build "$folder" -j 2
if nm -D --defined-only "$folder/libfilter_moulage.so" | grep -E ' mlg_'; then
    echo "the library's functions must stay inside the filter"
    exit 1
fi
