#!/usr/bin/env bash
# Packs the MeshLab filter for each version and precision. What it is compiled with: tests/run.sh meshlab installs that.
#   release/meshlab.sh LIBRARIES FOLDER
set -euo pipefail
built=$(realpath "$1") out=$(realpath "$2")
cd "$(dirname "$0")/.."
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
sources=$(realpath -m target/cache/meshlab)
mkdir -p "$sources"
tests/meshlab/sources.sh "$sources"
for build in "2025.07 float desktop" "2025.07 double pymeshlab" "2023.12 float desktop" "2023.12 double pymeshlab"; do
    read -r meshlab scalar host <<<"$build"
    folder=target/release-meshlab/$meshlab-$scalar
    meshlab_plugin/build.sh "$sources/source" "$meshlab" "$scalar" "$built" "$folder"
    cp meshlab_plugin/LICENSE "$folder/LICENSE"
    (cd "$folder" && python3 -m zipfile -c "$out/moulage-$version-meshlab-$meshlab-$host-linux-x64.zip" libfilter_moulage.so LICENSE)
done
