"""Pushing bodies apart that overlap: the problem, a run of it, the result."""

from __future__ import annotations

from ctypes import byref
from dataclasses import dataclass
from typing import Any, TypedDict

import numpy
from numpy.typing import ArrayLike, NDArray

from . import interface, native
from .handles import Handle
from .meshes import Surface, TetMesh, TriMesh
from .native import address, array
from .reshaping_result import ReshapingResult
from .runs import Run, Watcher


@dataclass(frozen=True, kw_only=True)
class SeparationOptions:
    """How to separate.

    Parameters
    ----------
    gap : float, optional
        Distance to leave between surfaces. 0: the median diagonal of the bodies / 2000.
    rings : int, optional
        Vertices up to this many edges away from an overlap may move.
    thread_count : int, optional
        Threads to use; 0: all. The result does not depend on it.
    """

    gap: float = 0.0
    rings: int = 5
    thread_count: int = 0


class SeparationSummary(TypedDict):
    """What happened in a separation."""

    ending: str
    """"parted", "stalled" or "cancelled"."""
    separated: bool
    """Whether no triangle of one surface crosses or lies inside another; decided exactly."""
    rounds: int
    overlap_count: int
    """Pairs of surfaces that overlap or did."""
    seconds: float


class Overlap(TypedDict):
    """Two surfaces that overlap or did. Pairs of figures are before and after."""

    first: int
    """Number of the first surface: bodies from 0, then obstacles."""
    second: int
    depth: tuple[float, float]
    """The largest distance of a vertex inside to the other's surface."""
    vertices_inside: tuple[int, int]
    crossings: tuple[int, int]
    """Pairs of triangles that cross."""


class SeparatedBody(TypedDict):
    """What a separation did to a body. Pairs of figures are before and after, NaN without markers."""

    moved_vertices: int
    inverted_tets: int
    largest_move: float
    mean_marker_distance: tuple[float, float]
    max_marker_distance: tuple[float, float]
    markers_inside_obstacles: int
    """Markers that cannot be met."""


class Separation(Handle):
    """Bodies that overlap each other or obstacles.

    Bodies are numbered from 0 as they are added, obstacles after all bodies; names are unique.
    """

    kind = "separation"

    def __init__(self) -> None:
        super().__init__(native.make("separation_new"))

    def add_body(self, name: str, tets: TetMesh, surface: Surface | None = None) -> None:
        """Add a soft body in its present shape.

        Parameters
        ----------
        name : str
            Another than all others have.
        tets : TetMesh
        surface : TriMesh, trimesh.Trimesh or pyvista.PolyData, optional
            What lies in the tets; else their boundary is its surface.
        """
        carried = None if surface is None else TriMesh.of(surface)
        native.call("separation_add_body", self, name.encode("utf-8"), tets, carried)

    def add_result(self, name: str, result: ReshapingResult) -> None:
        """Add a reshaped template as a soft body, with its surface and its markers.

        Parameters
        ----------
        name : str
            Another than all others have.
        result : ReshapingResult
        """
        native.call("separation_add_result", self, name.encode("utf-8"), result)

    def add_obstacle(self, name: str, surface: Surface) -> None:
        """Add something that does not move, such as a bone.

        Parameters
        ----------
        name : str
            Another than all others have.
        surface : TriMesh, trimesh.Trimesh or pyvista.PolyData
        """
        native.call("separation_add_obstacle", self, name.encode("utf-8"), TriMesh.of(surface))

    def set_markers(self, body: int, points: ArrayLike) -> None:
        """Set markers of the person's surface that a body meets: it is held there as far as contact allows.

        Parameters
        ----------
        body : int
            Its number.
        points : array_like, shape (n, 3)
        """
        points = array(points, 3, numpy.float64, "points")
        native.call("separation_set_markers", self, body, address(points), len(points))

    def start(self, options: SeparationOptions | None = None) -> Run[SeparationResult]:
        """Start on a thread of the library.

        Parameters
        ----------
        options : SeparationOptions, optional

        Returns
        -------
        Run
            Its result is a `SeparationResult`; its preview has the surfaces of all bodies.
        """
        given = native.options(interface.MlgSeparationOptions(), "separation_options_init", options or SeparationOptions())
        run = native.make("separation_start", self, given)
        return Run(run, "run_wait_separation", SeparationResult._take)

    def run(self, options: SeparationOptions | None = None, progress: Watcher = None) -> SeparationResult:
        """Separate and wait for the result. Ctrl-C stops it.

        Parameters
        ----------
        options : SeparationOptions, optional
        progress : callable or bool, optional
            Called with a `Progress` some times a second; when it returns False the run stops and the shapes with the
            least overlap so far are the result. True draws a bar.

        Returns
        -------
        SeparationResult

        Raises
        ------
        Error
            Where there is nothing to separate, or a body cannot be solved.
        """
        return self.start(options).wait(progress)


class SeparationResult(Handle):
    """Bodies that were pushed apart."""

    kind = "separation_result"

    def __repr__(self) -> str:
        return f"SeparationResult({self.summary['ending']} after {self.summary['rounds']} rounds)"

    def points(self, body: int) -> NDArray[numpy.float64]:
        """Give the points of a body's surface.

        Parameters
        ----------
        body : int
            Its number.

        Returns
        -------
        ndarray of float64, shape (n, 3)
            In its order.
        """
        return native.floats("separation_result_points", self, 3, body)

    def tet_points(self, body: int) -> NDArray[numpy.float64]:
        """Give the points of a body's tets.

        Parameters
        ----------
        body : int
            Its number.

        Returns
        -------
        ndarray of float64, shape (k, 3)
            In their order.
        """
        return native.floats("separation_result_tet_points", self, 3, body)

    @property
    def summary(self) -> SeparationSummary:
        """Why it ended, and whether all is apart."""
        found: Any = native.fill("separation_result_summary", self, interface.MlgSeparationSummary())
        found["ending"] = interface.ENDING[found["ending"]]
        found["separated"] = found["separated"] == 1
        return found  # type: ignore[no-any-return]

    @property
    def overlaps(self) -> list[Overlap]:
        """Pairs of surfaces that overlap or did."""
        return [self._part("overlap", interface.MlgOverlap(), i) for i in range(self.summary["overlap_count"])]

    def body(self, body: int) -> SeparatedBody:
        """Tell what was done to a body.

        Parameters
        ----------
        body : int
            Its number.

        Returns
        -------
        SeparatedBody
        """
        found: SeparatedBody = self._part("body", interface.MlgSeparatedBody(), body)
        return found

    def _part(self, what: str, struct: Any, number: int) -> Any:
        native.call(f"separation_result_{what}", self, number, byref(struct))
        found = struct.fields()
        found.pop("reserved", None)
        return {key: value if isinstance(value, (int, float)) else tuple(value) for key, value in found.items()}
