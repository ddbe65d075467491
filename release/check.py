"""Checks libraries that were compiled for other systems: what they export, ask for, and how they are named.

    target/cache/release/bin/python release/check.py LIBRARY...
"""

import re
import sys
from pathlib import Path

import lief

ROOT = Path(__file__).resolve().parent.parent
SERIES = ".".join(re.search(r'^version = "(.*)"', (ROOT / "Cargo.toml").read_text(), re.M).group(1).split(".")[:2])
DECLARED = set(re.findall(r"\bmlg_[a-z_]+(?=\()", (ROOT / "include/moulage.h").read_text()))
# What every installation of the system has.
SYSTEM = {
    "ELF": {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "libgcc_s.so.1", "ld-linux-x86-64.so.2"},
    "PE": {"kernel32.dll", "ntdll.dll", "bcryptprimitives.dll", "msvcrt.dll", "userenv.dll", "ws2_32.dll", "advapi32.dll"},
    "MACHO": {
        "/usr/lib/libSystem.B.dylib", "/usr/lib/libc++.1.dylib", "/usr/lib/libiconv.2.dylib", "/usr/lib/libobjc.A.dylib",
        "/System/Library/Frameworks/CoreFoundation.framework/Versions/A/CoreFoundation",
    },
}


def faults_of_elf(binary):
    """Named by its series, and at home with the glibc of 2012."""
    if binary[lief.ELF.DynamicEntry.TAG.SONAME].name != f"libmoulage.so.{SERIES}":
        yield f"is named {binary[lief.ELF.DynamicEntry.TAG.SONAME].name}"
    needed = {aux.name for version in binary.symbols_version_requirement for aux in version.get_auxiliary_symbols()}
    glibc = [name for name in needed if name.startswith("GLIBC_")]
    newer = sorted(name for name in glibc if tuple(map(int, name[6:].split("."))) > (2, 17))
    if newer:
        yield f"asks for {newer}"


def faults_of_macho(binary):
    """Named for @rpath, at home in macOS 11, and signed where the system runs nothing unsigned."""
    arm = binary.header.cpu_type == lief.MachO.Header.CPU_TYPE.ARM64
    identity = next(c for c in binary.commands if c.command == lief.MachO.LoadCommand.TYPE.ID_DYLIB)
    if identity.name != f"@rpath/libmoulage.{SERIES}.dylib":
        yield f"is named {identity.name}"
    oldest = binary.build_version.minos if binary.has_build_version else binary.version_min.version
    if tuple(oldest)[:2] > (11, 0):
        yield f"asks for macOS {oldest}"
    if arm and not binary.has_code_signature:
        yield "is not signed"


def faults(path):
    binary = lief.parse(str(path))
    kind = binary.format.name
    if kind == "MACHO":
        exported = {symbol.name.removeprefix("_") for symbol in binary.exported_symbols}
        needed = {library.name for library in binary.libraries} - {f"@rpath/libmoulage.{SERIES}.dylib"}
    elif kind == "PE":
        exported = {entry.name for entry in binary.get_export().entries}
        needed = {entry.name.lower() for entry in binary.imports if not entry.name.startswith("api-ms-win-")}
    else:
        exported = {symbol.name for symbol in binary.exported_symbols}
        needed = set(binary.libraries)
    if exported != DECLARED:
        yield f"header and exports differ: {sorted(exported ^ DECLARED)[:9]}"
    if needed - SYSTEM[kind]:
        yield f"asks for {sorted(needed - SYSTEM[kind])}, which not every system has"
    yield from {"ELF": faults_of_elf, "MACHO": faults_of_macho}.get(kind, lambda binary: ())(binary)


def main(paths):
    found = [f"{path}: {fault}" for path in paths for fault in faults(path)]
    for path in paths:
        print(f"checked: {path}")
    sys.exit("\n".join(found) or 0)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main([Path(path) for path in sys.argv[1:]])
