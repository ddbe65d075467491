#!/usr/bin/env bash
# Windows, from Linux: program and library are compiled by MinGW and run under Wine, the C tests against the installed package,
# the program against Linux's bytes. By hand: it takes a Debian tree of 4 GB. Called by tests/run.sh windows.
set -euo pipefail
cd "$(dirname "$0")/../.."
linux=$(tests/build.sh)
windows=$(release/compile.sh windows-x64)
work=target/windows
rm -rf "$work"
mkdir -p "$work"
STRIP=true include/install.sh "$work/moulage" "$windows"

echo "== C and C++ under Wine"
release/tree.sh cmake -S tests/c -B "$work/c" -DCMAKE_PREFIX_PATH="/moulage/$work/moulage" -DCMAKE_SYSTEM_NAME=Windows \
    -DCMAKE_C_COMPILER=x86_64-w64-mingw32-gcc -DCMAKE_CXX_COMPILER=x86_64-w64-mingw32-g++ \
    -DCMAKE_CROSSCOMPILING_EMULATOR=/usr/bin/wine >/dev/null
release/tree.sh cmake --build "$work/c" -j 2 >/dev/null
release/tree.sh ctest --test-dir "$work/c" --output-on-failure
echo "ctest: good"

echo "== the program under Wine"
python3 tests/windows/program.py "$linux/moulage" "$windows/moulage.exe"
