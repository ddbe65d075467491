#!/usr/bin/env bash
# The C programs with the library itself under AddressSanitizer: the one that `cargo fuzz build` makes.
set -euo pipefail
cd "$(dirname "$0")/../.."
library=$(echo fuzz/target/*/release/deps/libmoulage.so)
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

nm -D --undefined-only "$library" | grep -q __asan_init || { echo "$library was built without AddressSanitizer"; exit 1; }
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
