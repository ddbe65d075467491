"""Computations on threads of the library: watched, stopped, waited for."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import byref, c_uint32
from typing import Any, Generic, NamedTuple, TypeVar

import numpy
from numpy.typing import NDArray

from . import interface, native
from .handles import Handle
from .progress_bar import ProgressBar

Result = TypeVar("Result")


class Progress(NamedTuple):
    """Where a run stands. Lengths are in the template's unit, NaN while they are unknown.

    Parameters
    ----------
    iteration : int
        Steps so far; of a reshaping on new tets counted from 0 again.
    fraction : float
        The share of the work that is done, 0 to 1, an estimate.
    energy : float
        What is minimized.
    mean_error, max_error : float
        How far the data are off.
    seconds : float
        Since the start.
    stage : str
        What is done now, in words.
    ended : bool
        Whether `Run.wait` returns at once.
    """

    iteration: int
    fraction: float
    energy: float
    mean_error: float
    max_error: float
    seconds: float
    stage: str
    ended: bool


# What a caller may give to follow a run: a function that returns False to stop it, or True for a bar.
Watcher = Callable[[Progress], object] | bool | None


class Run(Handle, Generic[Result]):
    """A computation that runs on a thread of the library, as the methods ``start`` return it.

    When it is garbage, or its ``with`` block is left, it is cancelled.
    """

    kind = "run"

    def __init__(self, handle: Any, waiting: str, result: Callable[[Any], Result]) -> None:
        super().__init__(handle)
        self._waiting, self._result = waiting, result

    def poll(self) -> Progress:
        """Tell where it stands, at once.

        Returns
        -------
        Progress
        """
        now = native.fill("run_poll", self, interface.MlgProgress())
        now["ended"] = now.pop("state") == interface.RUN_ENDED
        now["stage"] = now["stage"].decode("utf-8", "replace")
        return Progress(**now)

    def cancel(self) -> None:
        """Ask it to stop; of a reshaping the best shape so far stays available by `wait`."""
        native.get("run_cancel", self)

    def preview_points(self) -> NDArray[numpy.float64] | None:
        """Give the latest points of the surface.

        Returns
        -------
        ndarray of float64, shape (n, 3), or None
            None before there are any.
        """
        return native.preview(self)

    def wait(self, progress: Watcher = None) -> Result:
        """Wait for the end and hand the result over, once. Ctrl-C cancels the run.

        Parameters
        ----------
        progress : callable or bool, optional
            Called with a `Progress` some times a second; when it returns False the run is cancelled. True draws a bar,
            by tqdm where it is installed.

        Returns
        -------
        object
            The result, such as a `ReshapingResult`.

        Raises
        ------
        Error
            Where the computation failed, or was cancelled before it had a result.
        """
        bar = ProgressBar() if progress is True else None
        watch: Any = bar.show if bar else progress or None
        try:
            while True:
                now = self.poll()
                if watch is not None and watch(now) is False:
                    self.cancel()
                if now.ended:
                    return self._result(native.make(self._waiting, self))
                self.wait_for(0.2)
        except BaseException:
            # Ctrl-C, or an error of `progress`: nobody waits any more, though the traceback may keep the run alive.
            self.cancel()
            raise
        finally:
            if bar:
                bar.close()

    def wait_for(self, seconds: float) -> bool:
        """Wait for the end, so long at most. Ctrl-C is heard afterwards.

        Parameters
        ----------
        seconds : float
            0 or more; infinity to wait for the end.

        Returns
        -------
        bool
            Whether the end has come; `wait` then hands the result over.
        """
        state = c_uint32()
        native.call("run_wait_for", self, seconds, byref(state))
        return state.value == interface.RUN_ENDED

    def __enter__(self) -> Run[Result]:
        return self

    def __exit__(self, *_: object) -> None:
        self.cancel()
