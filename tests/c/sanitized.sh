#!/usr/bin/env bash
# Builds the library under AddressSanitizer; prints the folder it lies in.
#   tests/c/sanitized.sh BUILT    the folder of the plain build
# Only moulage itself and what is generic in its dependencies is recompiled: that is where its `unsafe` code is. The
# allocator is watched for all.
set -euo pipefail
built=$(realpath "$1")
cd "$(dirname "$0")/../.."
folder=target/sanitized
rm -rf "$folder"
mkdir -p "$folder/debug"
# The dependencies that are compiled already.
tar --format=posix -C "$built" --exclude='*moulage*' -cf - deps build .fingerprint | tar -C "$folder/debug" -xf -
RUSTC_WORKSPACE_WRAPPER=$PWD/tests/c/bootstrap.sh cargo rustc --lib --crate-type cdylib --target-dir "$folder" -- -Zsanitizer=address >&2
needed=$(nm -D --undefined-only "$folder/debug/libmoulage.so")
[[ $needed == *__asan_init* ]] || { echo "the library was built without AddressSanitizer" >&2; exit 1; }
realpath "$folder/debug"
