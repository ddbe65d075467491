#!/usr/bin/env bash
# Format, lints, the C header and the Rust tests; called by tests/run.sh.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo fmt --all --check
cargo clippy --all-targets -- -D warnings
cargo test
cargo clippy -p moulage-header --all-targets -- -D warnings
cargo test -p moulage-header
