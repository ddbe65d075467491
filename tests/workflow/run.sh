#!/usr/bin/env bash
# A small study through `moulage batch` and through the workflow: the same results, and a broken
# case that stops neither. Called by tests/run.sh.
set -euo pipefail
root=$(realpath "$(dirname "$0")/../..")
cd "$root"
moulage=$(tests/build.sh)/moulage
snakemake=$(tests/venv.sh workflow python3 snakemake)/bin/snakemake
study=$(mktemp -d)
trap 'rm -rf "$study"' EXIT
mkdir "$study/cases"
for share in 2 3 4; do
    awk -v n="$share" 'NR == 1 || NR % n == 0' "$root/examples/liver/markers.csv" >"$study/cases/markers_$share.csv"
    cat >"$study/cases/liver_$share.toml" <<TOML
template = '$root/examples/liver/template.obj'
markers = 'markers_$share.csv'
tolerance = 2
tets = 'lattice'
tet_count = 800
TOML
done
echo "template = 'no_such_file.obj'" >"$study/cases/broken.toml"

cd "$study"
status=0
"$moulage" batch cases/*.toml --jobs 2 -o batch || status=$?
[ "$status" -eq 1 ] || { echo "a batch with a broken case ended with $status, 1 was expected"; exit 1; }
grep -q '^broken,failed,.*no_such_file.obj' batch/table.csv
[ "$(grep -c ',good,' batch/table.csv)" -eq 3 ]

"$snakemake" -s "$root/workflow/Snakefile" --cores 2 --quiet all --config cases='cases/*.toml' out=flow moulage="$moulage"
cmp batch/table.csv flow/table.csv
for share in 2 3 4; do
    cmp "batch/liver_$share/result.obj" "flow/liver_$share/result.obj"
done
cmp batch/statistics/result/mean.obj flow/statistics/result/mean.obj
for case in liver_2 liver_3 liver_4 broken; do
    grep '"key"' "batch/$case/provenance.json" | cmp - <(grep '"key"' "flow/$case/provenance.json")
done

# Nothing is left to do, until an input changes.
"$snakemake" -s "$root/workflow/Snakefile" --cores 2 --config cases='cases/*.toml' out=flow moulage="$moulage" 2>&1 |
    grep -q 'Nothing to be done'
"$moulage" batch cases/liver_*.toml -o batch | grep -c 'good, kept' | grep -qx 3
sed -i '$d' cases/markers_2.csv
"$moulage" batch cases/liver_*.toml -o batch | grep -c 'good, kept' | grep -qx 2
echo "workflow: good"
