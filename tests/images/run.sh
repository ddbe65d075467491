#!/usr/bin/env bash
# Images written by other programs, compared with what SimpleITK sees; called by tests/run.sh.
set -euo pipefail
cd "$(dirname "$0")/../.."
built=$(tests/build.sh)
tools=$(tests/venv.sh images python3 numpy pillow pydicom SimpleITK)
"$tools/bin/python" tests/images/formats.py "$built/moulage"
echo "images: good"
