#!/usr/bin/env bash
# Compiles library and program for one system, from Linux; prints the folder they lie in.
#   release/compile.sh linux-x64 | windows-x64 | macos-arm64 | macos-x64
# Linux: linked by zig for glibc 2.17, as the wheel is. Windows: by MinGW. macOS: by LLVM's linker, which exports no more than is asked
# for and signs for arm64. For Windows and macOS Rust's standard library is compiled, too: its source comes with the tree's compiler.
set -euo pipefail
cd "$(dirname "$0")/.."
tools=$(tests/venv.sh release python3 ziglang cargo-zigbuild lief)
build=(--locked --profile dist --lib --bins)

# in_tree TARGET VARIABLE...: prints the folder as the tree is left.
in_tree() {
    release/tree.sh env RUSTC_BOOTSTRAP=1 "${@:2}" cargo build "${build[@]}" --target "$1" -Zbuild-std=std,panic_unwind >&2
    realpath "target/cross/$1/dist"
}

# What is asked of Apple's SDK: our stubs, and libSystem as zig has it, in the words that LLVM's linker knows.
make_macos_sdk() {
    local sdk=target/cache/macos-sdk
    rm -rf "$sdk"
    cp -r release/macos_sdk "$sdk"
    sed 's/arm64e\(\.x1\)\?-/arm64-/g' "$tools"/lib/python*/site-packages/ziglang/lib/libc/darwin/libSystem.tbd >"$sdk/usr/lib/libSystem.tbd"
    ln -s libSystem.tbd "$sdk/usr/lib/libc.tbd"
    ln -s libSystem.tbd "$sdk/usr/lib/libm.tbd"
}

# for_macos TARGET VARIABLE_OF_ITS_LINKER
for_macos() {
    make_macos_sdk
    # What strips after linking would break the signature; there is nothing for debuggers in it anyway.
    in_tree "$1" "$2=/moulage/target/cache/macos-sdk/macos-ld" SDKROOT=/moulage/target/cache/macos-sdk CARGO_PROFILE_DIST_STRIP=none \
        MACOSX_DEPLOYMENT_TARGET=11.0
}

case ${1:?linux-x64, windows-x64, macos-arm64 or macos-x64} in
linux-x64)
    target=x86_64-unknown-linux-gnu
    PATH=$tools/bin:$PATH cargo zigbuild "${build[@]}" --target "$target.2.17" >&2
    realpath "${CARGO_TARGET_DIR:-target}/$target/dist"
    ;;
windows-x64)
    folder=$(in_tree x86_64-pc-windows-gnu CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER=x86_64-w64-mingw32-gcc)
    # For MSVC, which has import libraries of its own kind.
    { echo "LIBRARY moulage.dll" && echo EXPORTS && grep -oE '\bmlg_[a-z_]+\(' include/moulage.h | tr -d '(' | sort -u; } >"$folder/moulage.def"
    "$tools/bin/python" -m ziglang dlltool -m i386:x86-64 -d "$folder/moulage.def" -l "$folder/moulage.lib"
    echo "$folder"
    ;;
macos-arm64) for_macos aarch64-apple-darwin CARGO_TARGET_AARCH64_APPLE_DARWIN_LINKER ;;
macos-x64) for_macos x86_64-apple-darwin CARGO_TARGET_X86_64_APPLE_DARWIN_LINKER ;;
*) echo "$1: the systems are linux-x64, windows-x64, macos-arm64 and macos-x64" >&2 && exit 1 ;;
esac
