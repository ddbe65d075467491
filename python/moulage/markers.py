"""Points that somebody marked, and pairs of points."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy
from numpy.typing import ArrayLike, NDArray

from . import interface, native
from .handles import Handle
from .meshes import Surface, TriMesh
from .native import address, array


class Markers(Handle):
    """Points that somebody marked on a person's surface. Immutable.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        In the template's unit.
    weights : array_like, shape (n,), optional
        1 where none are given.
    labels : sequence of str or None, optional
        A name for each, or None.
    """

    kind = "markers"

    def __init__(
        self, points: ArrayLike, weights: ArrayLike | None = None, labels: Sequence[str | None] | None = None
    ) -> None:
        points = array(points, 3, numpy.float64, "points")
        checked = checked_weights(weights, len(points))
        if labels is not None and len(labels) != len(points):
            raise ValueError(f"{len(labels)} labels for {len(points)} points")
        super().__init__(
            native.make("markers_new", address(points), address(checked), native.texts(labels), len(points))
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Markers:
        """Read a file.

        Parameters
        ----------
        path : path
            .csv, .xyz, .ply, 3D Slicer's .mrk.json or .fcsv (turned into RAS), MeshLab's .pp.

        Returns
        -------
        Markers
        """
        return cls._take(native.make("markers_load", native.path(path)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a file.

        Parameters
        ----------
        path : path
            .csv, .mrk.json or .fcsv (said to be RAS), or .pp.
        """
        native.call("markers_save", self, native.path(path))

    def __repr__(self) -> str:
        return f"Markers({len(self.points)} points)"

    @property
    def points(self) -> NDArray[numpy.float64]:
        """The points, shape (n, 3)."""
        return native.floats("markers_points", self, 3)

    @property
    def weights(self) -> NDArray[numpy.float64]:
        """How much each counts, shape (n,)."""
        return native.floats("markers_weights", self, 1)

    @property
    def sigmas(self) -> NDArray[numpy.float64]:
        """The noise of each, shape (n,), in the points' unit; 0 where none was given."""
        return native.floats("markers_sigmas", self, 1)

    @property
    def labels(self) -> list[str | None]:
        """The name of each, or None."""
        return [native.label("markers_label", self, i) for i in range(len(self.weights))]


