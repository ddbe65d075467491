"""Whole numbers as C types hold them. ctypes alone would take another number in place of one that does not fit: -1 is
4294967295."""

import ctypes
import operator
from collections.abc import Iterable
from ctypes import c_size_t, c_uint32, c_uint64
from typing import Any

KINDS = (c_uint32, c_uint64, c_size_t)


def whole(kind: Any, value: Any, name: str = "") -> int:
    """The number, or ValueError."""
    largest = 2 ** (8 * ctypes.sizeof(kind)) - 1
    number = operator.index(value)
    if not 0 <= number <= largest:
        raise ValueError(f"{name and name + ': '}{number} where a whole number from 0 to {largest} is needed")
    return number


def checked(kinds: Iterable[Any], arguments: Iterable[Any]) -> list[Any]:
    """The arguments of a call, whole numbers checked."""
    return [whole(kind, value) if kind in KINDS else value for kind, value in zip(kinds, arguments)]
