#!/usr/bin/env bash
# Packs the MeshLab filter for each version and precision; called by build.sh.
#   release/meshlab.sh LIBRARIES FOLDER
set -euo pipefail
built=$(realpath "$1") out=$(realpath "$2")
cd "$(dirname "$0")/.."
sources=$(realpath -m target/cache/meshlab)
tests/meshlab/sources.sh "$sources"
for build in "2025.07 float desktop" "2025.07 double pymeshlab" "2023.12 float desktop" "2023.12 double pymeshlab"; do
    read -r meshlab scalar host <<<"$build"
    folder=target/release-meshlab/$meshlab-$scalar
    meshlab_plugin/build.sh "$sources/source" "$meshlab" "$scalar" "$built" "$folder"
    cp meshlab_plugin/LICENSE "$folder/LICENSE"
    (cd "$folder" && python3 -m zipfile -c "$out/moulage-$VERSION-meshlab-$meshlab-$host-linux-x64.zip" libfilter_moulage.so LICENSE)
done
