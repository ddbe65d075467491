#!/usr/bin/env bash
# Installs the library into an empty prefix and builds consumers against it by CMake and, where
# cargo-c made the pkg-config file, by pkg-config.
#   tests/c/install.sh PREFIX
set -euo pipefail
cd "$(dirname "$0")/../.."
prefix=$(realpath -m "${1:?where to install}")
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)

if cargo cinstall --version >/dev/null 2>&1; then
    cargo cinstall --prefix "$prefix" --libdir lib
else
    cargo build
    install -D -m 644 include/moulage.h "$prefix/include/moulage.h"
    install -D -m 755 "${CARGO_TARGET_DIR:-target}/debug/libmoulage.so" "$prefix/lib/libmoulage.so"
fi
install -D -m 644 include/moulage.hpp "$prefix/include/moulage.hpp"
mkdir -p "$prefix/lib/cmake/moulage"
sed "s/@VERSION@/$version/" include/moulageConfig.cmake.in \
    > "$prefix/lib/cmake/moulage/moulageConfig.cmake"

out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
cmake -S tests/c/consumer -B "$out/cmake" -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
cmake --build "$out/cmake" >/dev/null
"$out/cmake/consumer"
if [ -f "$prefix/lib/pkgconfig/moulage.pc" ]; then
    export PKG_CONFIG_PATH="$prefix/lib/pkgconfig"
    # shellcheck disable=SC2046 # flags are words
    g++ -std=c++17 tests/c/consumer/consumer.cpp -o "$out/consumer" \
        $(pkg-config --cflags --libs moulage) -Wl,-rpath,"$prefix/lib"
    "$out/consumer"
fi
