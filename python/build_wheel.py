"""Makes the wheel of the package `moulage` with the native library that cargo built.

    python3 python/build_wheel.py OUT_FOLDER [FOLDER_OF_THE_LIBRARY]

The library is that of `cargo build --release` if no folder is given. It is called through ctypes, so one wheel serves
every Python 3.
"""

import base64
import hashlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# Times in the zip are fixed, so that the same input gives the same file.
STAMP = (2020, 1, 1, 0, 0, 0)


def version():
    return re.search(r'^version = "(.+)"', (ROOT / "Cargo.toml").read_text(), re.M).group(1)


def platform_tag():
    return sysconfig.get_platform().replace("-", "_").replace(".", "_")


def wheel_name():
    return f"moulage-{version()}-py3-none-{platform_tag()}.whl"


def native_library(folder):
    names = {"win32": "moulage.dll", "darwin": "libmoulage.dylib"}
    path = folder / names.get(sys.platform, "libmoulage.so")
    if not path.is_file():
        sys.exit(f"{path} is not there; run cargo build --release --lib first")
    return path


def stripped(path):
    """The library without debugging information, where the system has `strip`."""
    if shutil.which("strip") is None:
        return path.read_bytes()
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / path.name
        options = ["-x"] if sys.platform == "darwin" else ["--strip-unneeded"]
        subprocess.run(["strip", *options, "-o", copy, path], check=True)
        return copy.read_bytes()


def metadata():
    return f"""Metadata-Version: 2.4
Name: moulage
Version: {version()}
Summary: Puts a template of an organ or bone into one person's shape
License-Expression: MIT OR Apache-2.0
License-File: LICENSE-MIT
License-File: LICENSE-APACHE
Requires-Python: >=3.10
Requires-Dist: numpy
"""


def contents(library):
    """All files of the wheel: name and bytes."""
    info = f"moulage-{version()}.dist-info"
    yield f"moulage/{library.name}", stripped(library)
    for file in sorted((ROOT / "python" / "moulage").glob("*.py")):
        yield f"moulage/{file.name}", file.read_bytes()
    for name in ("LICENSE-MIT", "LICENSE-APACHE"):
        yield f"{info}/licenses/{name}", (ROOT / name).read_bytes()
    yield f"{info}/METADATA", metadata().encode()
    tag = f"py3-none-{platform_tag()}"
    yield f"{info}/WHEEL", f"Wheel-Version: 1.0\nGenerator: moulage\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()


def build(folder, libraries):
    library = native_library(libraries)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / wheel_name()
    record = []
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, data in contents(library):
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record.append(f"{name},sha256={digest},{len(data)}\n")
            add(wheel, name, data)
        name = f"moulage-{version()}.dist-info/RECORD"
        add(wheel, name, "".join([*record, f"{name},,\n"]).encode())
    return path


def add(archive, name, data):
    entry = zipfile.ZipInfo(name, STAMP)
    entry.compress_type = zipfile.ZIP_DEFLATED
    entry.external_attr = 0o644 << 16
    archive.writestr(entry, data)


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    print(build(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) == 3 else ROOT / "target" / "release"))