class Pairs(Handle):
    """Places on a template and where they are on the person, for landmarks and attachments. Immutable.

    Parameters
    ----------
    template_points, targets : array_like, shape (n, 3)
        The places, and where they are on the person.
    weights : array_like, shape (n,), optional
        How much each counts; 1 where left out.
    labels : sequence of str or None, optional
        The name of each; its number where left out.
    """

    kind = "pairs"
    NO_VERTEX: int = interface.NO_VERTEX

    def __init__(
        self, template_points: ArrayLike, targets: ArrayLike, weights: ArrayLike | None = None,
        labels: Sequence[str | None] | None = None,
    ) -> None:
        places = array(template_points, 3, numpy.float64, "template_points")
        targets = array(targets, 3, numpy.float64, "targets")
        for count, what in ((len(targets), "targets"), (len(places if labels is None else labels), "labels")):
            if count != len(places):
                raise ValueError(f"{count} {what} for {len(places)} template_points")
        checked = checked_weights(weights, len(places))
        super().__init__(
            native.make(
                "pairs_new", address(places), address(targets), address(checked), native.texts(labels), len(places)
            )
        )

    @classmethod
    def load_landmarks(
        cls, surface: Surface, path: str | os.PathLike[str], person_path: str | os.PathLike[str] | None = None
    ) -> Pairs:
        """Read pairs, or pair two files of markers by their labels.

        Parameters
        ----------
        surface : TriMesh, trimesh.Trimesh or pyvista.PolyData
            The template.
        path : path
            A .csv file of pairs, or the template's markers.
        person_path : path, optional
            The person's markers.

        Returns
        -------
        Pairs

        Raises
        ------
        Error
            Names the file and the line.
        """
        person = native.path(person_path) if person_path else None
        return cls._take(native.make("pairs_load_landmarks", TriMesh.of(surface), native.path(path), person))

    @classmethod
    def load_attachments(cls, surface: Surface, path: str | os.PathLike[str], keep_gap: bool = True) -> Pairs:
        """Read pairs.

        Parameters
        ----------
        surface : TriMesh, trimesh.Trimesh or pyvista.PolyData
            The template.
        path : path
            A .csv file.
        keep_gap : bool
            Whether the template's distance to the bone is kept.

        Returns
        -------
        Pairs
        """
        return cls._take(
            native.make("pairs_load_attachments", TriMesh.of(surface), native.path(path), int(keep_gap))
        )

    @classmethod
    def from_bone(cls, surface: Surface, bone: Surface, person_bone: Surface, distance: float) -> Pairs:
        """Attach each vertex of a bone that is near a surface to the place nearest to it.

        Parameters
        ----------
        surface, bone : TriMesh, trimesh.Trimesh or pyvista.PolyData
            The template's soft tissue and its bone.
        person_bone : TriMesh, trimesh.Trimesh or pyvista.PolyData
            The same vertices where the person has them.
        distance : float
            How near, in the template's unit.

        Returns
        -------
        Pairs
        """
        template, near, there = (TriMesh.of(each) for each in (surface, bone, person_bone))
        return cls._take(native.make("pairs_from_bone", template, near, there, distance))

    @classmethod
    def from_vertices(cls, surface: Surface, vertices: ArrayLike, bone: Surface, person_bone: Surface) -> Pairs:
        """Attach chosen vertices of a surface to a bone, each at the bone's vertex nearest to it.

        Parameters
        ----------
        surface : TriMesh, trimesh.Trimesh or pyvista.PolyData
            The template's soft tissue.
        vertices : array_like of int, shape (k,)
            Of the surface.
        bone : TriMesh, trimesh.Trimesh or pyvista.PolyData
            The template's bone.
        person_bone : TriMesh, trimesh.Trimesh or pyvista.PolyData
            The bone's vertices where the person has them.

        Returns
        -------
        Pairs
        """
        template, near, there = (TriMesh.of(each) for each in (surface, bone, person_bone))
        held = array(vertices, 1, numpy.uint32, "vertices")
        return cls._take(native.make("pairs_from_vertices", template, address(held), len(held), near, there))

    def __repr__(self) -> str:
        return f"Pairs({len(self.targets)} pairs)"

    @property
    def template_points(self) -> NDArray[numpy.float64]:
        """The places on the template, shape (n, 3)."""
        return native.floats("pairs_template_points", self, 3)

    @property
    def template_vertices(self) -> NDArray[numpy.uint32]:
        """The vertex of the template that each place is, shape (n,); ``Pairs.NO_VERTEX`` where it is none."""
        return native.indices("pairs_template_vertices", self, 1)

    @property
    def targets(self) -> NDArray[numpy.float64]:
        """Where they are on the person, shape (n, 3)."""
        return native.floats("pairs_targets", self, 3)

    @property
    def weights(self) -> NDArray[numpy.float64]:
        """How much each counts, shape (n,)."""
        return native.floats("pairs_weights", self, 1)

    @property
    def within(self) -> NDArray[numpy.float64]:
        """How far each pin may end from its target, shape (n,); below 0 where a landmark is none."""
        return native.floats("pairs_within", self, 1)

    @property
    def labels(self) -> list[str | None]:
        """The name of each, or None."""
        return [native.label("pairs_label", self, i) for i in range(len(self.weights))]

    @property
    def warning(self) -> str | None:
        """What was left out, as a sentence, or None."""
        return native.label("pairs_warning", self)


def checked_weights(weights: ArrayLike | None, count: int) -> NDArray[numpy.float64] | None:
    """Weights for a call, or None for 1 throughout."""
    if weights is None:
        return None
    checked = array(weights, 1, numpy.float64, "weights")
    if len(checked) != count:
        raise ValueError(f"{len(checked)} weights for {count} points")
    return checked
