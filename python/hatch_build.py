"""Puts the native library into the wheel: called by hatchling, see pyproject.toml.

The library is the file that MOULAGE_LIBRARY names, for the system that MOULAGE_PLATFORM names (as win_amd64),
else Cargo builds it for this one. It is called through ctypes, so one wheel serves every Python 3.
"""

import json
import os
import shutil
import subprocess
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


def built(root: Path) -> Path:
    """The library that Cargo builds, as Cargo names it."""
    if shutil.which("cargo") is None:
        raise SystemExit("There is no cargo here, which builds moulage's library: install Rust from https://rustup.rs")
    command = ["cargo", "build", "--locked", "--release", "--lib", "--message-format", "json-render-diagnostics"]
    told = subprocess.run(command, cwd=root, check=True, stdout=subprocess.PIPE, text=True).stdout
    files = [name for line in told.splitlines() for name in json.loads(line).get("filenames", [])]
    return next(Path(name) for name in files if Path(name).suffix in (".so", ".dylib", ".dll") and "moulage" in Path(name).name)


class LibraryHook(BuildHookInterface):  # type: ignore[type-arg,unused-ignore]
    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        # An editable installation takes the library from Cargo's folder.
        if version == "editable":
            return
        named = os.environ.get("MOULAGE_LIBRARY")
        library = Path(named) if named else built(Path(self.root))
        build_data["force_include"][str(library)] = f"moulage/{library.name}"
        build_data["pure_python"] = False
        platform = os.environ.get("MOULAGE_PLATFORM", sysconfig.get_platform())
        build_data["tag"] = f"py3-none-{platform.replace('-', '_').replace('.', '_')}"
