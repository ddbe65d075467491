#!/usr/bin/env bash
# The filter in the desktop program, with pictures: MeshLab of Debian unstable in a folder of its own,
# on a display of its own. As root; FOLDER takes some gigabytes. By hand, not part of tests/run.sh.
#   tests/meshlab/desktop.sh FOLDER PICTURES
set -euo pipefail
cd "$(dirname "$0")/../.."
work=$(realpath -m "$1") pictures=$(realpath -m "$2")
root=$work/unstable
mkdir -p "$work" "$pictures"
tests/meshlab/sources.sh "$work"
mirror=$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' | grep -E '/debian/?$' | head -1)

if [ ! -x "$root/usr/bin/meshlab" ]; then
    command -v debootstrap >/dev/null || apt-get install -y -qq debootstrap
    debootstrap --variant=minbase sid "$root" "$mirror"
    # The last four of the first line are missing among the package's own dependencies.
    chroot "$root" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
        meshlab libmuparser2v5 libqhull-r8.0 lib3ds-1-3 libopenctm1 \
        xvfb xauth openbox xdotool imagemagick libgl1-mesa-dri
fi

built=$(tests/build.sh)
meshlab_plugin/build.sh "$work/source" 2025.07 float "$built" "$work/2025.07-float"
plugins=$root/root/.local/share/VCG/MeshLab_64bit_fp/MeshLabExtraPlugins/2025.07
mkdir -p "$plugins" "$root/session"
cp "$work/2025.07-float/libfilter_moulage.so" "$plugins/"
cp examples/liver/template.obj tests/meshlab/session.sh "$root/session/"
# The clicks as a layer: a point cloud.
python3 - examples/liver/markers.csv "$root/session/markers.xyz" <<'PY'
import csv, sys
rows = csv.DictReader(line for line in open(sys.argv[1]) if not line.startswith("#"))
with open(sys.argv[2], "w") as out:
    out.writelines(f"{r['x_mm']} {r['y_mm']} {r['z_mm']}\n" for r in rows)
PY
mount --bind /proc "$root/proc" 2>/dev/null || true
trap 'umount "$root/proc" 2>/dev/null || true' EXIT
chroot "$root" env HOME=/root LIBGL_ALWAYS_SOFTWARE=1 \
    xvfb-run -a -s '-screen 0 1280x800x24' bash /session/session.sh
cp "$root"/session/meshlab-*.png "$pictures/"
grep -E '308 markers: mean distance|markers: distance to the surface' "$root/session/log" ||
    { tail -20 "$root/session/log"; echo "the filters said nothing"; exit 1; }
