"""Filling a surface with tets, and runs."""

from collections import namedtuple

import numpy

from . import interface, native
from .shapes import Handle

Progress = namedtuple(
    "Progress", "ended iteration fraction energy mean_error max_error seconds stage"
)
Progress.__doc__ = """Where a run stands; lengths in the template's unit, NaN while unknown."""


class Run(Handle):
    """A computation that runs on a thread of the library; when it is garbage, or its `with` block is left, it is
    cancelled."""

    kind = "run"

    def __init__(self, handle, waiting, result):
        super().__init__(handle)
        self._waiting, self._result = waiting, result

    def poll(self):
        now = native.fill("run_poll", self._handle, interface.MlgProgress())
        now["ended"] = now.pop("state") == interface.RUN_ENDED
        now["stage"] = now["stage"].decode("utf-8", "replace")
        return Progress(**now)

    def cancel(self):
        """Asks it to stop; of a reshaping the best shape so far stays available."""
        native.get("run_cancel", self._handle)

    def preview_points(self):
        """The latest points of the surface (n, 3), or None before there are any."""
        return native.preview(self._handle)

    def wait(self):
        """Waits for the end and hands the result over, once. Ctrl-C cancels the run."""
        return follow(self)

    def wait_for(self, seconds):
        """Waits for the end, so long at most, and tells whether it has come; `wait` then hands the result over. Ctrl-C is
        heard afterwards."""
        state = native.c_uint32()
        native.call("run_wait_for", self._handle, seconds, native.byref(state))
        return state.value == interface.RUN_ENDED

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.cancel()

    def _hand_over(self):
        return self._result._take(native.make(self._waiting, self._handle))


def follow(run, progress=None):
    """Waits for a run and returns its result. `progress(Progress)` is called some times a second; when it
    returns False the run is cancelled."""
    try:
        while True:
            now = run.poll()
            if progress is not None and progress(now) is False:
                run.cancel()
            if now.ended:
                return run._hand_over()
            run.wait_for(0.2)
    except BaseException:
        # Ctrl-C, or an error of `progress`: nobody waits any more, though the traceback may keep the run alive.
        run.cancel()
        raise


class Tetrahedralization(Handle):
    """Tets that carry a surface."""

    kind = "tetrahedralization"

    def __init__(self, surface, method="auto", tet_count=15000, tetgen=None):
        """`method`: auto, tetgen or lattice. `tetgen`: path of the program TetGen."""
        # By a run: Ctrl-C reaches it.
        made = self.start(surface, method, tet_count, tetgen).wait()
        super().__init__(made._handle)
        made._handle = None

    @classmethod
    def start(cls, surface, method="auto", tet_count=15000, tetgen=None):
        """The same without waiting: a Run whose result are the tets."""
        options = _tet_options(method, tet_count, tetgen)
        run = native.make("tetrahedralization_start", surface._handle, options)
        return Run(run, "run_wait_tetrahedralization", cls)

    @classmethod
    def from_tets(cls, surface, tets):
        """Takes tets made elsewhere."""
        return cls._take(native.make("tetrahedralization_from_tets", surface._handle, tets._handle))

    @property
    def points(self):
        return native.borrowed("tetrahedralization_points", self._handle, 3, numpy.float64)

    @property
    def tets(self):
        return native.borrowed("tetrahedralization_tets", self._handle, 4, numpy.uint32)

    @property
    def inside_fractions(self):
        """The share of each tet inside the surface, 0 to 1."""
        return native.borrowed("tetrahedralization_inside_fractions", self._handle, 1, numpy.float64)

    @property
    def method(self):
        """What made the tets: tetgen, lattice or given."""
        number = native.get("tetrahedralization_method", self._handle)
        return next(name for name, value in interface.TETS.items() if value == number)

    @property
    def boundary_kept(self):
        """Whether the surface's own triangles are the boundary of the tets."""
        return native.get("tetrahedralization_boundary_kept", self._handle) == 1

    @property
    def warnings(self):
        count = native.get("tetrahedralization_warning_count", self._handle)
        lines = (native.get("tetrahedralization_warning", self._handle, i) for i in range(count))
        return [line.decode("utf-8") for line in lines]

    @property
    def quality(self):
        """A dict: tet_count, inverted_count, volume, min_dihedral, max_dihedral (degrees), ..."""
        return quality(self._handle, "tetrahedralization_quality")


def _tet_options(method, tet_count, tetgen):
    if method not in ("auto", "tetgen", "lattice"):
        raise ValueError(f"method {method!r} is not known; auto, tetgen and lattice are")
    program = native.path(tetgen) if tetgen else None
    wishes = {"method": interface.TETS[method], "tet_count": tet_count, "tetgen_path": program}
    return native.options("tetrahedralization", interface.MlgTetrahedralizationOptions(), wishes)


def quality(handle, function):
    found = native.fill(function, handle, interface.MlgTetQuality())
    found["dihedral_histogram"] = list(found["dihedral_histogram"])
    return found
