#!/usr/bin/env bash
# C and C++ callers: strict compilers, sanitizers, valgrind, exported symbols, the published ABI, installing.
# Called by tests/run.sh.
set -euo pipefail
cd "$(dirname "$0")/../.."

built=$(tests/build.sh)
sanitized=$(tests/c/sanitized.sh "$built")
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

exported=$(nm -D --defined-only "$built/libmoulage.so" | awk '$2 == "T" { print $3 }' | sort)
declared=$(grep -oE '\bmlg_[a-z_]+\(' include/moulage.h | tr -d '(' | sort -u)
diff <(echo "$declared") <(echo "$exported") || { echo "exports and header differ"; exit 1; }
tests/c/abi.py

# Programs ask for the library by its versioned name.
name=$(readelf -d "$built/libmoulage.so" | sed -n 's/.*soname: \[\(.*\)\]/\1/p')
mkdir "$out/plain" "$out/sanitized"
ln -s "$built/libmoulage.so" "$out/plain/$name"
ln -s "$sanitized/libmoulage.so" "$out/sanitized/$name"
warnings=(-Wall -Wextra -Wconversion -Werror -pedantic -Iinclude -Itests/c)
c=(gcc -std=c99 "${warnings[@]}") cpp=(g++ -std=c++17 "${warnings[@]}")
sanitize=(-g -fsanitize=address,undefined -fno-sanitize-recover=all)
with_plain=(-L"$built" -Wl,-rpath,"$out/plain" -lmoulage -lm)
with_sanitized=(-L"$sanitized" -Wl,-rpath,"$out/sanitized" -lmoulage -lm)

# Program and library under AddressSanitizer, small.
for program in mistakes inputs images register models separate runs motions; do
    "${c[@]}" "${sanitize[@]}" "tests/c/$program.c" -o "$out/$program.sanitized" "${with_sanitized[@]}"
done
for program in mistakes inputs register separate runs; do
    "${c[@]}" -g "tests/c/$program.c" -o "$out/$program" "${with_plain[@]}"
done
for program in raii reach; do
    "${cpp[@]}" "${sanitize[@]}" -c "tests/c/$program.cpp" -o "$out/$program.o"
    "${cpp[@]}" "${sanitize[@]}" "$out/$program.o" -o "$out/$program.sanitized" "${with_sanitized[@]}"
done
# What the inline functions of moulage.hpp call is in a program only where they are called.
called=$(nm -u "$out/raii.o" "$out/reach.o" | grep -oE '\bmlg_[a-z_]+' | sort -u)
diff <(echo "$declared") <(echo "$called") || { echo "not called from C++"; exit 1; }
"$out/mistakes.sanitized"
"$out/inputs.sanitized" "$out"
"$out/images.sanitized" "$out"
"$out/register.sanitized" "$out" quick
"$out/models.sanitized" "$out"
"$out/motions.sanitized" examples "$out"
"$out/separate.sanitized" "$out" quick
"$out/runs.sanitized" quick
"$out/raii.sanitized"
"$out/reach.sanitized" examples "$out"

# Where the answer counts: in full, as it is used.
"$out/register" "$out"
"$out/runs"

# The examples by C and by the command line: the same bytes.
moulage=$built/moulage
"${cpp[@]}" examples/cpp/reshape.cpp -o "$out/reshape_cpp" "${with_plain[@]}"
"${c[@]}" -D_POSIX_C_SOURCE=200809L examples/c/reshape.c -o "$out/reshape_c" "${with_plain[@]}"
"${c[@]}" tests/c/examples.c -o "$out/examples" "${with_plain[@]}"
mkdir -p "$out/c/hand" "$out/cli"
"$out/examples" examples "$out/c"
"$moulage" reshape examples/liver/job.toml --tolerance 3 -o "$out/cli/liver.obj" \
    --tets-out "$out/cli/liver.vtu" --report "$out/cli/report" >/dev/null
"$moulage" register examples/hand/skeleton.json \
    --target examples/hand/target_surface.ply -o "$out/cli/hand" >/dev/null
cmp "$out/c/liver.obj" "$out/cli/liver.obj"
cmp "$out/c/liver.vtu" "$out/cli/liver.vtu"
diff -r "$out/c/hand/bones" "$out/cli/hand/bones"
"$moulage" convert "$out/walk.mot" "$out/cli/walk.bvh" --skeleton examples/hand/skeleton.json >/dev/null
"$moulage" convert examples/hand/skeleton.json "$out/cli/walk.glb" --motion "$out/walk.mot" >/dev/null
cmp "$out/walk.bvh" "$out/cli/walk.bvh"
cmp "$out/walk.glb" "$out/cli/walk.glb"
"$out/separate" "$out"
"$moulage" separate "$out/left.vtu" "$out/right.vtu" --surfaces "$out/left.obj" "$out/right.obj" -o "$out/cli/apart" >/dev/null
"$out/separate" "$out" "$out/cli/apart"
echo "examples: good"

# Inlined frames are not asked for: reading them takes minutes. Without the fair scheduler a thread that polls starves the
# one that works, for ten minutes and more.
check=(valgrind --fair-sched=yes --quiet --read-inline-info=no --error-exitcode=9 --leak-check=full --show-leak-kinds=definite --errors-for-leak-kinds=definite)
"${check[@]}" "$out/runs" quick &
runs=$!
"${check[@]}" "$out/mistakes"
"${check[@]}" "$out/inputs" "$out"
wait "$runs"

tests/c/install.sh "$built"
