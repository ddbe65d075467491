#!/usr/bin/env bash
# A Python environment with packages, kept under target/cache between runs; prints its folder.
#   tests/venv.sh NAME PYTHON PACKAGE...
#   tests/venv.sh NAME                     one that is there already
set -euo pipefail
folder=$(realpath -m "$(dirname "$0")/../target/cache/$1")
[ $# -gt 1 ] || { echo "$folder" && exit; }
python=$2
shift 2
# Built again when other packages are asked for, when it was not finished, or when it was moved: its programs name its place.
asked="$folder: $*"
if [ "$(cat "$folder/packages" 2>/dev/null)" != "$asked" ]; then
    rm -rf "$folder"
    "$python" -m venv "$folder"
    "$folder/bin/pip" install --quiet --no-cache-dir "$@" >&2
    echo "$asked" >"$folder/packages"
fi
echo "$folder"
