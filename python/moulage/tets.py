"""Filling a surface with tets."""

from __future__ import annotations

import os
from ctypes import byref
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypedDict

import numpy
from numpy.typing import NDArray

from . import interface, native
from .handles import Handle
from .meshes import Surface, TetMesh, TriMesh
from .runs import Run

if TYPE_CHECKING:
    import pyvista

Method: TypeAlias = Literal["auto", "tetgen", "lattice"]


class TetQuality(TypedDict):
    """How good tets are."""

    tet_count: int
    inverted_count: int
    """Tets of no or negative volume."""
    volume: float
    min_dihedral: float
    """The smallest angle between two faces of a tet, degrees."""
    max_dihedral: float
    min_radius_ratio: float
    """Three inner radii over the outer one: 1 for a regular tet, 0 for a flat one."""
    mean_radius_ratio: float
    dihedral_histogram: list[int]
    """Dihedral angles in steps of ten degrees."""


class Tetrahedralization(Handle):
    """Tets that carry a surface. Immutable.

    Parameters
    ----------
    surface : TriMesh, trimesh.Trimesh or pyvista.PolyData
        The template.
    method : {"auto", "tetgen", "lattice"}
        "auto": TetGen where it is installed and the surface is clean, else the built-in lattice.
    tet_count : int
        About how many, 24 to 10 million.
    tetgen : path, optional
        The program TetGen; else the environment variable MOULAGE_TETGEN names it, or it is searched for.

    Raises
    ------
    Error
        Where the surface has no inside, or TetGen was asked for and failed.
    """

    kind = "tetrahedralization"
    surface: TriMesh
    """What the tets carry."""

    def __init__(
        self, surface: Surface, method: Method = "auto", tet_count: int = 15000, tetgen: str | os.PathLike[str] | None = None
    ) -> None:
        # By a run: Ctrl-C reaches it.
        made = self.start(surface, method, tet_count, tetgen).wait()
        super().__init__(made._handle)
        self.surface, made._handle = made.surface, None

    @classmethod
    def start(
        cls, surface: Surface, method: Method = "auto", tet_count: int = 15000,
        tetgen: str | os.PathLike[str] | None = None,
    ) -> Run[Tetrahedralization]:
        """Do the same without waiting.

        Parameters
        ----------
        surface : TriMesh, trimesh.Trimesh or pyvista.PolyData
            The template.
        method : {"auto", "tetgen", "lattice"}
            As of the class.
        tet_count : int
            About how many.
        tetgen : path, optional
            The program TetGen.

        Returns
        -------
        Run
            Its result is the `Tetrahedralization`.
        """
        carried, options = TriMesh.of(surface), _options(method, tet_count, tetgen)
        run = native.make("tetrahedralization_start", carried, options)
        return Run(run, "run_wait_tetrahedralization", lambda handle: cls._carrying(handle, carried))

    @classmethod
    def from_tets(cls, surface: Surface, tets: TetMesh) -> Tetrahedralization:
        """Take tets that were made elsewhere.

        Parameters
        ----------
        surface : TriMesh, trimesh.Trimesh or pyvista.PolyData
            What they are to carry.
        tets : TetMesh

        Returns
        -------
        Tetrahedralization

        Raises
        ------
        Error
            Where they do not reach the surface.
        """
        carried = TriMesh.of(surface)
        return cls._carrying(native.make("tetrahedralization_from_tets", carried, tets), carried)

    @classmethod
    def _carrying(cls, handle: Any, surface: TriMesh) -> Tetrahedralization:
        made = cls._take(handle)
        made.surface = surface
        return made

    def __repr__(self) -> str:
        return f"Tetrahedralization({len(self.points)} points, {len(self.tets)} tets, by {self.method})"

    @property
    def points(self) -> NDArray[numpy.float64]:
        """The points of the tets, shape (n, 3)."""
        return native.floats("tetrahedralization_points", self, 3)

    @property
    def tets(self) -> NDArray[numpy.uint32]:
        """Numbers of points, shape (m, 4)."""
        return native.indices("tetrahedralization_tets", self, 4)

    @property
    def inside_fractions(self) -> NDArray[numpy.float64]:
        """The share of each tet inside the surface, 0 to 1, shape (m,)."""
        return native.floats("tetrahedralization_inside_fractions", self, 1)

    @property
    def method(self) -> str:
        """What made the tets: "tetgen", "lattice" or "given"."""
        number = native.get("tetrahedralization_method", self)
        return next(name for name, value in interface.TETS.items() if value == number)

    @property
    def boundary_kept(self) -> bool:
        """Whether the surface's own triangles are the boundary of the tets."""
        return bool(native.get("tetrahedralization_boundary_kept", self) == 1)

    @property
    def warnings(self) -> list[str]:
        """What to look at, one sentence each."""
        count = native.get("tetrahedralization_warning_count", self)
        return [native.label("tetrahedralization_warning", self, i) or "" for i in range(count)]

    @property
    def quality(self) -> TetQuality:
        """Shapes, angles and volume of the tets."""
        return quality(self, "tetrahedralization_quality")

    def to_pyvista(self) -> pyvista.UnstructuredGrid:
        """Give the tets to pyvista.

        Returns
        -------
        pyvista.UnstructuredGrid
        """
        return TetMesh(self.points, self.tets).to_pyvista()


def _options(method: str, tet_count: int, tetgen: str | os.PathLike[str] | None) -> interface.MlgTetrahedralizationOptions:
    if method not in ("auto", "tetgen", "lattice"):
        raise ValueError(f"method {method!r} is not known; auto, tetgen and lattice are")
    options = interface.MlgTetrahedralizationOptions()
    native.get("tetrahedralization_options_init", byref(options), options.struct_size)
    options.method, options.tet_count = interface.TETS[method], tet_count
    options.tetgen_path = native.path(tetgen) if tetgen else None
    return options


def quality(handle: Any, function: str) -> TetQuality:
    """The quality of the tets that a handle has."""
    found: Any = native.fill(function, handle, interface.MlgTetQuality())
    found["dihedral_histogram"] = list(found["dihedral_histogram"])
    return found  # type: ignore[no-any-return]
