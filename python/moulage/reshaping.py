"""Reshaping: the problem, a run of it, the result."""

import numpy

from . import interface, native
from .native import address, array
from .shapes import Handle, Markers, Pairs, checked_weights
from .tets import Run, follow, quality


def default_options():
    """The options of a reshaping and their defaults; 0 stands for a default relative to the template's
    size."""
    return native.options("reshaping", interface.MlgReshapingOptions(), {}).fields()


class Reshaping(Handle):
    """A template carried by tets, and the data it is to follow. All coordinates in the template's
    unit and frame; weights are 1 where none are given."""

    kind = "reshaping"

    def __init__(self, tets):
        super().__init__(native.make("reshaping_new", tets._handle))

    def set_markers(self, points, weights=None, sigmas=None):
        """Points of the person's surface, without correspondence; `sigmas`: the noise of each, in place of
        the tolerance of all (0 stands for that). Or Markers, with all that they have."""
        if isinstance(points, Markers):
            if weights is not None or sigmas is not None:
                raise TypeError("Markers have their weights and sigmas; give nothing beside them")
            points, weights, sigmas = points.points, points.weights, points.sigmas
        points = array(points, 3, numpy.float64, "points")
        weights = checked_weights(weights, len(points))
        native.call(
            "reshaping_set_markers", self._handle, address(points), address(weights), len(points)
        )
        if sigmas is not None:
            sigmas = array(sigmas, 1, numpy.float64, "sigmas")
            native.call(
                "reshaping_set_marker_sigmas", self._handle, address(sigmas), len(sigmas)
            )

    def set_landmarks(self, template_points, targets=None, weights=None):
        """Points on or in the template, and where they are on the person; or Pairs, with their weights and names."""
        self._pairs("landmark", template_points, targets, weights)

    def set_landmarks_at_vertices(self, vertices, targets, weights=None):
        """The same, the template points being vertices of the surface."""
        self._vertex_pairs("reshaping_set_landmarks_at_vertices", vertices, targets, weights)

    def set_attachments(self, template_points, targets=None, weights=None):
        """Template points that are held at their targets mechanically; or Pairs."""
        self._pairs("attachment", template_points, targets, weights)

    def set_attachments_at_vertices(self, vertices, targets, weights=None):
        """The same, the template points being vertices of the surface."""
        self._vertex_pairs("reshaping_set_attachments_at_vertices", vertices, targets, weights)

    def set_fixed(self, vertices):
        """Vertices of the surface that stay where they are."""
        vertices = array(vertices, 1, numpy.uint32, "vertices")
        native.call("reshaping_set_fixed", self._handle, address(vertices), len(vertices))

    def load_fixed(self, path):
        """The same, read from a .csv file with the column vertex, or x, y, z, or both."""
        native.call("reshaping_load_fixed", self._handle, native.path(path))

    def check(self):
        """What may be a mistake, one sentence each, such as two units or contradictory landmarks; raises
        Error for what cannot work."""
        return native.text("reshaping_check", self._handle).splitlines()

    def start(self, **options):
        """Starts on a thread of the library and returns the Run. Options as in the header's
        MlgReshapingOptions: tolerance, landmark_tolerance, smoothness, max_iterations, ..."""
        options = native.options("reshaping", interface.MlgReshapingOptions(), options)
        run = native.make("reshaping_start", self._handle, options)
        return Run(run, "run_wait_reshaping", ReshapingResult)

    def start_again(self, earlier, **options):
        """Starts from the shape of an earlier ReshapingResult for the same template and options: the quick way after a
        landmark was moved, markers came or went. Returns the Run."""
        options = native.options("reshaping", interface.MlgReshapingOptions(), options)
        run = native.make("reshaping_start_again", earlier._handle, self._handle, options)
        return Run(run, "run_wait_reshaping", ReshapingResult)

    def run(self, progress=None, **options):
        """Reshapes and returns the result. `progress(Progress)` is called five times a second; when
        it returns False the run stops and the best shape so far is the result."""
        return follow(self.start(**options), progress)

    def _pairs(self, kind, template_points, targets, weights):
        if not isinstance(template_points, Pairs):
            template = array(template_points, 3, numpy.float64, "template_points")
            self._set_pairs(f"reshaping_set_{kind}s", template, targets, weights)
        elif targets is not None or weights is not None:
            raise TypeError("Pairs have their targets and weights; give nothing beside them")
        else:
            native.call(f"reshaping_set_{kind}_pairs", self._handle, template_points._handle)

    def _vertex_pairs(self, function, vertices, targets, weights):
        self._set_pairs(function, array(vertices, 1, numpy.uint32, "vertices"), targets, weights)

    def _set_pairs(self, function, template, targets, weights):
        targets = array(targets, 3, numpy.float64, "targets")
        if len(template) != len(targets):
            raise ValueError(f"{len(template)} template points but {len(targets)} targets")
        weights = checked_weights(weights, len(targets))
        native.call(
            function, self._handle, address(template), address(targets), address(weights), len(targets)
        )


