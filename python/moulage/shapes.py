"""Meshes, markers, pairs of points."""

import numpy

from . import interface, native
from .native import address, array


class Handle:
    """Owns something of the library until it is garbage. Subclasses name their kind."""

    kind = ""

    def __init__(self, handle):
        self._handle = handle

    @classmethod
    def _take(cls, handle):
        """Wraps a handle made by another call."""
        new = cls.__new__(cls)
        Handle.__init__(new, handle)
        return new

    def __del__(self):
        handle, self._handle = getattr(self, "_handle", None), None
        if handle and native is not None and not native.forked:
            native.get(f"{self.kind}_free", handle)

    def __reduce_ex__(self, _protocol):
        # The copy would free what this still has; in another process its number means something else or nothing.
        raise TypeError(f"a {type(self).__name__} cannot be copied or pickled: pass its arrays, or a file it is saved to")


class TriMesh(Handle):
    """A triangle surface: `points` (n, 3), `triangles` (m, 3) from 0, counter-clockwise seen from
    outside. In any unit."""

    kind = "tri_mesh"

    def __init__(self, points, triangles):
        points = array(points, 3, numpy.float64, "points")
        triangles = array(triangles, 3, numpy.uint32, "triangles")
        super().__init__(
            native.make("tri_mesh_new", address(points), len(points), address(triangles), len(triangles))
        )

    @classmethod
    def load(cls, path):
        """Reads an .obj, .ply or .stl file."""
        return cls._take(native.make("tri_mesh_load", native.path(path)))

    def save(self, path, points=None):
        """Writes an .obj, .ply or .stl file, with moved points if they are given."""
        points = None if points is None else array(points, 3, numpy.float64, "points")
        count = 0 if points is None else len(points)
        native.call("tri_mesh_save", self._handle, address(points), count, native.path(path))

    @property
    def points(self):
        return native.borrowed("tri_mesh_points", self._handle, 3, numpy.float64)

    @property
    def triangles(self):
        return native.borrowed("tri_mesh_triangles", self._handle, 3, numpy.uint32)

    def align(self, markers=(), landmarks=(), targets=(), freedom="rigid"):
        """Where to put the template so that markers (n, 3) lie on its surface and landmarks (k, 3) near
        their targets: the matrix (4, 4) of the person from the template. `freedom`: rigid or similarity."""
        markers = array(markers, 3, numpy.float64, "markers")
        landmarks = array(landmarks, 3, numpy.float64, "landmarks")
        targets = array(targets, 3, numpy.float64, "targets")
        if len(landmarks) != len(targets):
            raise ValueError(f"{len(landmarks)} landmarks but {len(targets)} targets")
        motion = numpy.empty((4, 4))
        native.call(
            "tri_mesh_align", self._handle, interface.ALIGN[freedom], address(markers), len(markers),
            address(landmarks), address(targets), len(landmarks), address(motion),
        )
        return motion

    def distances_to(self, points):
        """The distance of each vertex to the nearest of some points (n, 3): how well markers support each place."""
        points = array(points, 3, numpy.float64, "points")
        distances = numpy.empty(len(self.points))
        native.call(
            "tri_mesh_distances_to_points", self._handle, address(points), len(points), address(distances)
        )
        return distances

    def distances_of(self, points):
        """The distance of each of some points (n, 3) to the surface: how well a result meets its markers."""
        points = array(points, 3, numpy.float64, "points")
        distances = numpy.empty(len(points))
        native.call(
            "tri_mesh_distances_of_points", self._handle, address(points), len(points), address(distances)
        )
        return distances

    def check(self):
        """What is wrong with it, one sentence each; empty for a clean, closed surface."""
        return native.text("tri_mesh_check", self._handle).splitlines()


