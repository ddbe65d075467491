"""Reshaping: the options, the problem, a run of it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy
from numpy.typing import ArrayLike, NDArray

from . import interface, native
from .handles import Handle
from .markers import Markers, Pairs, checked_weights
from .native import address, array
from .reshaping_result import ReshapingResult
from .runs import Run, Watcher
from .tets import Tetrahedralization


@dataclass(frozen=True, kw_only=True)
class ReshapingOptions:
    """How to reshape. The defaults are right for most templates; lengths are in the template's unit.

    Parameters
    ----------
    tolerance : float, optional
        How far a marker may be off. 0: the template's diagonal / 1000.
    landmark_tolerance : float, optional
        How far a landmark may be off. 0: five times `tolerance`.
    attachment_tolerance : float, optional
        How far an attachment may be off. 0: `tolerance`.
    smoothness : float, optional
        Weight of the smoothness of the plastic strain, without unit.
    screening : float, optional
        Distance over which the strain returns to its mean away from data, as a multiple of the cube root of the
        template's volume; infinity: never. 0: by how much of the template was seen.
    poisson : float, optional
        Poisson's ratio of the tissue, above 0 and below 0.5.
    hard_attachments : bool, optional
        Whether attachments are met whatever the markers say.
    reverse_term : bool, optional
        Whether template points far from every marker are pulled back, except beyond the ends of a scan that cuts
        the organ.
    max_iterations : int, optional
        Gauss-Newton iterations allowed.
    max_remeshes : int, optional
        How often the shape reached may be filled with new tets, where a very large change has flattened the old
        ones.
    thread_count : int, optional
        Threads to use; 0: all. The result does not depend on it.
    paper : bool, optional
        Whether to solve the published formulation, for comparison.
    """

    tolerance: float = 0.0
    landmark_tolerance: float = 0.0
    attachment_tolerance: float = 0.0
    smoothness: float = 0.08
    screening: float = 0.0
    poisson: float = 0.3
    hard_attachments: bool = False
    reverse_term: bool = True
    max_iterations: int = 80
    max_remeshes: int = 3
    thread_count: int = 0
    paper: bool = False


class Reshaping(Handle):
    """A template carried by tets, and the data it is to follow.

    All coordinates are in the template's unit and frame; weights are 1 where none are given.

    Parameters
    ----------
    tets : Tetrahedralization
        Of the template.
    """

    kind = "reshaping"

    def __init__(self, tets: Tetrahedralization) -> None:
        super().__init__(native.make("reshaping_new", tets))
        self._surface, self._markers = tets.surface, numpy.empty((0, 3))

    def set_markers(
        self, points: Markers | ArrayLike, weights: ArrayLike | None = None, sigmas: ArrayLike | None = None
    ) -> None:
        """Set points of the person's surface, without correspondence.

        Parameters
        ----------
        points : Markers, or array_like, shape (n, 3)
            Markers bring their weights and sigmas.
        weights : array_like, shape (n,), optional
            How much each counts.
        sigmas : array_like, shape (n,), optional
            The noise of each, in place of the tolerance of all; 0 stands for that.

        Raises
        ------
        Error
            Where a coordinate is not finite or a sigma is negative.
        """
        marked: ArrayLike
        if isinstance(points, Markers):
            if weights is not None or sigmas is not None:
                raise TypeError("Markers have their weights and sigmas; give nothing beside them")
            marked, weights, sigmas = points.points, points.weights, points.sigmas
        else:
            marked = points
        given = array(marked, 3, numpy.float64, "points")
        checked = checked_weights(weights, len(given))
        native.call("reshaping_set_markers", self, address(given), address(checked), len(given))
        self._markers = given
        if sigmas is not None:
            noise = array(sigmas, 1, numpy.float64, "sigmas")
            native.call("reshaping_set_marker_sigmas", self, address(noise), len(noise))

    def set_landmarks(
        self, template_points: Pairs | ArrayLike, targets: ArrayLike | None = None, weights: ArrayLike | None = None
    ) -> None:
        """Set points on or in the template, and where they are on the person.

        Parameters
        ----------
        template_points : Pairs, or array_like, shape (n, 3)
            Pairs bring their targets, weights and names.
        targets : array_like, shape (n, 3), optional
            Where they are on the person.
        weights : array_like, shape (n,), optional
            How much each counts.
        """
        self._pairs("landmark", template_points, targets, weights)

    def set_pins(self, within: ArrayLike) -> None:
        """Make landmarks pins: they end within a distance of their targets, whatever the markers say.

        Parameters
        ----------
        within : array_like, shape (n,)
            A length for each landmark that was set; 0: at the target itself; below 0: no pin, weighed against the
            markers by the ``landmark_tolerance``.
        """
        lengths = array(within, 1, numpy.float64, "within")
        native.call("reshaping_set_pins", self, address(lengths), len(lengths))

    def set_landmarks_at_vertices(
        self, vertices: ArrayLike, targets: ArrayLike, weights: ArrayLike | None = None
    ) -> None:
        """Set landmarks that are vertices of the template's surface.

        Parameters
        ----------
        vertices : array_like of int, shape (n,)
            Their numbers, from 0.
        targets : array_like, shape (n, 3)
            Where they are on the person.
        weights : array_like, shape (n,), optional
            How much each counts.
        """
        self._vertex_pairs("reshaping_set_landmarks_at_vertices", vertices, targets, weights)

    def set_attachments(
        self, template_points: Pairs | Sequence[Pairs] | ArrayLike, targets: ArrayLike | None = None, weights: ArrayLike | None = None
    ) -> None:
        """Set points of the template that are held at their targets mechanically, as a tendon holds a muscle.

        Parameters
        ----------
        template_points : Pairs, sequence of Pairs, or array_like, shape (n, 3)
            Pairs bring their targets and weights; those of several bones come in a list.
        targets : array_like, shape (n, 3), optional
            Where they are on the person.
        weights : array_like, shape (n,), optional
            How much each counts.
        """
        if isinstance(template_points, (list, tuple)) and template_points and isinstance(template_points[0], Pairs):
            _refuse_beside_pairs(targets, weights)
            template_points, targets, weights = (
                numpy.concatenate([getattr(pairs, name) for pairs in template_points])
                for name in ("template_points", "targets", "weights")
            )
        self._pairs("attachment", template_points, targets, weights)

    def set_attachments_at_vertices(
        self, vertices: ArrayLike, targets: ArrayLike, weights: ArrayLike | None = None
    ) -> None:
        """Set attachments that are vertices of the template's surface.

        Parameters
        ----------
        vertices : array_like of int, shape (n,)
            Their numbers, from 0.
        targets : array_like, shape (n, 3)
            Where they are on the person.
        weights : array_like, shape (n,), optional
            How much each counts.
        """
        self._vertex_pairs("reshaping_set_attachments_at_vertices", vertices, targets, weights)

    def set_fixed(self, vertices: ArrayLike) -> None:
        """Set vertices of the surface that stay where they are.

        Parameters
        ----------
        vertices : array_like of int, shape (n,)
            Their numbers, from 0.
        """
        vertices = array(vertices, 1, numpy.uint32, "vertices")
        native.call("reshaping_set_fixed", self, address(vertices), len(vertices))

    def load_fixed(self, path: str | os.PathLike[str]) -> None:
        """Read vertices that stay where they are.

        Parameters
        ----------
        path : path
            A .csv file with the column vertex, or x, y, z, or both.
        """
        native.call("reshaping_load_fixed", self, native.path(path))

    def check(self) -> list[str]:
        """Look for what may be a mistake, such as two units or contradictory landmarks.

        Returns
        -------
        list of str
            One sentence each.

        Raises
        ------
        Error
            For what cannot work.
        """
        return native.text("reshaping_check", self).splitlines()

    def start(self, options: ReshapingOptions | None = None) -> Run[ReshapingResult]:
        """Start on a thread of the library.

        Parameters
        ----------
        options : ReshapingOptions, optional

        Returns
        -------
        Run
            Its result is a `ReshapingResult`; its preview has the surface's points.
        """
        return self._started("reshaping_start", self, options=options)

    def start_again(self, earlier: ReshapingResult, options: ReshapingOptions | None = None) -> Run[ReshapingResult]:
        """Start from the shape of an earlier result, the quick way after a landmark was moved, markers came or went.

        Parameters
        ----------
        earlier : ReshapingResult
            For the same template and options.
        options : ReshapingOptions, optional

        Returns
        -------
        Run
        """
        return self._started("reshaping_start_again", earlier, self, options=options)

    def run(self, options: ReshapingOptions | None = None, progress: Watcher = None) -> ReshapingResult:
        """Reshape and wait for the result. Ctrl-C stops it.

        Parameters
        ----------
        options : ReshapingOptions, optional
        progress : callable or bool, optional
            Called with a `Progress` five times a second; when it returns False the run stops and the best shape so far is
            the result. True draws a bar.

        Returns
        -------
        ReshapingResult

        Raises
        ------
        Error
            Where the data do not determine a shape, or contradict what a shape can be.
        """
        return self.start(options).wait(progress)

    def _started(self, function: str, *handles: Any, options: ReshapingOptions | None) -> Run[ReshapingResult]:
        given = native.options(interface.MlgReshapingOptions(), "reshaping_options_init", options or ReshapingOptions())
        surface, markers = self._surface, self._markers
        run = native.make(function, *handles, given)
        return Run(run, "run_wait_reshaping", lambda handle: ReshapingResult._of(handle, surface, markers))

    def _pairs(
        self, kind: str, template_points: Any, targets: ArrayLike | None, weights: ArrayLike | None
    ) -> None:
        if isinstance(template_points, Pairs):
            _refuse_beside_pairs(targets, weights)
            native.call(f"reshaping_set_{kind}_pairs", self, template_points)
        else:
            template = array(template_points, 3, numpy.float64, "template_points")
            self._set_pairs(f"reshaping_set_{kind}s", template, targets, weights)

    def _vertex_pairs(self, function: str, vertices: ArrayLike, targets: ArrayLike, weights: ArrayLike | None) -> None:
        self._set_pairs(function, array(vertices, 1, numpy.uint32, "vertices"), targets, weights)

    def _set_pairs(
        self, function: str, template: NDArray[Any], targets: ArrayLike | None, weights: ArrayLike | None
    ) -> None:
        places = array(() if targets is None else targets, 3, numpy.float64, "targets")
        if len(template) != len(places):
            raise ValueError(f"{len(template)} template points but {len(places)} targets")
        checked = checked_weights(weights, len(places))
        native.call(function, self, address(template), address(places), address(checked), len(places))


def _refuse_beside_pairs(targets: ArrayLike | None, weights: ArrayLike | None) -> None:
    if targets is not None or weights is not None:
        raise TypeError("Pairs have their targets and weights; give nothing beside them")