class ReshapingResult(Handle):
    """A reshaped template."""

    kind = "reshaping_result"

    @property
    def points(self):
        """The surface's points in the template's order (n, 3)."""
        return native.borrowed("reshaping_result_points", self._handle, 3, numpy.float64)

    @property
    def tets(self):
        """The corners of each tet (m, 4): those of the problem, unless new ones were made (summary)."""
        return native.borrowed("reshaping_result_tets", self._handle, 4, numpy.uint32)

    @property
    def tet_points(self):
        return native.borrowed("reshaping_result_tet_points", self._handle, 3, numpy.float64)

    @property
    def plastic_strains(self):
        """Fp of each tet (m, 3, 3), symmetric."""
        flat = native.borrowed("reshaping_result_plastic_strains", self._handle, 9, numpy.float64)
        return flat.reshape(-1, 3, 3)

    @property
    def marker_distances(self):
        """The distance of each marker to the result."""
        return native.borrowed("reshaping_result_marker_distances", self._handle, 1, numpy.float64)

    @property
    def landmark_distances(self):
        """The distance of each landmark's place on the result to its target."""
        return native.borrowed("reshaping_result_landmark_distances", self._handle, 1, numpy.float64)

    @property
    def attachment_distances(self):
        """The distance of each attachment's place on the result to its target."""
        return native.borrowed("reshaping_result_attachment_distances", self._handle, 1, numpy.float64)

    @property
    def max_stretches(self):
        """The largest principal stretch at each vertex of the surface; 1: not stretched."""
        return native.borrowed("reshaping_result_max_stretches", self._handle, 1, numpy.float64)

    @property
    def min_stretches(self):
        """The smallest principal stretch at each vertex of the surface."""
        return native.borrowed("reshaping_result_min_stretches", self._handle, 1, numpy.float64)

    def carry(self, points):
        """Moves other points (at rest) with the template."""
        points = array(points, 3, numpy.float64, "points").copy()
        native.call(
            "reshaping_result_carry", self._handle, address(points), len(points), address(points)
        )
        return points

    def save_tets(self, path):
        """Writes the deformed tets as .vtu (for ParaView) with strains, stretches and the shape at rest."""
        native.call("reshaping_result_save_tets", self._handle, native.path(path))

    @property
    def summary(self):
        """A dict: stop, iterations, inverted_tets, mean_marker_distance, ..., seconds, remeshes (how often
        the shape reached was filled with new tets)."""
        found = native.fill(
            "reshaping_result_summary", self._handle, interface.MlgReshapingSummary()
        )
        found.pop("reserved")
        found["stop"] = interface.STOP[found["stop"]]
        return found

    @property
    def quality(self):
        return quality(self._handle, "reshaping_result_quality")

