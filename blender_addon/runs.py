# SPDX-License-Identifier: GPL-3.0-or-later
"""The runs that are going on. A run is started once, ticked until it has ended, finished once; the library
works on threads of its own, and between ticks nothing of Blender is held."""

import time
import weakref

import numpy

from .library import Wrong, moulage, sentence

# A live view may take so large a share of the time between ticks, and no more.
_LIVE_SHARE = 0.3

_NO_SHAPE = "Stopped before there was a shape."

_open = weakref.WeakSet()


class Running:
    """What reshaping, registration and separation have in common. Subclasses set `_run`, `_filling` while a mesh is
    filled with tets before, and write what comes out."""

    # Length in the scene of one unit of the run.
    unit = 1.0
    # How `finish` is told; a warning where the result is not all that was asked for.
    severity = "INFO"

    def __init__(self):
        self.progress = None
        self.started = time.monotonic()
        self.closed = False
        self._error = None
        self._stopping = False
        self._run = self._filling = None
        self._next_view = 0.0
        self._shown = None
        _open.add(self)

    def stop(self):
        """Asks for the end; the best so far is kept."""
        self._stopping = True
        for under_way in (self._run, self._filling):
            if under_way is not None:
                under_way.cancel()

    def _fail(self, error):
        cancelled = error.status == moulage().CANCELLED
        self._error = _NO_SHAPE if cancelled else sentence(str(error))

    def _fail_stopped(self):
        self._error = _NO_SHAPE

    def show(self):
        """Shows the latest shape if it is new, unless that would take too long; says whether it did."""
        began = time.monotonic()
        if self._run is None or began < self._next_view or not self.wants_view():
            return False
        points = self._run.preview_points()
        if points is None or numpy.array_equal(points, self._shown):
            return False
        self.show_points(points)
        self._shown = points
        now = time.monotonic()
        self._next_view = now + (now - began) / _LIVE_SHARE
        return True

    def _wait(self):
        if self._error is None:
            try:
                return self._run.wait()
            except moulage().Error as error:
                self._fail(error)
        raise Wrong(self._error)

    def abandon(self):
        """Ends the run and puts everything back as it was."""
        if not self.closed:
            self.put_back()
        self.close()

    def close(self):
        """Ends the run; freeing it waits for its thread."""
        self._run = self._filling = None
        self.closed = True
        _open.discard(self)


def is_running():
    return len(_open) > 0


def stop_all():
    """Asks all runs to end; their results are kept."""
    for run in list(_open):
        run.stop()


def shut_down():
    """Ends all runs without a result: when the add-on is disabled."""
    for run in list(_open):
        run.abandon()
