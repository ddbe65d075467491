#!/usr/bin/env bash
# C and C++ callers: strict compilers, sanitizers, valgrind, exported symbols, the published ABI.
# With CARGO_TARGET_DIR set, the library is built there.
set -euo pipefail
cd "$(dirname "$0")/../.."

cargo build --release
libraries=$(realpath "${CARGO_TARGET_DIR:-target}/release")
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

exported=$(nm -D --defined-only "$libraries/libmoulage.so" | awk '$2 == "T" { print $3 }' | sort)
declared=$(grep -oE '\bmlg_[a-z_]+\(' include/moulage.h | tr -d '(' | sort -u)
diff <(echo "$declared") <(echo "$exported") || { echo "exports and header differ"; exit 1; }
tests/c/abi.py

# Programs ask for the library by its versioned name.
ln -s "$libraries/libmoulage.so" "$out/$(readelf -d "$libraries/libmoulage.so" | sed -n 's/.*soname: \[\(.*\)\]/\1/p')"
warnings=(-Wall -Wextra -Wconversion -Werror -pedantic)
sanitize=(-g -fsanitize=address,undefined -fno-sanitize-recover=all)
link=(-Iinclude -Itests/c -L"$libraries" -Wl,-rpath,"$out" -lmoulage -lm)
for name in mistakes inputs images register models separate runs; do
    gcc -std=c99 "${warnings[@]}" "${sanitize[@]}" tests/c/$name.c -o "$out/$name" "${link[@]}"
    "$out/$name" "$out"
    gcc -std=c99 "${warnings[@]}" -g tests/c/$name.c -o "$out/$name.plain" "${link[@]}"
done
gcc -std=c99 "${warnings[@]}" "${sanitize[@]}" tests/c/motions.c -o "$out/motions" "${link[@]}"
"$out/motions" examples "$out"
g++ -std=c++17 "${warnings[@]}" "${sanitize[@]}" tests/c/raii.cpp -o "$out/raii" "${link[@]}"
"$out/raii"
g++ -std=c++17 "${warnings[@]}" examples/cpp/reshape.cpp -o "$out/reshape_cpp" "${link[@]}"
gcc -std=c99 -D_POSIX_C_SOURCE=200809L "${warnings[@]}" examples/c/reshape.c -o "$out/reshape_c" "${link[@]}"

# The examples by C and by the command line: the same bytes.
gcc -std=c99 "${warnings[@]}" tests/c/examples.c -o "$out/examples" "${link[@]}"
mkdir -p "$out/c/hand" "$out/cli"
"$out/examples" examples "$out/c"
"$libraries/moulage" reshape examples/liver/job.toml -o "$out/cli/liver.obj" \
    --tets-out "$out/cli/liver.vtu" --report "$out/cli/report" >/dev/null
"$libraries/moulage" register examples/hand/skeleton.json \
    --target examples/hand/target_surface.ply -o "$out/cli/hand" >/dev/null
cmp "$out/c/liver.obj" "$out/cli/liver.obj"
cmp "$out/c/liver.vtu" "$out/cli/liver.vtu"
diff -r "$out/c/hand/bones" "$out/cli/hand/bones"
"$libraries/moulage" convert "$out/walk.mot" "$out/cli/walk.bvh" --skeleton examples/hand/skeleton.json >/dev/null
"$libraries/moulage" convert examples/hand/skeleton.json "$out/cli/walk.glb" --motion "$out/walk.mot" >/dev/null
cmp "$out/walk.bvh" "$out/cli/walk.bvh"
cmp "$out/walk.glb" "$out/cli/walk.glb"
"$libraries/moulage" separate "$out/left.vtu" "$out/right.vtu" --surfaces "$out/left.obj" "$out/right.obj" -o "$out/cli/apart" >/dev/null
"$out/separate" "$out" "$out/cli/apart"

# Inlined frames are not asked for: reading them takes minutes.
check=(valgrind --quiet --read-inline-info=no --error-exitcode=9 --leak-check=full --show-leak-kinds=definite --errors-for-leak-kinds=definite)
"${check[@]}" "$out/mistakes.plain"
"${check[@]}" "$out/inputs.plain" "$out"
"${check[@]}" "$out/runs.plain" quick
echo "c: good"
