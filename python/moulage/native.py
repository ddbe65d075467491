"""The one file that knows the C interface (include/moulage.h): finds and loads the library, declares
its functions and structs, and turns statuses into exceptions."""

import ctypes
import os
import sys
import threading
from ctypes import POINTER, Structure, byref, c_char, c_char_p, c_double, c_size_t, c_uint8, c_uint32, c_void_p
from pathlib import Path

import numpy

ABI_VERSION = 1

TETS = {"auto": 0, "tetgen": 1, "lattice": 2, "given": 3}
STOPS = ("settled", "tolerance_met", "no_step", "iteration_limit", "cancelled")
ALIGN = {"rigid": 0, "similarity": 1}
NO_VERTEX = 0xFFFFFFFF
RUN_ENDED = 1
CANCELLED = 1


class LibraryError(ImportError):
    """The native library is missing, damaged or of another version."""


class Error(RuntimeError):
    """A call failed; the text is the library's sentence, `status` its number."""

    def __init__(self, status, message):
        super().__init__(message)
        self.status = status


class MlgError(Structure):
    _fields_ = [("status", c_uint32), ("message", c_char * 512)]


class Versioned(Structure):
    """A struct whose first field is its size."""

    def __init__(self):
        super().__init__()
        self.struct_size = ctypes.sizeof(self)

    def fields(self):
        """The values by name, without the size."""
        return {name: getattr(self, name) for name, _ in self._fields_[1:]}


class MlgTetrahedralizationOptions(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("method", c_uint32),
        ("tet_count", c_uint32),
        ("tetgen_path", c_char_p),
    ]


class MlgTetQuality(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("tet_count", c_uint32),
        ("inverted_count", c_uint32),
        ("volume", c_double),
        ("min_dihedral", c_double),
        ("max_dihedral", c_double),
        ("min_radius_ratio", c_double),
        ("mean_radius_ratio", c_double),
        ("dihedral_histogram", c_uint32 * 18),
    ]


class MlgReshapingOptions(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("tolerance", c_double),
        ("landmark_tolerance", c_double),
        ("attachment_tolerance", c_double),
        ("smoothness", c_double),
        ("screening", c_double),
        ("poisson", c_double),
        ("hard_attachments", c_uint32),
        ("max_iterations", c_uint32),
        ("thread_count", c_uint32),
        ("paper", c_uint32),
        ("reverse_term", c_uint32),
        ("reserved", c_uint32),
    ]


class MlgProgress(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("state", c_uint32),
        ("iteration", c_uint32),
        ("fraction", c_double),
        ("energy", c_double),
        ("mean_error", c_double),
        ("max_error", c_double),
        ("seconds", c_double),
        ("stage", c_char * 64),
    ]


class MlgVolumeInfo(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("size", c_size_t * 3),
        ("world_from_voxel", c_double * 12),
        ("spacing", c_double * 3),
        ("range", c_double * 2),
        ("window", c_double * 2),
        ("box_low", c_double * 3),
        ("box_high", c_double * 3),
    ]


class MlgSlicePlane(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("corner", c_double * 3),
        ("right", c_double * 3),
        ("down", c_double * 3),
        ("width", c_size_t),
        ("height", c_size_t),
    ]


class MlgReshapingSummary(Versioned):
    _fields_ = [
        ("struct_size", c_size_t),
        ("stop", c_uint32),
        ("iterations", c_uint32),
        ("newton_steps", c_uint32),
        ("inverted_tets", c_uint32),
        ("mean_marker_distance", c_double),
        ("max_marker_distance", c_double),
        ("seconds", c_double),
    ]


# Handles and arrays travel as plain addresses: `pointer` and `array` below make them.
_HANDLE, _ARRAY, _OUT, _ERROR = c_void_p, c_void_p, POINTER(c_void_p), POINTER(MlgError)
_COUNT, _OUT_COUNT, _PATH = c_size_t, POINTER(c_size_t), c_char_p
_PAIRS = (_HANDLE, _ARRAY, _ARRAY, _ARRAY, _COUNT, _ERROR)
_GETTER = (_HANDLE, _OUT_COUNT)

