"""What comes out of a reshaping."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, TypedDict

import numpy
from numpy.typing import ArrayLike, NDArray

from . import exchange, interface, native
from .handles import Handle
from .meshes import TriMesh
from .native import address, array
from .tets import TetQuality, quality
from .uncertainty import Uncertainty

if TYPE_CHECKING:
    import pyvista

# What the bar of a heat map says.
_HEAT = {
    "stretch": "largest stretch", "stretch_min": "smallest stretch", "moved": "distance from the template",
    "marker_distance": "distance to the nearest marker", "sd_normal": "standard deviation across the surface",
    "sd": "standard deviation",
}


class ReshapingSummary(TypedDict):
    """What happened in a reshaping. Distances are in the template's unit, NaN without markers."""

    stop: str
    """Why it ended: "settled", "tolerance_met", "no_step", "iteration_limit" or "cancelled"."""
    iterations: int
    newton_steps: int
    """Of all static solves."""
    inverted_tets: int
    """Tets of no or negative volume in the result."""
    mean_marker_distance: float
    max_marker_distance: float
    seconds: float
    remeshes: int
    """How often the shape reached was filled with new tets."""


class ReshapingResult(Handle):
    """A reshaped template."""

    kind = "reshaping_result"
    _surface: TriMesh
    _markers: NDArray[numpy.float64]

    @classmethod
    def _of(cls, handle: Any, surface: TriMesh, markers: NDArray[numpy.float64]) -> ReshapingResult:
        made = cls._take(handle)
        made._surface, made._markers = surface, markers
        return made

    def __repr__(self) -> str:
        found = self.summary
        return f"ReshapingResult({found['stop']} after {found['iterations']} iterations)"

    @property
    def surface(self) -> TriMesh:
        """The reshaped surface, with the template's triangles."""
        return TriMesh(self.points, self._surface.triangles)

    @property
    def points(self) -> NDArray[numpy.float64]:
        """The surface's points in the template's order, shape (n, 3)."""
        return native.floats("reshaping_result_points", self, 3)

    @property
    def tets(self) -> NDArray[numpy.uint32]:
        """The corners of each tet, shape (m, 4): those of the problem, unless new ones were made (``summary``)."""
        return native.indices("reshaping_result_tets", self, 4)

    @property
    def tet_points(self) -> NDArray[numpy.float64]:
        """The points of the tets, shape (k, 3)."""
        return native.floats("reshaping_result_tet_points", self, 3)

    @property
    def plastic_strains(self) -> NDArray[numpy.float64]:
        """The plastic strain Fp of each tet, symmetric, shape (m, 3, 3)."""
        return native.floats("reshaping_result_plastic_strains", self, 9).reshape(-1, 3, 3)

    @property
    def marker_distances(self) -> NDArray[numpy.float64]:
        """The distance of each marker to the result, shape (markers,)."""
        return native.floats("reshaping_result_marker_distances", self, 1)

    @property
    def landmark_distances(self) -> NDArray[numpy.float64]:
        """The distance of each landmark's place on the result to its target, shape (landmarks,)."""
        return native.floats("reshaping_result_landmark_distances", self, 1)

    @property
    def attachment_distances(self) -> NDArray[numpy.float64]:
        """The distance of each attachment's place on the result to its target, shape (attachments,)."""
        return native.floats("reshaping_result_attachment_distances", self, 1)

    @property
    def max_stretches(self) -> NDArray[numpy.float64]:
        """The largest principal stretch at each vertex of the surface, shape (n,); 1: not stretched."""
        return native.floats("reshaping_result_max_stretches", self, 1)

    @property
    def min_stretches(self) -> NDArray[numpy.float64]:
        """The smallest principal stretch at each vertex of the surface, shape (n,)."""
        return native.floats("reshaping_result_min_stretches", self, 1)

    def carry(self, points: ArrayLike) -> NDArray[numpy.float64]:
        """Move other points with the template.

        Parameters
        ----------
        points : array_like, shape (k, 3)
            Near or in the template at rest.

        Returns
        -------
        ndarray of float64, shape (k, 3)
        """
        carried: NDArray[numpy.float64] = array(points, 3, numpy.float64, "points").copy()
        native.call("reshaping_result_carry", self, address(carried), len(carried), address(carried))
        return carried

    def uncertainty(self, shapes: int = 64) -> Uncertainty:
        """Find plausible shapes beside this one, which tell how sure it is; takes about as long as one iteration.

        Parameters
        ----------
        shapes : int, default 64
            How many; 64 give a standard deviation to a tenth of itself.

        Returns
        -------
        Uncertainty
        """
        return Uncertainty._take(native.make("uncertainty_new", self, shapes))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the reshaped surface.

        Parameters
        ----------
        path : path
            .obj, .ply or .stl.
        """
        self._surface.save(path, self.points)

    def save_tets(self, path: str | os.PathLike[str]) -> None:
        """Write the deformed tets with strains, stretches and the shape at rest.

        Parameters
        ----------
        path : path
            .vtu, as ParaView reads it.
        """
        native.call("reshaping_result_save_tets", self, native.path(path))

    def to_pyvista(self) -> pyvista.PolyData:
        """Give the surface to pyvista, with its heat maps.

        Returns
        -------
        pyvista.PolyData
            Arrays of its points: ``stretch`` and ``stretch_min`` (the largest and smallest principal stretch), ``moved``
            (how far it lies from the template) and, where there are markers, ``marker_distance`` (to the nearest of them:
            how well each place is known).
        """
        points, surface = self.points, self.surface
        heat = {
            "stretch": self.max_stretches, "stretch_min": self.min_stretches,
            "moved": numpy.linalg.norm(points - self._surface.points, axis=1),
        }
        if len(self._markers):
            heat["marker_distance"] = surface.distances_to(self._markers)
        return exchange.polydata(points, surface.triangles, **heat)

    def plot(self, heat: str | None = "stretch", screenshot: str | os.PathLike[str] | None = None, **show: Any) -> Any:
        """Draw the result and its markers with pyvista.

        Parameters
        ----------
        heat : {"stretch", "stretch_min", "moved", "marker_distance", "sd_normal", "sd"} or None
            What the colours show; the last two are those of ``uncertainty``.
        screenshot : path, optional
            A picture to write, in place of a window.
        **show
            For ``pyvista.Plotter.show``.

        Returns
        -------
        object
            What ``pyvista.Plotter.show`` returns.
        """
        return exchange.drawn(self._layers(heat), screenshot, show)

    def _layers(self, heat: str | None) -> Iterator[exchange.Layer]:
        colours = exchange.heat_map(heat, _HEAT.get(heat or "", heat))
        surface = self.to_pyvista()
        if heat in ("sd_normal", "sd"):
            surface[heat] = getattr(self.uncertainty(), heat)
        yield surface, {"color": "lightgray", "smooth_shading": True, **colours}
        if len(self._markers):
            yield self._markers, {"style": "points", "color": "black", "point_size": 6, "render_points_as_spheres": True}

    @property
    def summary(self) -> ReshapingSummary:
        """Why it ended and how far it is from its data."""
        found: Any = native.fill("reshaping_result_summary", self, interface.MlgReshapingSummary())
        found.pop("reserved")
        found["stop"] = interface.STOP[found["stop"]]
        return found  # type: ignore[no-any-return]

    @property
    def quality(self) -> TetQuality:
        """Shapes, angles and volume of the deformed tets."""
        return quality(self, "reshaping_result_quality")
