#!/usr/bin/env bash
# Every reader on made-up files, FUZZ_SECONDS each; a crash leaves its file in fuzz/artifacts. Called by tests/run.sh fuzz.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo fuzz --version >/dev/null 2>&1 || cargo install cargo-fuzz --locked
# The sanitizers are not yet stable parts of the compiler.
export RUSTC_BOOTSTRAP=1
cargo fuzz build
for target in $(cargo fuzz list); do
    mkdir -p "fuzz/corpus/$target" "fuzz/seeds/$target"
    cargo fuzz run "$target" "fuzz/corpus/$target" "fuzz/seeds/$target" -- \
        -max_total_time="${FUZZ_SECONDS:-20}" -rss_limit_mb=2048 -timeout=10
done
