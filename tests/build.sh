#!/usr/bin/env bash
# The library and the program that all parts share, in the profile `dev`: it checks overflows and assertions, its dependencies
# are optimized. Prints the folder they lie in.
#   tests/build.sh [ARGUMENTS OF cargo build]
# Below tests/run.sh, which has built it, it only prints.
set -euo pipefail
cd "$(dirname "$0")/.."
[ -n "${MOULAGE_BUILT:-}" ] || tests/cargo.sh build "$@" >&2
realpath "${CARGO_TARGET_DIR:-target}/debug"
