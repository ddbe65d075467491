#!/usr/bin/env bash
# Cargo with Clippy on the way: its compiler lints the crates of the workspace and compiles them as rustc does. So nothing
# is compiled a second time for the lints alone; `cargo clippy` would check all dependencies again.
#   tests/cargo.sh COMMAND...
set -euo pipefail
export RUSTC_WORKSPACE_WRAPPER=clippy-driver
# As `cargo clippy -- -D warnings` passes it on.
export CLIPPY_ARGS=-Dwarnings__CLIPPY_HACKERY__
exec cargo "$@"
