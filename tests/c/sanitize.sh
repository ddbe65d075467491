#!/usr/bin/env bash
# The C programs with the library itself under AddressSanitizer.
set -euo pipefail
cd "$(dirname "$0")/../.."
host=$(rustc -vV | sed -n 's/^host: //p')
# The sanitizers are not yet stable parts of the compiler. Little optimization: quick to build.
RUSTC_BOOTSTRAP=1 RUSTFLAGS=-Zsanitizer=address CARGO_PROFILE_RELEASE_OPT_LEVEL=1 \
    cargo build --release --lib --no-default-features --target "$host" --target-dir target/sanitize
library=target/sanitize/$host/release/libmoulage.so
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

needed=$(nm -D --undefined-only "$library")
[[ $needed == *__asan_init* ]] || { echo "$library was built without AddressSanitizer"; exit 1; }
ln -s "$(realpath "$library")" "$out/$(readelf -d "$library" | sed -n 's/.*soname: \[\(.*\)\]/\1/p')"
flags=(-g -fsanitize=address,undefined -fno-sanitize-recover=all -Iinclude -Itests/c)
link=(-L"$(dirname "$library")" -Wl,-rpath,"$out" -lmoulage -lm)
for name in mistakes inputs images register models motions separate runs; do
    gcc -std=c99 "${flags[@]}" tests/c/$name.c -o "$out/$name" "${link[@]}"
done
"$out/mistakes"
"$out/inputs" "$out"
"$out/images" "$out"
"$out/register" "$out" quick
"$out/models" "$out"
"$out/motions" examples "$out"
"$out/separate" "$out" quick
"$out/runs" quick
g++ -std=c++17 "${flags[@]}" tests/c/raii.cpp -o "$out/raii" "${link[@]}"
"$out/raii"
echo "sanitize: good"
