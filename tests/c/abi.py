#!/usr/bin/env python3
"""Compares the C interface with the one that was published: tests/c/abi.py [--update]

tests/c/abi-N.txt lists what programs built against ABI version N rely on: every function with its
arguments, every constant, and where every struct field lies. A line that is gone or different
breaks them: undo the change, or raise MLG_ABI_VERSION. New lines are welcome; --update adds them.
"""

import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
HEADER = ROOT / "include" / "moulage.h"


def entries():
    """One line per promise of the header."""
    text = subprocess.run(["gcc", "-E", "-P", "-xc", HEADER], check=True, capture_output=True, text=True).stdout
    text = re.sub(r"\s+", " ", text[text.index("typedef") :])
    source = HEADER.read_text()
    lines = [f"constant {n} {v}" for n, v in re.findall(r"#define (MLG_[A-Z0-9_]+) (\S+)", source)]
    for body, name in re.findall(r"typedef enum (?:\w+ )?\{([^}]*)\} (Mlg\w+);", text):
        lines += [f"constant {name}.{n} {v}" for n, v in re.findall(r"(\w+) = (\d+)", body)]
    for function in re.findall(r"[\w ]+[ *]mlg_\w+ ?\([^)]*\);", text):
        lines.append("function " + re.sub(r" ?([*(),;]) ?", r"\1", function.strip()).rstrip(";"))
    fields = []
    for body, name in re.findall(r"typedef struct (?:\w+ )?\{([^}]*)\} (Mlg\w+);", text):
        for field in body.split(";"):
            if field.strip():
                fields.append((name, re.search(r"(\w+)(?:\[[^\]]*\])*$", field.strip()).group(1)))
    return sorted(set(lines + layout(fields)))


def layout(fields):
    """Offsets and sizes of fields, as the compiler has them. Structs may grow, so their size is no
    promise."""
    with tempfile.TemporaryDirectory() as folder:
        source = pathlib.Path(folder, "layout.c")
        prints = "".join(
            f'printf("field {s}.{f} at %zu, %zu bytes\\n", offsetof({s}, {f}), sizeof((({s} *)0)->{f}));'
            for s, f in fields
        )
        source.write_text(
            f"#include <stddef.h>\n#include <stdio.h>\n#include \"moulage.h\"\nint main(void) {{ {prints} return 0; }}"
        )
        program = source.with_suffix("")
        subprocess.run(["gcc", f"-I{ROOT / 'include'}", source, "-o", program], check=True)
        return subprocess.run([program], check=True, capture_output=True, text=True).stdout.splitlines()


now = entries()
version = next(line.split()[2] for line in now if line.startswith("constant MLG_ABI_VERSION "))
# Versions of the library may rise without a break.
now = [line for line in now if not line.startswith("constant MLG_VERSION_")]
baseline = ROOT / "tests" / "c" / f"abi-{version}.txt"
known = baseline.read_text().splitlines() if baseline.exists() else []
broken = sorted(set(known) - set(now))
added = sorted(set(now) - set(known))
if broken:
    print("programs built against this ABI version would break without:", *broken, sep="\n  ")
    sys.exit(1)
if added and "--update" in sys.argv:
    baseline.write_text("\n".join(now) + "\n")
elif added:
    print(f"not in {baseline.name} yet; tests/c/abi.py --update adds:", *added, sep="\n  ")
    sys.exit(1)
kinds = [line.split()[0] for line in now]
print(f"abi {version}: {kinds.count('function')} functions, {kinds.count('field')} fields, {kinds.count('constant')} constants as published")
