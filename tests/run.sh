#!/usr/bin/env bash
# The one test command: installs what the tests need and runs them.
#   tests/run.sh          all parts
#   tests/run.sh core     one part
set -euo pipefail
cd "$(dirname "$0")/.."
# Everything is built once: what a second build would save is not worth its gigabytes.
export CARGO_INCREMENTAL=0

parts=(core c images workflow python blender meshlab)

install_debian() {
    local missing=()
    for package in "$@"; do
        dpkg -s "$package" >/dev/null 2>&1 || missing+=("$package")
    done
    if [ ${#missing[@]} -gt 0 ]; then
        apt-get update -qq
        DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
    fi
}

run_core() {
    install_debian tetgen
    cargo fmt --all --check
    cargo clippy --all-targets -- -D warnings
    cargo test
}

run_c() {
    install_debian gcc g++ cmake pkg-config valgrind binutils python3 tetgen
    bash tests/c/run.sh
    bash tests/c/sanitize.sh
    rm -rf target/sanitize
    bash tests/c/install.sh
}

# The Python package: its wheel in a fresh environment.
run_python() {
    install_debian python3 python3-venv gcc binutils
    cargo build --release --lib
    rm -rf target/python
    python3 python/build_wheel.py target/python
    python3 -m venv target/python/venv
    target/python/venv/bin/pip install -q target/python/*.whl
    target/python/venv/bin/python tests/python/test_package.py
}

# The add-on in bpy 4.2, 4.5 and 5.0 and in Debian's Blender, there also in a window.
run_blender() {
    install_debian python3 python3-venv gcc binutils tetgen blender python3-numpy xvfb xauth imagemagick \
        libgl1-mesa-dri libegl1 libgl1 libx11-6 libxrender1 libxfixes3 libxi6 libxkbcommon0 libsm6 libice6
    rm -rf dist
    blender_addon/build.sh
    cargo build --release
    tests/blender/run.sh dist
}

# Images written by other programs, compared with what SimpleITK sees.
run_images() {
    install_debian python3-venv
    cargo build --release
    local tools
    tools=$(mktemp -d)
    python3 -m venv "$tools"
    "$tools/bin/pip" install --quiet numpy pillow pydicom SimpleITK
    "$tools/bin/python" tests/images/formats.py target/release/moulage
    rm -rf "$tools"
}

# A small study through `moulage batch` and through Snakemake: equal results.
run_workflow() {
    install_debian python3-venv
    cargo build --release
    local tools
    tools=$(mktemp -d)
    python3 -m venv "$tools"
    "$tools/bin/pip" install --quiet snakemake
    bash tests/workflow/run.sh target/release/moulage "$tools/bin/snakemake"
    rm -rf "$tools"
}

# The MeshLab filter, built from Debian's MeshLab sources, in PyMeshLab.
run_meshlab() {
    install_debian python3 python3-venv gcc g++ make cmake binutils xz-utils ca-certificates \
        libqt5opengl5-dev libglew-dev libeigen3-dev libgl1 libopengl0
    bash tests/meshlab/run.sh
}

# Every reader on made-up files, FUZZ_SECONDS each; a crash leaves its file in fuzz/artifacts.
run_fuzz() {
    install_debian gcc g++
    cargo fuzz --version >/dev/null 2>&1 || cargo install cargo-fuzz --locked
    # The sanitizers are not yet stable parts of the compiler.
    export RUSTC_BOOTSTRAP=1
    cargo fuzz build
    for target in $(cargo fuzz list); do
        mkdir -p "fuzz/corpus/$target" "fuzz/seeds/$target"
        cargo fuzz run "$target" "fuzz/corpus/$target" "fuzz/seeds/$target" -- \
            -max_total_time="${FUZZ_SECONDS:-20}" -rss_limit_mb=2048 -timeout=10
    done
}

for part in "${@:-${parts[@]}}"; do
    echo "== $part"
    "run_$part"
done
