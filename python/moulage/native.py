"""The one file that calls the library: finds and loads it, and turns statuses into exceptions."""

from __future__ import annotations

import ctypes
import dataclasses
import os
import sys
import threading
from collections.abc import Sequence
from ctypes import byref, c_char_p, c_size_t, c_uint32, c_void_p
from pathlib import Path
from typing import Any

import numpy
from numpy.typing import ArrayLike, NDArray

from .interface import ABI_VERSION, CALLS, GETTERS, STATUS, MlgError, MlgSlicePlane
from .versioned import Versioned
from .whole_numbers import checked


# The `status` of the Error of a run that was cancelled before it had a result.
CANCELLED = STATUS.index("cancelled")


class LibraryError(ImportError):
    """The native library is missing, damaged or of another version."""


class Error(RuntimeError):
    """A call failed; the text is the library's sentence.

    Attributes
    ----------
    status : int
        Its number, as in the C header's ``MlgStatus``; ``CANCELLED`` for a run that was cancelled before it had a result.
    """

    def __init__(self, status: int, message: str) -> None:
        super().__init__(message)
        self.status = status


def file_name() -> str:
    """What the library is called on this system."""
    if sys.platform == "win32":
        return "moulage.dll"
    return "libmoulage.dylib" if sys.platform == "darwin" else "libmoulage.so"


def library_path() -> Path:
    """MOULAGE_LIBRARY if it is set, else beside this file, else what cargo has built here."""
    named = os.environ.get("MOULAGE_LIBRARY")
    if named:
        return Path(named).absolute()
    here = Path(__file__).resolve().parent
    built = here.parent.parent / "target" / "release" / file_name()
    beside = here / file_name()
    return built if built.is_file() and not beside.is_file() else beside


_loaded: Any = None
_loading = threading.Lock()
# Whether this is a child, by fork alone, of a process that had the library loaded: its threads are not here, whoever
# waits for them waits for ever.
forked = False


def _in_forked_child() -> None:
    global forked, _loading
    forked, _loading = _loaded is not None, threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_in_forked_child)


def library() -> Any:
    """The library, loaded and checked once; LibraryError says what is wrong with it."""
    global _loaded
    if forked:
        raise LibraryError(
            "This process was forked from one that had moulage loaded, and the library's threads are not here. Start "
            "processes by multiprocessing.get_context('spawn')."
        )
    with _loading:
        if _loaded is None:
            _loaded = _load(library_path())
    return _loaded


def _load(path: Path) -> Any:
    if not path.is_file():
        raise LibraryError(f"The moulage library is missing: there is no {path}. Install moulage again.")
    try:
        # Never unloaded: its threads would go on in memory that is gone.
        found = ctypes.CDLL(str(path))
    except OSError as error:
        raise LibraryError(
            f"The moulage library {path} cannot be loaded on this system ({error}). "
            "Install the moulage that was made for it."
        ) from error
    try:
        version = found.mlg_abi_version
    except AttributeError:
        raise LibraryError(f"{path} is not the moulage library. Install moulage again.") from None
    version.restype = c_uint32
    if version() != ABI_VERSION:
        raise LibraryError(
            f"The moulage library {path} is of another version (interface {version()}, this needs "
            f"{ABI_VERSION}). Install moulage again, and restart the program."
        )
    try:
        for name, arguments in CALLS.items():
            function = getattr(found, f"mlg_{name}")
            function.restype, function.argtypes = c_uint32, arguments
        for name, kinds in GETTERS.items():
            function = getattr(found, f"mlg_{name}")
            function.restype, function.argtypes = kinds[0], kinds[1:]
    except AttributeError as error:
        raise LibraryError(
            f"The moulage library {path} is older than this package ({error}). Install moulage again."
        ) from None
    return found


def get(name: str, *arguments: Any) -> Any:
    """Calls a function that cannot fail."""
    return getattr(library(), f"mlg_{name}")(*checked(GETTERS[name][1:], arguments))


def call(name: str, *arguments: Any) -> None:
    """Calls a function that can fail; raises its sentence."""
    error = MlgError()
    status = getattr(library(), f"mlg_{name}")(*checked(CALLS[name], arguments), byref(error))
    if status != 0:
        raise Error(status, error.message.decode("utf-8", "replace"))


