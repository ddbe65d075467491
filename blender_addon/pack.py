# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs the add-on around wheels that python/build.sh made, for the system each of them is for, and beside it.

    python3 blender_addon/pack.py WHEEL...
"""

import re
import sys
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
# Times in the zip are fixed, so that the same input gives the same file.
STAMP = (2020, 1, 1, 0, 0, 0)
# Blender's names for systems, by the ends of the wheels' names.
PLATFORMS = {
    r"linux\w*_x86_64": "linux-x64", "win_amd64": "windows-x64", "win_arm64": "windows-arm64",
    r"macosx\w*_arm64": "macos-arm64", r"macosx\w*_x86_64": "macos-x64",
}
NOT_PACKED = {"build.sh", "pack.py"}


def platform(wheel):
    for end, name in PLATFORMS.items():
        if re.search(f"{end}$", wheel.stem):
            return name
    return sys.exit(f"Blender has no extensions for the system of {wheel.name}")


def sources():
    for path in sorted(HERE.rglob("*")):
        name = path.relative_to(HERE).as_posix()
        if path.is_file() and "__pycache__" not in name and name not in NOT_PACKED:
            yield name, path.read_bytes()


def add(archive, name, data):
    entry = zipfile.ZipInfo(name, STAMP)
    entry.compress_type = zipfile.ZIP_DEFLATED
    entry.external_attr = 0o644 << 16
    archive.writestr(entry, data)


def manifest(text, wheel):
    lines = text.rstrip().splitlines()
    at = lines.index("[permissions]")
    lines[at:at] = [f'platforms = ["{platform(wheel)}"]', f'wheels = ["./wheels/{wheel.name}"]', ""]
    return "\n".join(lines) + "\n"


def pack_extension(wheel, target):
    with zipfile.ZipFile(target, "w") as archive:
        for name, data in sources():
            add(archive, name, manifest(data.decode(), wheel).encode() if name == "blender_manifest.toml" else data)
        add(archive, f"wheels/{wheel.name}", wheel.read_bytes())


def pack_legacy(wheel, target):
    """Blender before 4.2 does not install wheels: the package lies in the add-on's folder."""
    with zipfile.ZipFile(target, "w") as archive, zipfile.ZipFile(wheel) as package:
        for name, data in sources():
            if name != "blender_manifest.toml":
                add(archive, f"moulage_blender/{name}", data)
        for name in (entry.filename for entry in package.infolist() if not entry.is_dir()):
            add(archive, f"moulage_blender/native/{name}", package.read(name))


def main(wheel):
    version = wheel.name.split("-")[1]
    for pack, ending in ((pack_extension, ""), (pack_legacy, "-legacy")):
        target = wheel.with_name(f"moulage-blender-{version}-{platform(wheel)}{ending}.zip")
        pack(wheel, target)
        print(target)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    for argument in sys.argv[1:]:
        main(Path(argument))
