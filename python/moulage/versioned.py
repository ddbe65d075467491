"""Structs whose first field is their size."""

import ctypes
from typing import Any

from . import whole_numbers


class Versioned(ctypes.Structure):
    """Knows its size from the start, and refuses whole numbers that a field cannot hold."""

    def __init__(self) -> None:
        super().__init__()
        self.struct_size = ctypes.sizeof(self)

    def __setattr__(self, name: str, value: Any) -> None:
        kind = {field[0]: field[1] for field in self._fields_}.get(name)
        super().__setattr__(name, whole_numbers.whole(kind, value, name) if kind in whole_numbers.KINDS else value)

    def fields(self) -> dict[str, Any]:
        """The values by name, without the size."""
        return {name: getattr(self, name) for name, *_ in self._fields_[1:]}
