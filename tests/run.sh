#!/usr/bin/env bash
# The one test command: installs what the tests need, builds once, runs every part, closes with a table.
#   tests/run.sh            everything
#   tests/run.sh quick      before each commit
#   tests/run.sh core c     some parts; windows, sdist and fuzz run only when they are named
# A part is tests/PART/run.sh; what it prints is in target/tests/PART.log, too.
set -uo pipefail
cd "$(dirname "$0")/.."

all=(core c images workflow report opensim python blender meshlab)
# Debian's packages for each part; those for everybody come first.
declare -A packages=(
    [build]="gcc python3"
    [core]="tetgen"
    [c]="g++ cmake pkg-config valgrind binutils tetgen"
    [images]="python3-venv"
    [workflow]="python3-venv"
    [report]="python3-venv tetgen chromium"
    [opensim]="python3-venv"
    [python]="python3-venv tetgen libegl1 libgl1 libgl1-mesa-dri"
    [sdist]="python3-venv tetgen libegl1 libgl1 libgl1-mesa-dri"
    [blender]="python3-venv tetgen blender python3-numpy xvfb xauth imagemagick
        libgl1-mesa-dri libegl1 libgl1 libx11-6 libxrender1 libxfixes3 libxi6 libxkbcommon0 libsm6 libice6"
    [meshlab]="python3-venv g++ make cmake binutils xz-utils ca-certificates
        libqt5opengl5-dev libglew-dev libeigen3-dev libgl1 libopengl0"
    [windows]="debootstrap python3-venv"
    [quick]="tetgen"
    [fuzz]="g++"
)

parts=("${@:-${all[@]}}")
for part in "${parts[@]}"; do
    [ -f "tests/$part/run.sh" ] || { echo "there is no part $part; the parts are ${all[*]} quick fuzz sdist windows"; exit 2; }
done

install_packages() {
    local missing=()
    for package in "$@"; do
        dpkg -s "$package" >/dev/null 2>&1 || missing+=("$package")
    done
    [ ${#missing[@]} -eq 0 ] && return
    apt-get update -qq &&
        DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
}

# step NAME COMMAND...: one line of the table. A step that fails does not hide the others.
rows=() failed=0
step() {
    local name=$1 began=$SECONDS log=target/tests/$1.log ended=good
    shift
    echo "== $name"
    "$@" 2>&1 | tee "$log" || { ended=FAILED failed=1; }
    rows+=("$(printf '%-10s %7d  %-9s %s' "$name" $((SECONDS - began)) "$(tests/count.sh "$log")" "$ended")")
}

mkdir -p target/tests
step install install_packages ${packages[build]} $(for part in "${parts[@]}"; do echo "${packages[$part]}"; done)
step build tests/watchdog.py tests/build.sh
if [ $failed -eq 0 ]; then
    for part in "${parts[@]}"; do
        step "$part" tests/watchdog.py bash "tests/$part/run.sh"
    done
fi

printf '\n%-10s %7s  %-9s %s\n' part seconds tests ended
printf '%s\n' "${rows[@]}"
printf '%-10s %7d\n' all "$SECONDS"
exit $failed