def make(name: str, *arguments: Any) -> Any:
    """Calls a function whose output is a handle."""
    handle = c_void_p()
    call(name, *arguments, byref(handle))
    return handle.value


def fill(name: str, handle: Any, struct: Versioned) -> dict[str, Any]:
    """Calls a function that fills a struct; returns its fields."""
    call(name, handle, byref(struct))
    return struct.fields()


def options(struct: Versioned, init: str, wishes: Any, **instead: Any) -> Any:
    """A struct of options with its defaults and then the fields of the caller's dataclass, or what stands for them."""
    get(init, byref(struct), ctypes.sizeof(struct))
    values = {field.name: getattr(wishes, field.name) for field in dataclasses.fields(wishes)} | instead
    for name, value in values.items():
        setattr(struct, name, value)
    return struct


def array(values: ArrayLike, width: int, kind: Any, name: str) -> NDArray[Any]:
    """Rows of `width` numbers for a call: contiguous, and of the right shape or refused."""
    values = numpy.asarray(values)
    shape = (width,) if width > 1 else ()
    if values.size == 0:
        return numpy.zeros((0, *shape), kind)
    if values.ndim == 0 or values.shape[1:] != shape:
        raise ValueError(f"{name}: shape {values.shape} where {('n', *shape)} is needed")
    if kind == numpy.uint32 and ((values % 1 != 0).any() or values.min() < 0 or values.max() > 0xFFFFFFFF):
        raise ValueError(f"{name}: indices are whole numbers from 0 to {0xFFFFFFFF}")
    return numpy.ascontiguousarray(values, kind)


def address(values: NDArray[Any] | None) -> int | None:
    """Where an array lies; the caller keeps it alive during the call."""
    return None if values is None or values.size == 0 else values.ctypes.data


def borrowed(name: str, handle: Any, width: int, kind: Any, *index: int) -> NDArray[Any]:
    """A copy of an array that a handle lends; of the part with a number, if one is given."""
    count = c_size_t()
    values = get(name, handle, *index, byref(count))
    shape = (width,) if width > 1 else ()
    if index and not values:
        raise IndexError(f"there is no number {index[0]}; they are counted from 0")
    if not values or count.value == 0:
        return numpy.zeros((0, *shape), kind)
    return numpy.ctypeslib.as_array(values, (count.value, *shape)).astype(kind)


def floats(name: str, handle: Any, width: int, *index: int) -> NDArray[numpy.float64]:
    """The same of real numbers."""
    return borrowed(name, handle, width, numpy.float64, *index)


def indices(name: str, handle: Any, width: int, *index: int) -> NDArray[numpy.uint32]:
    """The same of numbers of points."""
    return borrowed(name, handle, width, numpy.uint32, *index)


def texts(values: Sequence[str | None] | None) -> Any:
    """Names for a call, or None for none."""
    if values is None:
        return None
    return (c_char_p * len(values))(*(None if v is None else v.encode("utf-8") for v in values))


def label(name: str, handle: Any, *index: int) -> str | None:
    """A name or sentence that a handle lends, or None."""
    found = get(name, handle, *index)
    return None if found is None else found.decode("utf-8", "replace")


def text(name: str, handle: Any, *index: int) -> str:
    """A text that the library writes into a buffer; of the part with a number, if one is given."""
    length = c_size_t()
    call(name, handle, *index, None, 0, byref(length))
    buffer = ctypes.create_string_buffer(length.value + 1)
    call(name, handle, *index, ctypes.addressof(buffer), len(buffer), byref(length))
    return buffer.value.decode("utf-8", "replace")


def slice_plane(corner: ArrayLike, right: ArrayLike, down: ArrayLike, width: int, height: int) -> MlgSlicePlane:
    """A plane for a call."""
    plane = MlgSlicePlane()
    plane.corner[:], plane.right[:], plane.down[:] = corner, right, down
    plane.width, plane.height = width, height
    return plane


def preview(handle: Any) -> NDArray[numpy.float64] | None:
    """The latest points of a run, or None before there are any."""
    count = c_size_t()
    call("run_preview_points", handle, None, 0, byref(count))
    if count.value == 0:
        return None
    points = numpy.empty((count.value, 3))
    call("run_preview_points", handle, address(points), len(points), byref(count))
    return points


def path(name: str | os.PathLike[str]) -> bytes:
    """A path as the library takes it."""
    return os.fsencode(name)
