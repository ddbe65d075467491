#!/usr/bin/env bash
# The one test command: installs what the tests need, builds once, runs every part, closes with a table.
#   tests/run.sh            everything
#   tests/run.sh quick      before each commit
#   tests/run.sh core c     some parts
# A part is tests/PART/run.sh; what it prints is in target/tests/PART.log, too. Two parts run side by side, each on half of the cores:
# most of them do one thing after the other.
set -uo pipefail
cd "$(dirname "$0")/.."

# The longest first, so that the two sides end together.
all=(window core blender c meshlab images workflow python)
# Debian's packages for each part; those for everybody come first.
declare -A packages=(
    [build]="gcc python3"
    [core]="tetgen"
    [c]="g++ cmake pkg-config valgrind binutils tetgen"
    [images]="python3-venv"
    [workflow]="python3-venv"
    [python]="python3-venv binutils"
    [blender]="python3-venv binutils tetgen blender python3-numpy libgl1 libx11-6 libxrender1 libxfixes3 libxi6 libxkbcommon0
        libsm6 libice6"
    [window]="binutils tetgen blender python3-numpy xvfb xauth imagemagick libgl1-mesa-dri libegl1"
    [meshlab]="python3-venv g++ make cmake binutils xz-utils ca-certificates
        libqt5opengl5-dev libglew-dev libeigen3-dev libgl1 libopengl0"
    [quick]="tetgen"
    [fuzz]="g++"
)

parts=("${@:-${all[@]}}")
for part in "${parts[@]}"; do
    [ -f "tests/$part/run.sh" ] || { echo "there is no part $part; the parts are ${all[*]} quick fuzz"; exit 2; }
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
step() {
    local name=$1 began=$SECONDS log=target/tests/$1.log ended=good
    shift
    echo "== $name"
    "$@" 2>&1 | tee "$log" | sed -u "s/^/$name: /" || ended=FAILED
    printf '%-10s %7d  %-9s %s\n' "$name" $((SECONDS - began)) "$(tests/count.sh "$log")" "$ended" >>"$table"
    [ $ended = good ]
}

# Readied once: Cargo locks its folder while it builds, and what is built must not change under the parts.
build() {
    local targets=
    [[ " ${parts[*]} " == *" core "* || " ${parts[*]} " == *" quick "* ]] && targets=--all-targets
    tests/watchdog.py tests/build.sh $targets
}

mkdir -p target/tests
export table=target/tests/table
: >"$table"
export -f step
step install install_packages ${packages[build]} $(for part in "${parts[@]}"; do echo "${packages[$part]}"; done) &&
    step build build &&
    printf '%s\n' "${parts[@]}" |
    MOULAGE_BUILT=yes xargs -P 2 --process-slot-var=side -I '{}' \
        bash -o pipefail -c 'step {} tests/side.py $side tests/watchdog.py bash tests/{}/run.sh'
ended=$?

printf '\n%-10s %7s  %-9s %s\n' part seconds tests ended
cat "$table"
printf '%-10s %7d\n' all "$SECONDS"
exit $ended
