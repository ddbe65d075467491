#!/usr/bin/env bash
# The library and the program that all parts share, in the profile `dev`: it checks overflows and assertions, its dependencies
# are optimized. Prints the folder they lie in.
set -euo pipefail
cd "$(dirname "$0")/.."
tests/cargo.sh build >&2
realpath "${CARGO_TARGET_DIR:-target}/debug"
