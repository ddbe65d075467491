#!/usr/bin/env bash
# Installs the library into an empty prefix and builds consumers that know only that: by CMake and by
# pkg-config, with the shared library and with the static one.
#   tests/c/install.sh LIBRARIES
set -euo pipefail
libraries=$(realpath "$1")
cd "$(dirname "$0")/../.."
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
prefix=/opt/moulage
DESTDIR=$out/package include/install.sh "$prefix" "$libraries"
# Nothing knows where it was installed: the whole can be moved.
mv "$out/package$prefix" "$out/prefix"
prefix=$out/prefix

# by_cmake NAME LIBRARY...: programs with each of these targets, no others.
by_cmake() {
    cmake -S tests/c/consumer -B "$out/$1" -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
    cmake --build "$out/$1" >/dev/null
    for library in "${@:2}"; do "$out/$1/consumer_$library"; done
    [ "$(find "$out/$1" -maxdepth 1 -name 'consumer_*' | wc -l)" -eq $(($# - 1)) ]
}
by_cmake both moulage shared static
readelf -d "$out/both/consumer_static" | grep -F "[libmoulage" && { echo "the static program asks for the shared library"; exit 1; }
for library in libmoulage.so libmoulage.a; do
    readelf -S "$prefix/lib/$library" | grep -F .debug_info && { echo "$library is not stripped"; exit 1; }
done

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
by_cmake static_alone moulage static
echo "install: good"
