#!/usr/bin/env bash
# Installs the library into an empty prefix and builds consumers that know only that: by CMake and by
# pkg-config, with the shared library and with the static one.
#   tests/c/install.sh LIBRARIES
set -euo pipefail
libraries=$(realpath "$1")
cd "$(dirname "$0")/../.."
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
prefix=$out/prefix
include/install.sh "$prefix" "$libraries"

by_cmake() {
    cmake -S tests/c/consumer -B "$out/$1" -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
    cmake --build "$out/$1" >/dev/null
    "$out/$1/consumer"
}
by_cmake shared_cmake

export PKG_CONFIG_PATH="$prefix/lib/pkgconfig"
read -ra flags <<<"$(pkg-config --cflags --libs moulage)"
g++ -std=c++17 tests/c/consumer/consumer.cpp -o "$out/shared" "${flags[@]}" -Wl,-rpath,"$prefix/lib"
"$out/shared"
version=$(pkg-config --modversion moulage)
readelf -d "$out/shared" | grep -qF "[libmoulage.so.${version%.*}]" ||
    { echo "the program asks for another library than libmoulage.so.${version%.*}"; exit 1; }
rm "$prefix"/lib/libmoulage.so*
read -ra flags <<<"$(pkg-config --cflags --static --libs moulage)"
g++ -std=c++17 tests/c/consumer/consumer.cpp -o "$out/static" "${flags[@]}"
"$out/static"
by_cmake static_cmake
echo "install: good"