# Functions that return a status; the last argument is the error.
_CALLS = {
    "tri_mesh_new": (_ARRAY, _COUNT, _ARRAY, _COUNT, _OUT, _ERROR),
    "tri_mesh_load": (_PATH, _OUT, _ERROR),
    "tri_mesh_save": (_HANDLE, _ARRAY, _COUNT, _PATH, _ERROR),
    "tri_mesh_check": (_HANDLE, _ARRAY, _COUNT, _OUT_COUNT, _ERROR),
    "tri_mesh_align": (
        _HANDLE, c_uint32, _ARRAY, _COUNT, _ARRAY, _ARRAY, _COUNT, _ARRAY, _ERROR,
    ),
    "tri_mesh_section": (_HANDLE, _ARRAY, _COUNT, _ARRAY, _ARRAY, _OUT, _ERROR),
    "tet_mesh_new": (_ARRAY, _COUNT, _ARRAY, _COUNT, _OUT, _ERROR),
    "tet_mesh_load": (_PATH, _OUT, _ERROR),
    "tet_mesh_save": (_HANDLE, _PATH, _ERROR),
    "markers_new": (_ARRAY, _ARRAY, POINTER(c_char_p), _COUNT, _OUT, _ERROR),
    "markers_save": (_HANDLE, _PATH, _ERROR),
    "markers_load": (_PATH, _OUT, _ERROR),
    "tetrahedralization_run": (_HANDLE, POINTER(MlgTetrahedralizationOptions), _OUT, _ERROR),
    "tetrahedralization_start": (_HANDLE, POINTER(MlgTetrahedralizationOptions), _OUT, _ERROR),
    "tetrahedralization_from_tets": (_HANDLE, _HANDLE, _OUT, _ERROR),
    "tetrahedralization_quality": (_HANDLE, POINTER(MlgTetQuality), _ERROR),
    "pairs_load_landmarks": (_HANDLE, _PATH, _PATH, _OUT, _ERROR),
    "pairs_load_attachments": (_HANDLE, _PATH, c_uint32, _OUT, _ERROR),
    "pairs_from_bone": (_HANDLE, _HANDLE, _HANDLE, c_double, _OUT, _ERROR),
    "reshaping_new": (_HANDLE, _OUT, _ERROR),
    "reshaping_set_markers": (_HANDLE, _ARRAY, _ARRAY, _COUNT, _ERROR),
    "reshaping_set_landmarks": _PAIRS,
    "reshaping_set_landmarks_at_vertices": _PAIRS,
    "reshaping_set_attachments": _PAIRS,
    "reshaping_set_attachments_at_vertices": _PAIRS,
    "reshaping_set_fixed": (_HANDLE, _ARRAY, _COUNT, _ERROR),
    "reshaping_check": (_HANDLE, _ARRAY, _COUNT, _OUT_COUNT, _ERROR),
    "reshaping_start": (_HANDLE, POINTER(MlgReshapingOptions), _OUT, _ERROR),
    "run_poll": (_HANDLE, POINTER(MlgProgress), _ERROR),
    "run_preview_points": (_HANDLE, _ARRAY, _COUNT, _OUT_COUNT, _ERROR),
    "run_wait_tetrahedralization": (_HANDLE, _OUT, _ERROR),
    "run_wait_reshaping": (_HANDLE, _OUT, _ERROR),
    "volume_load": (_PATH, _OUT, _ERROR),
    "volume_info": (_HANDLE, POINTER(MlgVolumeInfo), _ERROR),
    "volume_notes": (_HANDLE, _ARRAY, _COUNT, _OUT_COUNT, _ERROR),
    "volume_plane": (_HANDLE, _ARRAY, c_double, c_double, POINTER(MlgSlicePlane), _ERROR),
    "volume_slice": (_HANDLE, POINTER(MlgSlicePlane), _ARRAY, c_uint32, _ARRAY, _COUNT, _ERROR),
    "reshaping_result_carry": (_HANDLE, _ARRAY, _COUNT, _ARRAY, _ERROR),
    "reshaping_result_summary": (_HANDLE, POINTER(MlgReshapingSummary), _ERROR),
    "reshaping_result_quality": (_HANDLE, POINTER(MlgTetQuality), _ERROR),
}
# Functions that return a value: its type, then the arguments.
_GETTERS = {
    "abi_version": (c_uint32,),
    "version_string": (c_char_p,),
    "tetrahedralization_options_init": (
        c_uint32, POINTER(MlgTetrahedralizationOptions), c_size_t,
    ),
    "reshaping_options_init": (c_uint32, POINTER(MlgReshapingOptions), c_size_t),
    "tri_mesh_points": (POINTER(c_double), *_GETTER),
    "tri_mesh_triangles": (POINTER(c_uint32), *_GETTER),
    "tet_mesh_points": (POINTER(c_double), *_GETTER),
    "tet_mesh_tets": (POINTER(c_uint32), *_GETTER),
    "markers_points": (POINTER(c_double), *_GETTER),
    "markers_weights": (POINTER(c_double), *_GETTER),
    "markers_label": (c_char_p, _HANDLE, c_size_t),
    "pairs_template_points": (POINTER(c_double), *_GETTER),
    "pairs_template_vertices": (POINTER(c_uint32), *_GETTER),
    "pairs_targets": (POINTER(c_double), *_GETTER),
    "pairs_weights": (POINTER(c_double), *_GETTER),
    "pairs_label": (c_char_p, _HANDLE, c_size_t),
    "pairs_warning": (c_char_p, _HANDLE),
    "tetrahedralization_points": (POINTER(c_double), *_GETTER),
    "tetrahedralization_tets": (POINTER(c_uint32), *_GETTER),
    "tetrahedralization_inside_fractions": (POINTER(c_double), *_GETTER),
    "tetrahedralization_method": (c_uint32, _HANDLE),
    "tetrahedralization_boundary_kept": (c_uint32, _HANDLE),
    "tetrahedralization_warning_count": (c_size_t, _HANDLE),
    "tetrahedralization_warning": (c_char_p, _HANDLE, c_size_t),
    "reshaping_result_points": (POINTER(c_double), *_GETTER),
    "reshaping_result_tet_points": (POINTER(c_double), *_GETTER),
    "reshaping_result_plastic_strains": (POINTER(c_double), *_GETTER),
    "reshaping_result_marker_distances": (POINTER(c_double), *_GETTER),
    "reshaping_result_max_stretches": (POINTER(c_double), *_GETTER),
    "reshaping_result_min_stretches": (POINTER(c_double), *_GETTER),
    "polylines_points": (POINTER(c_double), *_GETTER),
    "polylines_starts": (POINTER(c_size_t), *_GETTER),
    "polylines_closed": (POINTER(c_uint8), *_GETTER),
    "run_cancel": (None, _HANDLE),
    **{
        f"{kind}_free": (None, _HANDLE)
        for kind in ("tri_mesh", "tet_mesh", "markers", "pairs", "tetrahedralization", "reshaping",
                     "run", "reshaping_result", "volume", "polylines")
    },
}


