"""What every object of the library is to Python."""

from __future__ import annotations

from typing import Any, NoReturn, TypeVar

from . import native

Owner = TypeVar("Owner", bound="Handle")


class Handle:
    """Owns something of the library until it is garbage. Subclasses name their kind."""

    kind = ""
    _handle: Any

    def __init__(self, handle: Any) -> None:
        self._handle = handle

    @property
    def _as_parameter_(self) -> Any:
        """What ctypes passes on for this; whoever passes the object itself keeps it alive during the call."""
        return self._handle

    @classmethod
    def _take(cls: type[Owner], handle: Any) -> Owner:
        """Wraps a handle made by another call."""
        new = cls.__new__(cls)
        Handle.__init__(new, handle)
        return new

    def __del__(self) -> None:
        handle, self._handle = getattr(self, "_handle", None), None
        if handle and native is not None and not native.forked:
            native.get(f"{self.kind}_free", handle)

    def __reduce_ex__(self, _protocol: Any) -> NoReturn:
        # The copy would free what this still has; in another process its number means something else or nothing.
        raise TypeError(f"a {type(self).__name__} cannot be copied or pickled: pass its arrays, or a file it is saved to")
