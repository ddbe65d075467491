#!/usr/bin/env bash
# Packs program, library, headers and CMake package for one system, and checks what was compiled; called by build.sh.
#   release/package.sh SYSTEM LIBRARIES FOLDER
set -euo pipefail
system=$1 built=$(realpath "$2") out=$(realpath "$3")
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
name=moulage-$VERSION-$system
root=$work/$name

case $system in
linux-x64) library=lib/libmoulage.so program=moulage ;;
windows-x64) library=bin/moulage.dll program=moulage.exe ;;
macos-*) library=lib/libmoulage.dylib program=moulage ;;
esac
# Only Linux has a standard library with what a debugger reads; the others' was compiled here.
[ "$system" = linux-x64 ] && strip=strip || strip=true
STRIP=$strip include/install.sh "$root" "$built"
install -D -m 755 "$built/$program" "$root/bin/$program"
install -m 644 -t "$root" LICENSE-APACHE LICENSE-MIT README.md CHANGELOG.md
"$(tests/venv.sh release)/bin/python" release/check.py "$root/$library"

if [ "$system" = windows-x64 ]; then
    (cd "$work" && python3 -m zipfile -c "$out/$name.zip" "$name")
else
    tar -C "$work" --sort=name --owner=0 --group=0 --numeric-owner --mtime="@$SOURCE_DATE_EPOCH" -cf - "$name" | gzip -n >"$out/$name.tar.gz"
fi
