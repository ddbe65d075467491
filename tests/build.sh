#!/usr/bin/env bash
# The one build that all parts share: the profile `dev`, which checks overflows and assertions, with optimized dependencies.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build
cargo test --no-run
