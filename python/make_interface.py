#!/usr/bin/env python3
"""Makes python/moulage/interface.py from include/moulage.h: python/make_interface.py [--check]"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
HEADER, INTERFACE = ROOT / "include" / "moulage.h", ROOT / "python" / "moulage" / "interface.py"
WIDTH = 120

SCALARS = {
    "uint32_t": "c_uint32", "uint64_t": "c_uint64", "uint8_t": "c_uint8", "size_t": "c_size_t", "double": "c_double",
    "float": "c_float", "char": "c_char", "MlgStatus": "c_uint32",
}
# Constants that hosts take by name.
CHOICES = ("TETS", "ALIGN")
INTRODUCTION = '''"""What include/moulage.h declares, for ctypes: constants, structs, functions. Made by python/make_interface.py; do not
edit. Handles and arrays travel as plain addresses; `native` makes them."""

from ctypes import (
    POINTER, Structure, c_char, c_char_p, c_double, c_float, c_size_t, c_uint8, c_uint32, c_uint64, c_void_p,
)
from typing import Any

from .versioned import Versioned
'''


class Header:
    """What the header declares, in its order."""

    def __init__(self, text):
        text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
        self.constants = dict(re.findall(r"#define MLG_(\w+) (\S+)", text))
        self.enums = {
            name: re.findall(r"MLG_(\w+) = (\d+)", body)
            for body, name in re.findall(r"typedef enum \w+ \{(.*?)\} Mlg(\w+);", text, re.S)
        }
        self.structs = {
            name: [self._field(line.strip()) for line in body.split(";") if line.strip()]
            for body, name in re.findall(r"typedef struct \w+ \{(.*?)\} (\w+);", text, re.S)
        }
        self.functions = [
            (name, self._type(result), [self._argument(a) for a in arguments.split(",") if a.strip() != "void"])
            for result, name, arguments in re.findall(r"^(\w[\w ]*[ *])mlg_(\w+)\(([^)]*)\);", text, re.M)
        ]

    def _field(self, line):
        declared, name, length = re.fullmatch(r"(.*?)(\w+)(?:\[(\w+)\])?", line).groups()
        if length is None:
            return name, "c_char_p" if declared.strip() == "const char *" else self._type(declared, pointer="c_void_p")
        length = length.removeprefix("MLG_")
        return name, f"{SCALARS[declared.strip()]} * {self.constants.get(length, length)}"

    def _type(self, declared, pointer=None):
        """Of a result, or of a field where every pointer is the same."""
        declared = declared.strip()
        if declared == "void":
            return "None"
        if not declared.endswith("*"):
            return SCALARS[declared]
        if pointer:
            return pointer
        pointed = declared.removeprefix("const ").rstrip("* ")
        return "c_char_p" if pointed == "char" else f"POINTER({SCALARS[pointed]})"

    def _argument(self, argument):
        declared = re.fullmatch(r"(.*?)\w+", " ".join(argument.split())).group(1).strip()
        if declared == "const char *":
            return "c_char_p"
        if declared == "const char *const *":
            return "POINTER(c_char_p)"
        if declared == "size_t *":
            return "POINTER(c_size_t)"
        if declared.endswith("**"):
            return "POINTER(c_void_p)"
        if declared.endswith("*"):
            pointed = declared.removeprefix("const ").rstrip("* ")
            return f"POINTER({pointed})" if pointed in self.structs else "c_void_p"
        return SCALARS[declared]


def wrapped(name, parts):
    """An entry of a table, over several lines where it is long."""
    parts = [f"{part}," for part in parts]
    line = f'    "{name}": ({" ".join(parts).removesuffix(",") if len(parts) > 1 else "".join(parts)}),'
    if len(line) <= WIDTH:
        return [line]
    lines = [f'    "{name}": (', "       "]
    for part in parts:
        if len(lines[-1]) + 1 + len(part) > WIDTH:
            lines.append("       ")
        lines[-1] += f" {part}"
    return [*lines, "    ),"]


def table(name, entries):
    return [f"{name}: dict[str, tuple[Any, ...]] = {{", *(line for key, parts in entries for line in wrapped(key, parts)), "}"]


def interface(header):
    lines = [INTRODUCTION]
    lines += [f"{name} = {0xFFFFFFFF if value == 'UINT32_MAX' else value}" for name, value in header.constants.items()]
    for choice in CHOICES:
        names = [name for name in header.constants if name.startswith(f"{choice}_")]
        pairs = (f'"{name.removeprefix(choice + "_").lower()}": {name}' for name in names)
        lines.append(f"{choice} = {{{', '.join(pairs)}}}")
    for name, members in header.enums.items():
        assert [int(value) for _member, value in members] == list(range(len(members))), name
        names = (member.removeprefix(name.upper() + "_").lower() for member, _value in members)
        lines += [f"{name.upper()} = (", *(f'    "{name}",' for name in names), ")"]
    for name, fields in header.structs.items():
        base = "Versioned" if fields[0][0] == "struct_size" else "Structure"
        lines += ["", "", f"class {name}({base}):", "    _fields_ = ["]
        lines += [*(f'        ("{field}", {kind}),' for field, kind in fields), "    ]"]
    calls = [(name, kinds) for name, _result, kinds in header.functions if kinds and kinds[-1] == "POINTER(MlgError)"]
    values = [(name, [result, *kinds]) for name, result, kinds in header.functions if name not in dict(calls)]
    lines += ["", "", "# Functions that return a status; the last argument is the error.", *table("CALLS", calls)]
    lines += ["# Functions that return a value: its type, then the arguments.", *table("GETTERS", values)]
    return "\n".join(lines) + "\n"


made = interface(Header(HEADER.read_text()))
if "--check" not in sys.argv:
    INTERFACE.write_text(made)
elif INTERFACE.read_text() != made:
    sys.exit("python/moulage/interface.py is not what include/moulage.h declares now; run python/make_interface.py")