def file_name():
    """What the library is called on this system."""
    if sys.platform == "win32":
        return "moulage.dll"
    return "libmoulage.dylib" if sys.platform == "darwin" else "libmoulage.so"


def library_path():
    """MOULAGE_LIBRARY if it is set, else beside this file, else what cargo has built here."""
    named = os.environ.get("MOULAGE_LIBRARY")
    if named:
        return Path(named).absolute()
    here = Path(__file__).resolve().parent
    built = here.parent.parent / "target" / "release" / file_name()
    beside = here / file_name()
    return built if built.is_file() and not beside.is_file() else beside


_loaded = None
_loading = threading.Lock()


def library():
    """The library, loaded and checked once; LibraryError says what is wrong with it."""
    global _loaded
    with _loading:
        if _loaded is None:
            _loaded = _load(library_path())
    return _loaded


def _load(path):
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
        for name, arguments in _CALLS.items():
            function = getattr(found, f"mlg_{name}")
            function.restype, function.argtypes = c_uint32, arguments
        for name, (result, *arguments) in _GETTERS.items():
            function = getattr(found, f"mlg_{name}")
            function.restype, function.argtypes = result, arguments
    except AttributeError as error:
        raise LibraryError(
            f"The moulage library {path} is older than this package ({error}). Install moulage again."
        ) from None
    return found


