#!/usr/bin/env bash
# C and C++ callers: strict compilers, sanitizers, valgrind, exported symbols.
# With CARGO_TARGET_DIR set, the library is built there.
set -euo pipefail
cd "$(dirname "$0")/../.."

cargo build
libraries=${CARGO_TARGET_DIR:-target}/debug
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

exported=$(nm -D --defined-only "$libraries/libmoulage.so" | awk '$2 == "T" { print $3 }' | sort)
declared=$(grep -oE '\bmlg_[a-z_]+\(' include/moulage.h | tr -d '(' | sort -u)
diff <(echo "$declared") <(echo "$exported") || { echo "exports and header differ"; exit 1; }

warnings=(-Wall -Wextra -Wconversion -Werror -pedantic)
sanitize=(-g -fsanitize=address,undefined -fno-sanitize-recover=all)
link=(-Iinclude -Itests/c -L"$libraries" -Wl,-rpath,"$(realpath "$libraries")" -lmoulage -lm)
for name in mistakes inputs runs; do
    gcc -std=c99 "${warnings[@]}" "${sanitize[@]}" tests/c/$name.c -o "$out/$name" "${link[@]}"
    "$out/$name" "$out"
    gcc -std=c99 "${warnings[@]}" -g tests/c/$name.c -o "$out/$name.plain" "${link[@]}"
done
gcc -std=c99 "${warnings[@]}" "${sanitize[@]}" tests/c/images.c -o "$out/images" "${link[@]}"
"$out/images" "$out/ball.mha"
g++ -std=c++17 "${warnings[@]}" "${sanitize[@]}" tests/c/raii.cpp -o "$out/raii" "${link[@]}"
"$out/raii"
g++ -std=c++17 "${warnings[@]}" examples/cpp/reshape.cpp -o "$out/reshape_cpp" "${link[@]}"
gcc -std=c99 -D_POSIX_C_SOURCE=200809L "${warnings[@]}" examples/c/reshape.c -o "$out/reshape_c" "${link[@]}"

if command -v valgrind >/dev/null; then
    check=(valgrind --quiet --error-exitcode=9 --leak-check=full --show-leak-kinds=definite --errors-for-leak-kinds=definite)
    "${check[@]}" "$out/mistakes.plain"
    "${check[@]}" "$out/inputs.plain" "$out"
    "${check[@]}" "$out/runs.plain" quick
fi
echo "c: good"