class TetMesh(Handle):
    """Tets: `points` (n, 3), `tets` (m, 4) from 0."""

    kind = "tet_mesh"

    def __init__(self, points, tets):
        points = array(points, 3, numpy.float64, "points")
        tets = array(tets, 4, numpy.uint32, "tets")
        super().__init__(
            native.make("tet_mesh_new", address(points), len(points), address(tets), len(tets))
        )

    @classmethod
    def load(cls, path):
        """Reads a TetGen, .vtu, .veg or Gmsh .msh file."""
        return cls._take(native.make("tet_mesh_load", native.path(path)))

    def save(self, path):
        """Writes a .vtu file."""
        native.call("tet_mesh_save", self._handle, native.path(path))

    @property
    def points(self):
        return native.borrowed("tet_mesh_points", self._handle, 3, numpy.float64)

    @property
    def tets(self):
        return native.borrowed("tet_mesh_tets", self._handle, 4, numpy.uint32)


class Markers(Handle):
    """Points that somebody marked: `points` (n, 3), `weights` (n,), `sigmas` (n,; the noise of each, 0
    where none is given), `labels` (names or None)."""

    kind = "markers"

    def __init__(self, points, weights=None, labels=None):
        points = array(points, 3, numpy.float64, "points")
        weights = checked_weights(weights, len(points))
        if labels is not None and len(labels) != len(points):
            raise ValueError(f"{len(labels)} labels for {len(points)} points")
        super().__init__(
            native.make(
                "markers_new", address(points), address(weights), native.texts(labels), len(points)
            )
        )

    @classmethod
    def load(cls, path):
        """Reads .csv, .xyz, .ply, 3D Slicer .mrk.json or .fcsv (turned into RAS), MeshLab .pp."""
        return cls._take(native.make("markers_load", native.path(path)))

    def save(self, path):
        """Writes .csv, .mrk.json or .fcsv (said to be RAS) or .pp."""
        native.call("markers_save", self._handle, native.path(path))

    @property
    def points(self):
        return native.borrowed("markers_points", self._handle, 3, numpy.float64)

    @property
    def weights(self):
        return native.borrowed("markers_weights", self._handle, 1, numpy.float64)

    @property
    def sigmas(self):
        return native.borrowed("markers_sigmas", self._handle, 1, numpy.float64)

    @property
    def labels(self):
        return [native.label("markers_label", self._handle, i) for i in range(len(self.weights))]


class Pairs(Handle):
    """Places on a template and where they are on the person: `template_points` and `targets` (n, 3),
    `weights` (n,), `labels`. For landmarks and attachments."""

    kind = "pairs"
    NO_VERTEX = interface.NO_VERTEX

    @classmethod
    def load_landmarks(cls, surface, path, person_path=None):
        """Reads a .csv file of pairs, or two marker files that are paired by their labels."""
        person = native.path(person_path) if person_path else None
        return cls._take(native.make("pairs_load_landmarks", surface._handle, native.path(path), person))

    @classmethod
    def load_attachments(cls, surface, path, keep_gap=True):
        """Reads a .csv file; `keep_gap`: the template's distance to the bone is kept."""
        return cls._take(
            native.make("pairs_load_attachments", surface._handle, native.path(path), int(keep_gap))
        )

    @classmethod
    def from_bone(cls, surface, bone, person_bone, distance):
        """Attaches each vertex of a bone within `distance` of the surface to the place nearest to it.
        `person_bone`: the same vertices where the person has them."""
        return cls._take(
            native.make("pairs_from_bone", surface._handle, bone._handle, person_bone._handle, distance)
        )

    @property
    def template_points(self):
        return native.borrowed("pairs_template_points", self._handle, 3, numpy.float64)

    @property
    def template_vertices(self):
        """The vertex of the template that each place is; NO_VERTEX where it is none."""
        return native.borrowed("pairs_template_vertices", self._handle, 1, numpy.uint32)

    @property
    def targets(self):
        return native.borrowed("pairs_targets", self._handle, 3, numpy.float64)

    @property
    def weights(self):
        return native.borrowed("pairs_weights", self._handle, 1, numpy.float64)

    @property
    def labels(self):
        return [native.label("pairs_label", self._handle, i) for i in range(len(self.weights))]

    @property
    def warning(self):
        """What was left out, as a sentence, or None."""
        return native.label("pairs_warning", self._handle)


def checked_weights(weights, count):
    """Weights for a call, or None for 1 throughout."""
    if weights is None:
        return None
    weights = array(weights, 1, numpy.float64, "weights")
    if len(weights) != count:
        raise ValueError(f"{len(weights)} weights for {count} points")
    return weights
