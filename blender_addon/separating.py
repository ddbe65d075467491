# SPDX-License-Identifier: GPL-3.0-or-later
"""One separation of meshes that overlap, without an operator."""

import time

import numpy

from . import bodies, identity, kept_tets, preferences, problem, separate_report, separate_properties, solve
from .library import Wrong, calls, moulage
from .runs import Running

_LIVE_LIMIT = 500_000


class Separating(Running):
    """A separation under way: first each mesh without tets is filled, then all are pushed apart. World coordinates."""

    def __init__(self, context):
        context.view_layer.update()
        settings = context.scene.moulage_separate
        self._options = {"gap": settings.gap, "rings": settings.rings}
        own = preferences.get(context)
        self._options["thread_count"] = own.threads if own else 0
        self._live = settings.live
        soft, hard = separate_properties.chosen(context)
        _require(soft, hard)
        self.bodies = [bodies.Body(ob) for ob in soft]
        self.bones = [(ob.name, *bodies.surface(ob)) for ob in hard]
        tetgen = own.tetgen if own else ""
        self._unfilled = [
            problem.Inputs(b.name, b.uid, b.points, b.triangles, b.frame, settings.method, settings.tet_count, tetgen)
            for b in self.bodies if b.tets is None
        ]
        self.warnings = []
        super().__init__()
        try:
            self._go_on()
        except Wrong:
            self.close()
            raise

    def _go_on(self):
        """Fills the next mesh with tets, or starts the separation."""
        if self._unfilled:
            self._filling = solve.start_filling(self._unfilled[0])
        else:
            self._start()

    def _filling_now(self, now):
        done = sum(1 for b in self.bodies if b.tets is not None)
        share = (done + now.fraction) / len(self.bodies)
        return now._replace(stage=f"filling {self._unfilled[0].name} with tets", fraction=share)

    def _take_tets(self):
        inputs = self._unfilled.pop(0)
        made = self._filling.wait()
        self._filling = None
        self.warnings += [f"'{inputs.name}': {warning}" for warning in made.warnings]
        body = next(b for b in self.bodies if b.name == inputs.name)
        body.tets = made.points, made.tets

    def _start(self):
        with calls() as library:
            apart = library.Separation()
            for number, body in enumerate(self.bodies):
                surface = library.TriMesh(body.points, body.triangles)
                apart.add_body(body.name, library.TetMesh(*body.tets), surface)
                apart.set_markers(number, body.markers)
            for name, points, triangles in self.bones:
                apart.add_obstacle(name, library.TriMesh(points, triangles))
            self._run = apart.start(library.SeparationOptions(**self._options))

    def tick(self):
        """Goes on; False when it has ended."""
        if self._error is not None:
            return False
        try:
            now = (self._run or self._filling).poll()
            if self._run is None and now.ended:
                self._take_tets()
                if self._stopping:
                    self._fail_stopped()
                    return False
                self._go_on()
                now = (self._run or self._filling).poll()
            self.progress = now if self._run is not None else self._filling_now(now)
        except moulage().Error as error:
            self._fail(error)
            return False
        except Wrong as wrong:
            self._error = str(wrong)
            return False
        lost = next((b.name for b in self.bodies if _object(b) is None), None)
        if lost is not None:
            self._error = f"'{lost}' was deleted; the separation was stopped."
            self.stop()
            return False
        return self._run is None or not now.ended

    def wants_view(self):
        objects = [_object(b) for b in self.bodies]
        small = sum(len(b.points) for b in self.bodies) <= _LIVE_LIMIT
        return self._live and small and all(ob is not None and _fits(ob, b) for ob, b in zip(objects, self.bodies))

    def show_points(self, points):
        first = 0
        for body in self.bodies:
            shown = points[first : first + len(body.points)]
            first += len(body.points)
            if len(shown) == len(body.points) and not numpy.array_equal(shown, body.points):
                body.write(_object(body), shown)

    @property
    def waits_for_object_mode(self):
        """Whether the result cannot be written because one of the meshes is being edited."""
        objects = [_object(b) for b in self.bodies]
        return any(ob is not None and ob.mode == "EDIT" for ob in objects)

    def finish(self, context):
        """Writes the result and returns what to tell the user; Wrong if there is none."""
        try:
            found = self._wait()
            for body in self.bodies:
                ob = _object(body)
                if ob is None:
                    raise Wrong(f"'{body.name}' was deleted; the result is lost.")
                if not _fits(ob, body):
                    raise Wrong(f"The vertices of '{body.name}' were changed during the run; run it again.")
            # A preview may have moved what the best shape leaves in place.
            self.put_back()
            for number, body in enumerate(self.bodies):
                if found.body(number)["moved_vertices"] > 0:
                    ob, points = _object(body), found.points(number)
                    body.write(ob, points)
                    kept_tets.keep(ob, body.frame, points, found.tet_points(number), body.tets[1])
            clear, said = separate_report.write(context.scene, self, found, time.monotonic() - self.started)
            self.severity = "INFO" if clear else "WARNING"
            return said
        except Wrong:
            self.put_back()
            raise
        finally:
            self.close()

    def put_back(self):
        for body in self.bodies:
            ob = _object(body)
            if ob is not None and ob.mode != "EDIT":
                body.put_back(ob)


def _require(soft, hard):
    if len(soft) + len(hard) < 2 or not soft:
        raise Wrong("Select two or more meshes that overlap, or one and a collection of bones that stay.")
    meshes, uids = {}, set()
    for ob in soft:
        # A duplicate has the uid of the original.
        if ob.moulage.uid in uids:
            ob.moulage.uid = ""
        uids.add(ob.moulage.uid)
        other = meshes.setdefault(ob.data, ob)
        if other != ob:
            raise Wrong(
                f"'{other.name}' and '{ob.name}' share one mesh: make them single users (Object > Relations > Make "
                "Single User > Object & Data)."
            )


def _object(body):
    return identity.find(body.uid, body.name)


def _fits(ob, body):
    return ob.mode != "EDIT" and len(ob.data.vertices) == len(body.points)
