#!/usr/bin/env bash
# All that is given away, from one command, on Linux (Debian, as root), into dist/:
#   moulage-VERSION-SYSTEM.tar.gz, .zip            program, library, headers, CMake package, for linux-x64, windows-x64, macos-arm64, macos-x64
#   moulage-VERSION-py3-none-PLATFORM.whl          the Python package, for each system; moulage-VERSION.tar.gz: its source
#   moulage-blender-VERSION-SYSTEM[-legacy].zip    the Blender extension; legacy: the add-on for Blender 3.4 to 4.1
#   moulage-VERSION-meshlab-MESHLAB-PRECISION-linux-x64.zip    the MeshLab filter, for each version and precision
#   SHA256SUMS
#   release/build.sh [SYSTEM...]    some systems only
# What is for macOS has been linked and checked here, and run nowhere.
set -euo pipefail
cd "$(dirname "$0")/.."
systems=("${@:-}")
[ -n "${systems[0]}" ] || systems=(linux-x64 windows-x64 macos-arm64 macos-x64)
# As a wheel names the systems.
declare -A platforms=([linux-x64]=linux_x86_64 [windows-x64]=win_amd64 [macos-arm64]=macosx_11_0_arm64 [macos-x64]=macosx_11_0_x86_64)
# What goes into the names, and the times in the archives, for all that is called here.
VERSION=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
export VERSION SOURCE_DATE_EPOCH=1577836800
rm -rf dist
mkdir dist
packages=(debootstrap gcc g++ cmake make binutils python3-venv xz-utils ca-certificates
    libqt5opengl5-dev libglew-dev libeigen3-dev libgl1 libopengl0)
dpkg -s "${packages[@]}" >/dev/null 2>&1 ||
    { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${packages[@]}"; }

for system in "${systems[@]}"; do
    echo "== $system"
    built=$(release/compile.sh "$system")
    release/package.sh "$system" "$built" dist
    MOULAGE_PLATFORM=${platforms[$system]} python/build.sh dist "$built"
    if [ "$system" = linux-x64 ]; then release/meshlab.sh "$built" dist; fi
done
python3 blender_addon/pack.py dist/moulage-*.whl
(cd dist && sha256sum ./* >SHA256SUMS && cat SHA256SUMS)
