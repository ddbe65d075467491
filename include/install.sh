#!/usr/bin/env bash
# Builds the library and installs it for C and C++ on Linux: headers, shared and static library,
# pkg-config file, CMake package.
#   include/install.sh PREFIX [LIBRARIES]    the libraries in the folder LIBRARIES (default: built now)
set -euo pipefail
cd "$(dirname "$0")/.."
prefix=$(realpath -m "${1:?where to install, such as /usr/local}")
built=${2:-}
if [ -z "$built" ]; then
    cargo build --release
    built=${CARGO_TARGET_DIR:-target}/release
fi
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
soname=libmoulage.so.${version%.*}

install -D -m 644 -t "$prefix/include" include/moulage.h include/moulage.hpp
install -D -m 644 -t "$prefix/include/moulage" include/moulage/*.hpp
install -D -m 755 "$built/libmoulage.so" "$prefix/lib/libmoulage.so.$version"
ln -sf "libmoulage.so.$version" "$prefix/lib/$soname"
ln -sf "$soname" "$prefix/lib/libmoulage.so"
install -D -m 644 -t "$prefix/lib" "$built/libmoulage.a"
mkdir -p "$prefix/lib/pkgconfig" "$prefix/lib/cmake/moulage"
fill=(-e "s|@PREFIX@|$prefix|" -e "s|@VERSION@|$version|" -e "s|@SERIES@|${version%.*}|")
sed "${fill[@]}" include/moulage.pc.in >"$prefix/lib/pkgconfig/moulage.pc"
for file in moulageConfig moulageConfigVersion; do
    sed "${fill[@]}" "include/$file.cmake.in" >"$prefix/lib/cmake/moulage/$file.cmake"
done
