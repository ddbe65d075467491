# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the Python package `moulage`, which holds the native library."""

import importlib
import importlib.util
import sys
from contextlib import contextmanager
from pathlib import Path

_HERE = Path(__file__).resolve().parent
# As a legacy add-on it lies in the add-on's folder; in the repository, beside it.
_PLACES = (_HERE / "native" / "moulage", _HERE.parent / "python" / "moulage")


class Wrong(Exception):
    """Something the user has to put right; the text says what and how."""


def moulage():
    """The package `moulage` with its library loaded; Wrong if that cannot be."""
    package = _package()
    try:
        package.check_library()
    except ImportError as error:
        raise Wrong(str(error)) from None
    return package


@contextmanager
def calls():
    """Hands out the package; what it refuses inside the block becomes Wrong."""
    package = moulage()
    try:
        yield package
    except package.Error as error:
        raise Wrong(sentence(str(error))) from None


def sentence(text):
    """The library's words as a sentence of its own."""
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")


def refusal(error):
    """What a RuntimeError of one of Blender's operators says."""
    return str(error).removeprefix("Error: ").strip()


def _package():
    """Installed as a wheel, or in one of the places above."""
    if "moulage" in sys.modules:
        return sys.modules["moulage"]
    try:
        return importlib.import_module("moulage")
    except ModuleNotFoundError as error:
        if error.name != "moulage":
            raise Wrong(f"Blender's Python lacks {error.name}. Install it, and start Blender again.") from None
    for place in _PLACES:
        if (place / "__init__.py").is_file():
            spec = importlib.util.spec_from_file_location(
                "moulage", place / "__init__.py", submodule_search_locations=[str(place)]
            )
            module = importlib.util.module_from_spec(spec)
            sys.modules["moulage"] = module
            spec.loader.exec_module(module)
            return module
    raise Wrong("The Python package moulage is missing. Install the add-on again from its zip file.")


def problem():
    """What is wrong with the library in one sentence, or None."""
    try:
        moulage()
    except Wrong as wrong:
        return str(wrong)
    return None
