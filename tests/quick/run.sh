#!/usr/bin/env bash
# For every commit: format, lints, layers, the C header, unit tests, one reshape and one register.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo fmt --all --check
cargo clippy --all-targets -- -D warnings
cargo test --lib --test architecture --test example_liver --test register_hand
cargo test -p moulage-header
