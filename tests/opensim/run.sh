#!/usr/bin/env bash
# Persons' models in OpenSim: they load, lie as the person, their muscles can pull, and a walk plays on them.
# Called by tests/run.sh.
set -euo pipefail
root=$(realpath "$(dirname "$0")/../..")
cd "$root"
MOULAGE_PROGRAM=$(tests/build.sh)/moulage
export MOULAGE_PROGRAM PYTHONDONTWRITEBYTECODE=1
venv=$(tests/venv.sh opensim python3.11 opensim==4.6 numpy)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
# OpenSim writes a log where it runs.
cd "$scratch"
"$venv/bin/python" "$root/tests/opensim/person.py" "$scratch" 2>&1 | tee said
if grep "Couldn't find file" said; then exit 1; fi
