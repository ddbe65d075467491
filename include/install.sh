#!/usr/bin/env bash
# Builds the library and installs it for C and C++: headers, shared and static library, pkg-config file, CMake package.
#   include/install.sh PREFIX [LIBRARIES]    the libraries in the folder LIBRARIES (default: built now), for the system they are of
# DESTDIR stands before PREFIX, for packages. Libraries are stripped by STRIP (default: strip).
set -euo pipefail
prefix=${1:?where to install, such as /usr/local} built=${2:-}
case $prefix in
/* | [A-Za-z]:*) ;;
*) prefix=$PWD/$prefix ;;
esac
[ -z "$built" ] || built=$(cd "$built" && pwd)
cd "$(dirname "$0")/.."
if [ -z "$built" ]; then
    cargo build --release --lib
    built=${CARGO_TARGET_DIR:-target}/release
fi
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
series=${version%.*}
root=${DESTDIR:-}$prefix
mkdir -p "$root/include/moulage" "$root/lib/pkgconfig" "$root/lib/cmake/moulage"

# put FILE NAME OPTIONS: a library, without what only a debugger reads.
put() {
    cp "$1" "$root/$2"
    "${STRIP:-strip}" "${@:3}" "$root/$2"
}

# needed: what the static library needs beside itself, as a linker's flags.
if [ -f "$built/moulage.dll" ]; then
    needed="-lntdll -luserenv -lws2_32"
    mkdir -p "$root/bin"
    put "$built/moulage.dll" bin/moulage.dll --strip-unneeded
    if [ -f "$built/moulage.dll.lib" ]; then
        # By MSVC, where a static library needs the runtime of the program it is linked into.
        cp "$built/moulage.dll.lib" "$root/lib/moulage.lib"
    else
        cp "$built/libmoulage.dll.a" "$built/moulage.lib" "$root/lib"
    fi
elif [ -f "$built/libmoulage.dylib" ]; then
    needed="-framework CoreFoundation -lc++ -liconv"
    put "$built/libmoulage.dylib" "lib/libmoulage.$version.dylib" -x
    ln -sf "libmoulage.$version.dylib" "$root/lib/libmoulage.$series.dylib"
    ln -sf "libmoulage.$series.dylib" "$root/lib/libmoulage.dylib"
else
    needed="-lgcc_s -lpthread -ldl -lm"
    put "$built/libmoulage.so" "lib/libmoulage.so.$version" --strip-unneeded
    ln -sf "libmoulage.so.$version" "$root/lib/libmoulage.so.$series"
    ln -sf "libmoulage.so.$series" "$root/lib/libmoulage.so"
fi
if [ -f "$built/libmoulage.a" ]; then
    put "$built/libmoulage.a" lib/libmoulage.a -S
fi

cp include/moulage.h include/moulage.hpp "$root/include"
cp include/moulage/*.hpp "$root/include/moulage"
fill=(-e "s|@VERSION@|$version|" -e "s|@SERIES@|$series|" -e "s|@NEEDED@|$needed|")
sed "${fill[@]}" include/moulage.pc.in >"$root/lib/pkgconfig/moulage.pc"
for file in moulageConfig moulageConfigVersion; do
    sed "${fill[@]}" "include/$file.cmake.in" >"$root/lib/cmake/moulage/$file.cmake"
done