def get(name, *arguments):
    """Calls a function that cannot fail."""
    return getattr(library(), f"mlg_{name}")(*arguments)


def call(name, *arguments):
    """Calls a function that can fail; raises its sentence."""
    error = MlgError()
    status = getattr(library(), f"mlg_{name}")(*arguments, byref(error))
    if status != 0:
        raise Error(status, error.message.decode("utf-8", "replace"))


def make(name, *arguments):
    """Calls a function whose output is a handle."""
    handle = c_void_p()
    call(name, *arguments, byref(handle))
    return handle.value


def fill(name, handle, struct):
    """Calls a function that fills a struct; returns its fields."""
    call(name, handle, byref(struct))
    return struct.fields()


def options(name, struct, wishes):
    """A struct of options with its defaults and then the caller's wishes."""
    get(f"{name}_options_init", byref(struct), ctypes.sizeof(struct))
    known = struct.fields().keys() - {"reserved"}
    for key, value in wishes.items():
        if key not in known:
            raise TypeError(f"{key!r} is no option; there are {', '.join(sorted(known))}")
        setattr(struct, key, value)
    return struct


def array(values, width, kind, name):
    """Rows of `width` numbers for a call: contiguous, and of the right shape or refused."""
    values = numpy.asarray(values)
    shape = (width,) if width > 1 else ()
    if values.size == 0:
        return numpy.zeros((0, *shape), kind)
    if values.ndim == 0 or values.shape[1:] != shape:
        raise ValueError(f"{name}: shape {values.shape} where {('n', *shape)} is needed")
    if kind == numpy.uint32 and (values.min() < 0 or values.max() > 0xFFFFFFFF):
        raise ValueError(f"{name}: indices are 0 or more")
    return numpy.ascontiguousarray(values, kind)


def address(values):
    """Where an array lies; the caller keeps it alive during the call."""
    return None if values is None or values.size == 0 else values.ctypes.data


def borrowed(name, handle, width, kind):
    """A copy of an array that a handle lends."""
    count = c_size_t()
    values = get(name, handle, byref(count))
    shape = (width,) if width > 1 else ()
    if not values or count.value == 0:
        return numpy.zeros((0, *shape), kind)
    return numpy.ctypeslib.as_array(values, (count.value, *shape)).astype(kind)


def texts(values):
    """Names for a call, or None for none."""
    if values is None:
        return None
    return (c_char_p * len(values))(*(None if v is None else v.encode("utf-8") for v in values))


def label(name, handle, *index):
    """A name or sentence that a handle lends, or None."""
    found = get(name, handle, *index)
    return None if found is None else found.decode("utf-8", "replace")


def text(name, handle):
    """A text that the library writes into a buffer."""
    length = c_size_t()
    call(name, handle, None, 0, byref(length))
    buffer = ctypes.create_string_buffer(length.value + 1)
    call(name, handle, ctypes.addressof(buffer), len(buffer), byref(length))
    return buffer.value.decode("utf-8", "replace")


def slice_plane(corner, right, down, width, height):
    """A plane for a call."""
    plane = MlgSlicePlane()
    plane.corner[:], plane.right[:], plane.down[:] = corner, right, down
    plane.width, plane.height = width, height
    return plane


def preview(handle):
    """The latest points of a run, or None before there are any."""
    count = c_size_t()
    call("run_preview_points", handle, None, 0, byref(count))
    if count.value == 0:
        return None
    points = numpy.empty((count.value, 3))
    call("run_preview_points", handle, address(points), len(points), byref(count))
    return points


def path(name):
    """A path as the library takes it."""
    return os.fsencode(name)
