"""Surfaces of triangles, and tets."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy
from numpy.typing import ArrayLike, NDArray

from . import exchange, interface, native
from .exchange import PolyDataLike, TrimeshLike
from .handles import Handle
from .native import address, array

if TYPE_CHECKING:
    import pyvista
    import trimesh


class TriMesh(Handle):
    """A triangle surface, in any unit. Immutable.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        In any unit.
    triangles : array_like of int, shape (m, 3)
        Numbers of points, from 0, counter-clockwise seen from outside.

    Raises
    ------
    ValueError
        Where the shapes are others, or an index is no whole number.
    Error
        Where a triangle names a point that is not there, or a coordinate is not finite.
    """

    kind = "tri_mesh"

    def __init__(self, points: ArrayLike, triangles: ArrayLike) -> None:
        points = array(points, 3, numpy.float64, "points")
        triangles = array(triangles, 3, numpy.uint32, "triangles")
        super().__init__(
            native.make("tri_mesh_new", address(points), len(points), address(triangles), len(triangles))
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> TriMesh:
        """Read a file.

        Parameters
        ----------
        path : path
            .obj, .ply or .stl.

        Returns
        -------
        TriMesh

        Raises
        ------
        Error
            Names the file and the line.
        """
        return cls._take(native.make("tri_mesh_load", native.path(path)))

    @classmethod
    def of(cls, surface: Surface) -> TriMesh:
        """Take another package's surface. All methods that take a surface do so by themselves.

        Parameters
        ----------
        surface : TriMesh, trimesh.Trimesh or pyvista.PolyData
            Polygons of pyvista are split into triangles.

        Returns
        -------
        TriMesh
            The same object if it is one already.

        Raises
        ------
        TypeError
            Where it is none of these.
        """
        return surface if isinstance(surface, TriMesh) else cls(*exchange.triangles_of(surface))

    def save(self, path: str | os.PathLike[str], points: ArrayLike | None = None) -> None:
        """Write a file.

        Parameters
        ----------
        path : path
            .obj, .ply or .stl.
        points : array_like, shape (n, 3), optional
            In place of its own.
        """
        given = None if points is None else array(points, 3, numpy.float64, "points")
        count = 0 if given is None else len(given)
        native.call("tri_mesh_save", self, address(given), count, native.path(path))

    def to_trimesh(self) -> trimesh.Trimesh:
        """Give it to trimesh, with its points and triangles in their order.

        Returns
        -------
        trimesh.Trimesh
        """
        made = exchange.imported("trimesh", "to_trimesh").Trimesh(self.points, self.triangles, process=False)
        return made  # type: ignore[no-any-return,unused-ignore]

    def to_pyvista(self) -> pyvista.PolyData:
        """Give it to pyvista, with its points and triangles in their order.

        Returns
        -------
        pyvista.PolyData
        """
        return exchange.polydata(self.points, self.triangles)

    def __repr__(self) -> str:
        return f"TriMesh({len(self.points)} points, {len(self.triangles)} triangles)"

    @property
    def points(self) -> NDArray[numpy.float64]:
        """Its points, shape (n, 3)."""
        return native.floats("tri_mesh_points", self, 3)

    @property
    def triangles(self) -> NDArray[numpy.uint32]:
        """Numbers of points, shape (m, 3)."""
        return native.indices("tri_mesh_triangles", self, 3)

    def align(
        self, markers: ArrayLike = (), landmarks: ArrayLike = (), targets: ArrayLike = (),
        freedom: Literal["rigid", "similarity"] = "rigid",
    ) -> NDArray[numpy.float64]:
        """Find where to put a template so that markers lie on its surface and landmarks near their targets.

        Parameters
        ----------
        markers : array_like, shape (n, 3)
            Points of the person's surface.
        landmarks, targets : array_like, shape (k, 3)
            Points on the template, and where they are on the person.
        freedom : {"rigid", "similarity"}
            Whether the size may change.

        Returns
        -------
        ndarray of float64, shape (4, 4)
            The matrix of the person from the template.
        """
        markers = array(markers, 3, numpy.float64, "markers")
        landmarks = array(landmarks, 3, numpy.float64, "landmarks")
        targets = array(targets, 3, numpy.float64, "targets")
        if len(landmarks) != len(targets):
            raise ValueError(f"{len(landmarks)} landmarks but {len(targets)} targets")
        motion = numpy.empty((4, 4))
        native.call(
            "tri_mesh_align", self, interface.ALIGN[freedom], address(markers), len(markers),
            address(landmarks), address(targets), len(landmarks), address(motion),
        )
        return motion

    def distances_to(self, points: ArrayLike) -> NDArray[numpy.float64]:
        """Measure from each vertex to the nearest of some points: how well markers support each place.

        Parameters
        ----------
        points : array_like, shape (k, 3)

        Returns
        -------
        ndarray of float64, shape (n,)
        """
        points = array(points, 3, numpy.float64, "points")
        distances = numpy.empty(len(self.points))
        native.call("tri_mesh_distances_to_points", self, address(points), len(points), address(distances))
        return distances

    def distances_of(self, points: ArrayLike) -> NDArray[numpy.float64]:
        """Measure from each of some points to the surface: how well a result meets its markers.

        Parameters
        ----------
        points : array_like, shape (k, 3)

        Returns
        -------
        ndarray of float64, shape (k,)
        """
        points = array(points, 3, numpy.float64, "points")
        distances = numpy.empty(len(points))
        native.call("tri_mesh_distances_of_points", self, address(points), len(points), address(distances))
        return distances

    def closest_points(self, points: ArrayLike) -> NDArray[numpy.float64]:
        """Find the place on the surface that is nearest to each of some points.

        Parameters
        ----------
        points : array_like, shape (k, 3)

        Returns
        -------
        ndarray of float64, shape (k, 3)
        """
        points = array(points, 3, numpy.float64, "points")
        places = numpy.empty((len(points), 3))
        native.call("tri_mesh_closest_points", self, address(points), len(points), address(places))
        return places

    def interpolate(self, points: ArrayLike, values: ArrayLike) -> NDArray[numpy.float64]:
        """Carry values that are known at some points, such as the distances of markers, over to each vertex.

        Parameters
        ----------
        points : array_like, shape (k, 3)
            Where the values are known.
        values : array_like, shape (k,)

        Returns
        -------
        ndarray of float64, shape (n,)
            Means of the four nearest points, weighted by nearness; NaN where no point is near.
        """
        points, values = array(points, 3, numpy.float64, "points"), array(values, 1, numpy.float64, "values")
        if len(values) != len(points):
            raise ValueError(f"{len(values)} values for {len(points)} points")
        found = numpy.empty(len(self.points))
        native.call("tri_mesh_interpolate", self, address(points), address(values), len(points), address(found))
        return found

    def check(self) -> list[str]:
        """Look for what is wrong with it.

        Returns
        -------
        list of str
            One sentence each; empty for a clean, closed surface.
        """
        return native.text("tri_mesh_check", self).splitlines()


# What every method takes that takes a surface.
Surface: TypeAlias = TriMesh | TrimeshLike | PolyDataLike


def align(
    points: ArrayLike, targets: ArrayLike, freedom: Literal["rigid", "similarity"] = "rigid"
) -> NDArray[numpy.float64]:
    """Find the motion that brings points nearest to their targets, in the sense of least squares.

    Parameters
    ----------
    points, targets : array_like, shape (n, 3)
        Pairs, one at least.
    freedom : {"rigid", "similarity"}
        Whether the size may change.

    Returns
    -------
    ndarray of float64, shape (4, 4)
        The matrix of the targets from the points.
    """
    points, targets = array(points, 3, numpy.float64, "points"), array(targets, 3, numpy.float64, "targets")
    if len(targets) != len(points):
        raise ValueError(f"{len(targets)} targets for {len(points)} points")
    motion = numpy.empty((4, 4))
    native.call(
        "points_align", interface.ALIGN[freedom], address(points), address(targets), len(points), address(motion)
    )
    return motion


class TetMesh(Handle):
    """Tets, in any unit. Immutable.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        In any unit.
    tets : array_like of int, shape (m, 4)
        Numbers of points, from 0.
    """

    kind = "tet_mesh"

    def __init__(self, points: ArrayLike, tets: ArrayLike) -> None:
        points = array(points, 3, numpy.float64, "points")
        tets = array(tets, 4, numpy.uint32, "tets")
        super().__init__(native.make("tet_mesh_new", address(points), len(points), address(tets), len(tets)))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> TetMesh:
        """Read a file.

        Parameters
        ----------
        path : path
            TetGen's .ele or .node, .vtu, .veg, or .msh of Gmsh.

        Returns
        -------
        TetMesh
        """
        return cls._take(native.make("tet_mesh_load", native.path(path)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a file.

        Parameters
        ----------
        path : path
            .vtu, as ParaView reads it.
        """
        native.call("tet_mesh_save", self, native.path(path))

    def to_pyvista(self) -> pyvista.UnstructuredGrid:
        """Give it to pyvista.

        Returns
        -------
        pyvista.UnstructuredGrid
        """
        package = exchange.imported("pyvista", "to_pyvista")
        made = package.UnstructuredGrid({package.CellType.TETRA: self.tets.astype(int)}, self.points)
        return made  # type: ignore[no-any-return,unused-ignore]

    def __repr__(self) -> str:
        return f"TetMesh({len(self.points)} points, {len(self.tets)} tets)"

    @property
    def points(self) -> NDArray[numpy.float64]:
        """Its points, shape (n, 3)."""
        return native.floats("tet_mesh_points", self, 3)

    @property
    def tets(self) -> NDArray[numpy.uint32]:
        """Numbers of points, shape (m, 4)."""
        return native.indices("tet_mesh_tets", self, 4)
