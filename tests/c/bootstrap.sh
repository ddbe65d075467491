#!/bin/sh
# A compiler that takes -Zsanitizer, not yet a stable part of it. For moulage's own crate alone: the build scripts of other
# crates ask for this variable, and would run again.
RUSTC_BOOTSTRAP=1 exec "$@"
