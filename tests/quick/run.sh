#!/usr/bin/env bash
# For every commit: format, lints, layers, the C header, unit tests, one reshape and one register.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo fmt --all --check
tests/cargo.sh build --all-targets
tests/cargo.sh test --lib --test architecture --test example_liver --test register_hand
tests/cargo.sh test -p moulage-header
