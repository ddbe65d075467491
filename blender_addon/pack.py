# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs the add-on for this machine's system, around the wheel that python/build_wheel.py made.

    python3 blender_addon/pack.py FOLDER_OF_THE_WHEEL
"""

import sys
import sysconfig
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "python"))

from build_wheel import add, version, wheel_name  # noqa: E402

# Blender's names for platforms.
PLATFORMS = {
    "linux-x86_64": "linux-x64", "win-amd64": "windows-x64", "win-arm64": "windows-arm64",
    "macosx-arm64": "macos-arm64", "macosx-x86_64": "macos-x64",
}
NOT_PACKED = {"build.sh", "pack.py"}


def platform():
    own = sysconfig.get_platform()
    parts = own.split("-")
    found = PLATFORMS.get(own) or PLATFORMS.get(f"{parts[0]}-{parts[-1]}")
    return found or sys.exit(f"Blender has no extensions for {own}")


def sources():
    for path in sorted(HERE.rglob("*")):
        name = path.relative_to(HERE).as_posix()
        if path.is_file() and "__pycache__" not in name and name not in NOT_PACKED:
            yield name, path.read_bytes()


def manifest(text):
    lines = text.rstrip().splitlines()
    at = lines.index("[permissions]")
    lines[at:at] = [f'platforms = ["{platform()}"]', f'wheels = ["./wheels/{wheel_name()}"]', ""]
    return "\n".join(lines) + "\n"


def pack_extension(wheel, target):
    with zipfile.ZipFile(target, "w") as archive:
        for name, data in sources():
            add(archive, name, manifest(data.decode()).encode() if name == "blender_manifest.toml" else data)
        add(archive, f"wheels/{wheel.name}", wheel.read_bytes())


def pack_legacy(wheel, target):
    """Blender before 4.2 does not install wheels: the package lies in the add-on's folder."""
    with zipfile.ZipFile(target, "w") as archive, zipfile.ZipFile(wheel) as package:
        for name, data in sources():
            if name != "blender_manifest.toml":
                add(archive, f"moulage_blender/{name}", data)
        for name in package.namelist():
            add(archive, f"moulage_blender/native/{name}", package.read(name))


def main(folder):
    wheel = folder / wheel_name()
    if not wheel.is_file():
        sys.exit(f"{wheel} is not there; run blender_addon/build.sh")
    name = f"moulage-{version()}-{platform()}"
    for pack, target in ((pack_extension, f"{name}.zip"), (pack_legacy, f"{name}-legacy.zip")):
        pack(wheel, folder / target)
        print(folder / target)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
