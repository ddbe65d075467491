# SPDX-License-Identifier: GPL-3.0-or-later
"""One reshaping without an operator. The template is found again by its uid at every tick."""

import time

from . import identity, kept_tets, problem, result
from .library import Wrong, calls, moulage
from .runs import Running

_LIVE_LIMIT = 500_000
# Tets of the last shapes: a run after "Fill with Tets", or with other markers, need not make them again.
_CACHE_SIZE = 4
_OUT_OF_DATE = "points or settings were changed during the run, and this is the shape for those before: reshape once more"

_cache = {}
# The last result, by its template's uid: what it was made of, and itself. It holds factors: one is enough.
_results = {}


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


class Solve(Running):
    """A reshaping under way. `progress` holds the latest state."""

    def __init__(self, context, template, again=False):
        """`again`: from the result before, for what was moved since; Wrong if there is none that fits."""
        self.inputs = problem.gather(context, template)
        self._earlier = _earlier(self.inputs) if again else None
        self._tets = None
        data = template.moulage
        self._warnings = [row.text for row in data.doubts]
        self._before = result.Before(template, "" if data.new_key else data.result.key)
        super().__init__()
        try:
            if self.inputs.key() in _cache:
                with calls():
                    self._start(_cache[self.inputs.key()])
            else:
                self._filling = start_filling(self.inputs)
        except Wrong:
            self.close()
            raise

    def _start(self, tets):
        inputs, self._tets = self.inputs, tets
        reshaping = moulage().Reshaping(tets)
        reshaping.set_markers(inputs.markers)
        reshaping.set_landmarks(*inputs.landmarks)
        reshaping.set_pins(inputs.within)
        reshaping.set_attachments(*inputs.attachments)
        reshaping.set_fixed(inputs.fixed)
        if self._earlier is None:
            self._run = reshaping.start(inputs.options)
        else:
            self._run = reshaping.start_again(self._earlier, inputs.options)

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
                    self._fail_stopped()
                    return False
                self._start(_cache[self.inputs.key()])
                now = self._run.poll()
        except moulage().Error as error:
            self._fail(error)
            return False
        if self._template() is None:
            self._error = f"The template '{self.inputs.name}' was deleted; the run was stopped."
            self.stop()
            return False
        return not now.ended

    def _template(self):
        return identity.find(self.inputs.uid, self.inputs.name)

    def wants_view(self):
        template = self._template()
        small = len(self.inputs.points) <= _LIVE_LIMIT
        return small and template is not None and template.moulage.live and result.fits(template, self.inputs)

    def show_points(self, points):
        result.write_shape(self._template(), self.inputs, self._before, points)

    @property
    def waits_for_object_mode(self):
        """Whether the result cannot be written because the template is being edited."""
        template = self._template()
        return template is not None and template.mode == "EDIT"

    def finish(self, context):
        """Writes the result and returns what to tell the user; Wrong if there is none."""
        template = self._template()
        try:
            found = self._wait()
            if template is None:
                raise Wrong(f"The template '{self.inputs.name}' was deleted; its shape is lost.")
            if not result.fits(template, self.inputs):
                raise Wrong("The template's vertices were changed during the run; run it again.")
            _results.clear()
            _results[self.inputs.uid] = self.inputs.key(), self.inputs.options, found
            seconds = time.monotonic() - self.started
            warnings = self._warnings + ([] if self._is_up_to_date(context, template) else [_OUT_OF_DATE])
            data = template.moulage.result
            if self._earlier is None:
                data.mean_before = -1.0
            elif data.mean_before < 0:
                data.mean_before = data.mean_distance
            said = result.write(context, template, self.inputs, self._before, found, warnings, seconds, self._earlier is not None)
            kept_tets.keep(template, self.inputs.frame, found.points, found.tet_points, self._tets.tets)
            return said
        except Wrong:
            self.put_back()
            raise
        finally:
            self.close()

    def _is_up_to_date(self, context, template):
        """Whether the run was for what is there now; in live editing the next one is for what moved meanwhile."""
        try:
            return self._earlier is not None or self.inputs.asks_the_same(problem.gather(context, template))
        except Wrong:
            return False

    def put_back(self):
        template = self._template()
        if template is not None and template.mode != "EDIT":
            self._before.restore(template)

    def close(self):
        self._tets = None
        super().close()


def _earlier(inputs):
    key, options, found = _results.get(inputs.uid, (None, None, None))
    if key != inputs.key() or options != inputs.options:
        raise Wrong("The template or the settings are others than those of the last run: reshape once more.")
    return found


def can_go_on(template):
    """Whether there is a result, of this session, to start from."""
    return template.moulage.uid in _results


def forget():
    """Drops the tets and results that are kept."""
    _cache.clear()
    _results.clear()
