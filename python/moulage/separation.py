"""Pushing bodies apart that overlap: the problem, a run of it, the result."""

import numpy

from . import interface, native
from .native import address, array, byref
from .shapes import Handle
from .tets import Run, follow


class Separation(Handle):
    """Bodies that overlap each other or obstacles. Bodies are numbered from 0 as they are added, obstacles after all
    bodies; names are unique."""

    kind = "separation"

    def __init__(self):
        super().__init__(native.make("separation_new"))

    def add_body(self, name, tets, surface=None):
        """A soft body in its present shape: a TetMesh, and the TriMesh that lies in it (None: the tets' boundary)."""
        surface = None if surface is None else surface._handle
        native.call("separation_add_body", self._handle, name.encode("utf-8"), tets._handle, surface)

    def add_result(self, name, result):
        """A ReshapingResult as a soft body, with its surface and its markers."""
        native.call("separation_add_result", self._handle, name.encode("utf-8"), result._handle)

    def add_obstacle(self, name, surface):
        """Something that does not move, such as a bone."""
        native.call("separation_add_obstacle", self._handle, name.encode("utf-8"), surface._handle)

    def set_markers(self, body, points):
        """Markers of the person's surface that a body meets: it is held there as far as contact allows."""
        points = array(points, 3, numpy.float64, "points")
        native.call("separation_set_markers", self._handle, body, address(points), len(points))

    def start(self, **options):
        """Starts on a thread of the library and returns the Run; its preview has the surfaces of all bodies. Options as
        in the header's MlgSeparationOptions: gap, rings, thread_count."""
        options = native.options("separation", interface.MlgSeparationOptions(), options)
        run = native.make("separation_start", self._handle, options)
        return Run(run, "run_wait_separation", SeparationResult)

    def run(self, progress=None, **options):
        """Separates and returns the result. `progress(Progress)` is called some times a second; when it returns False
        the run stops and the shapes with the least overlap so far are the result."""
        return follow(self.start(**options), progress)


class SeparationResult(Handle):
    """Bodies that were pushed apart."""

    kind = "separation_result"

    def points(self, body):
        """The points of a body's surface (n, 3), in its order."""
        return native.borrowed("separation_result_points", self._handle, 3, numpy.float64, body)

    def tet_points(self, body):
        """The points of a body's tets (n, 3), in their order."""
        return native.borrowed("separation_result_tet_points", self._handle, 3, numpy.float64, body)

    @property
    def summary(self):
        """A dict: ending (parted, stalled or cancelled), separated, rounds, overlap_count, seconds."""
        found = native.fill("separation_result_summary", self._handle, interface.MlgSeparationSummary())
        found["ending"] = interface.ENDING[found["ending"]]
        found["separated"] = found["separated"] == 1
        return found

    @property
    def overlaps(self):
        """Pairs of surfaces that overlap or did, a dict each: first, second (numbers), and depth, vertices_inside,
        crossings: pairs, before and after."""
        return [self._part("overlap", interface.MlgOverlap(), i) for i in range(self.summary["overlap_count"])]

    def body(self, body):
        """A dict: moved_vertices, largest_move, inverted_tets, markers_inside_obstacles, and mean_marker_distance,
        max_marker_distance: pairs, before and after, NaN without markers."""
        found = self._part("body", interface.MlgSeparatedBody(), body)
        found.pop("reserved")
        return found

    def _part(self, what, struct, number):
        native.call(f"separation_result_{what}", self._handle, number, byref(struct))
        return {key: value if isinstance(value, (int, float)) else tuple(value) for key, value in struct.fields().items()}
