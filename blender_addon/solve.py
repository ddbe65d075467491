# SPDX-License-Identifier: GPL-3.0-or-later
"""One run without an operator: started once, ticked until it has ended, finished once. The library
works on threads of its own. Between ticks nothing of Blender is held; the template is found again
by its uid."""

import time
import weakref

import bpy

from . import problem, result
from .library import Wrong, calls, moulage, sentence

# A live view may take so large a share of the time between ticks, and no more.
_LIVE_SHARE = 0.3
_LIVE_LIMIT = 500_000
# Tets of the last shapes: a run after "Fill with Tets", or with other markers, need not make them again.
_CACHE_SIZE = 4

_NO_SHAPE = "Stopped before there was a shape."

_cache = {}
_open = weakref.WeakSet()


def find_template(uid, name):
    """The template, also after it was renamed; None if it was deleted."""
    ob = bpy.data.objects.get(name)
    if ob is not None and ob.moulage.uid == uid and ob.users_collection:
        return ob
    return next((o for o in bpy.data.objects if o.moulage.uid == uid and o.users_collection), None)


def start_filling(inputs):
    """Starts filling the template with tets."""
    with calls() as library:
        surface = library.TriMesh(inputs.points, inputs.triangles)
        return library.Tetrahedralization.start(surface, inputs.method, inputs.tet_count, inputs.tetgen or None)


def keep_tets(inputs, tets):
    while len(_cache) >= _CACHE_SIZE:
        _cache.pop(next(iter(_cache)))
    _cache[inputs.key()] = tets


def tets_of(inputs):
    """The template filled with tets: those made before, or made now, which takes seconds."""
    if inputs.key() not in _cache:
        filling = start_filling(inputs)
        with calls():
            keep_tets(inputs, filling.wait())
    return _cache[inputs.key()]


class Solve:
    """A reshaping under way. `progress` holds the latest state."""

    def __init__(self, context, template):
        self.inputs = problem.gather(context, template)
        self.progress = None
        self.started = time.monotonic()
        self.closed = False
        self._error = None
        self._stopping = False
        self._warnings = []
        self._filling = None
        self._run = None
        self._next_view = 0.0
        self._before = result.Before(template)
        if self.inputs.key() in _cache:
            with calls():
                self._start(_cache[self.inputs.key()])
        else:
            self._filling = start_filling(self.inputs)
        _open.add(self)

    def _start(self, tets):
        inputs = self.inputs
        reshaping = moulage().Reshaping(tets)
        reshaping.set_markers(inputs.markers)
        reshaping.set_landmarks(*inputs.landmarks)
        reshaping.set_attachments(*inputs.attachments)
        reshaping.set_fixed(inputs.fixed)
        self._warnings = reshaping.check()
        self._run = reshaping.start(**inputs.options)

    def stop(self):
        """Asks for the end; the best shape so far is kept."""
        self._stopping = True
        for run in (self._filling, self._run):
            if run is not None:
                run.cancel()

    def tick(self):
        """Goes on; False when it has ended."""
        if self._error is not None:
            return False
        try:
            now = (self._run or self._filling).poll()
            if self._run is not None:
                self.progress = now
            if self._run is None and now.ended:
                keep_tets(self.inputs, self._filling.wait())
                self._filling = None
                if self._stopping:
                    self._error = _NO_SHAPE
                    return False
                self._start(_cache[self.inputs.key()])
                now = self._run.poll()
        except moulage().Error as error:
            self._fail(error)
            return False
        if find_template(self.inputs.uid, self.inputs.name) is None:
            self._error = f"The template '{self.inputs.name}' was deleted; the run was stopped."
            self.stop()
            return False
        return not now.ended

    def _fail(self, error):
        cancelled = error.status == moulage().CANCELLED
        self._error = _NO_SHAPE if cancelled else sentence(str(error))

    def show(self):
        """Shows the latest shape on the template, unless that would take too long."""
        template = find_template(self.inputs.uid, self.inputs.name)
        began = time.monotonic()
        if self._run is None or template is None or began < self._next_view or not template.moulage.live:
            return
        if len(self.inputs.points) > _LIVE_LIMIT or not result.fits(template, self.inputs):
            return
        points = self._run.preview_points()
        if points is not None:
            result.write_shape(template, self.inputs, self._before, points)
        now = time.monotonic()
        self._next_view = now + (now - began) / _LIVE_SHARE

    @property
    def waits_for_object_mode(self):
        """Whether the result cannot be written because the template is being edited."""
        template = find_template(self.inputs.uid, self.inputs.name)
        return template is not None and template.mode == "EDIT"

    def finish(self, context):
        """Writes the result and returns what to tell the user; Wrong if there is none."""
        template = find_template(self.inputs.uid, self.inputs.name)
        try:
            found = self._wait()
            if template is None:
                raise Wrong(f"The template '{self.inputs.name}' was deleted; its shape is lost.")
            if not result.fits(template, self.inputs):
                raise Wrong("The template's vertices were changed during the run; run it again.")
            seconds = time.monotonic() - self.started
            return result.write(context, template, self.inputs, self._before, found, self._warnings, seconds)
        except Wrong:
            self._put_back(template)
            raise
        finally:
            self.close()

    def _wait(self):
        if self._error is None:
            try:
                return self._run.wait()
            except moulage().Error as error:
                self._fail(error)
        raise Wrong(self._error)

    def _put_back(self, template):
        if template is not None and template.mode != "EDIT":
            self._before.restore(template)

    def abandon(self):
        """Ends the run and puts the template back as it was."""
        if not self.closed:
            self._put_back(find_template(self.inputs.uid, self.inputs.name))
        self.close()

    def close(self):
        """Ends the run; freeing it waits for its thread."""
        self._filling = None
        self._run = None
        self.closed = True
        _open.discard(self)


def is_running():
    return len(_open) > 0


def stop_all():
    """Asks all runs to end; their results are kept."""
    for solve in list(_open):
        solve.stop()


def shut_down():
    """Ends all runs without a result: when the add-on is disabled."""
    for solve in list(_open):
        solve.abandon()
    _cache.clear()
