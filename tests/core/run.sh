#!/usr/bin/env bash
# Format, lints, the C header and the Rust tests; called by tests/run.sh.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo fmt --all --check
tests/build.sh --all-targets
tests/cargo.sh test
tests/cargo.sh test -p moulage-header
