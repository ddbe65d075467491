#!/usr/bin/env bash
# Format, lints, the C header and the Rust tests; called by tests/run.sh.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo fmt --all --check
tests/cargo.sh build --all-targets
tests/cargo.sh test
tests/cargo.sh test -p moulage-header
