"""Skeletons: bones and the joints between them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from ctypes import addressof, byref, c_size_t, create_string_buffer, sizeof
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy
from numpy.typing import ArrayLike, NDArray

from . import exchange, interface, native
from .handles import Handle
from .meshes import Surface, TriMesh

if TYPE_CHECKING:
    import pyvista

_FREE = (numpy.inf, numpy.inf, numpy.inf)


@dataclass
class Joint:
    """A joint between two bones.

    Frames are matrices, world from frame, in the skeleton's pose: on the parent bone, and on the child bone (the same in
    the neutral position); None for both: in the middle of the narrowest gap.

    Parameters
    ----------
    name : str
    parent : int
        The number of the parent bone, from 0.
    child : int
        The number of the child bone, from 0.
    parent_frame : array_like, optional
        Shape (4, 4).
    child_frame : array_like, optional
        Shape (4, 4).
    negative_limits : sequence of float, optional
        The largest rotations about -x, -y, -z of the frame, radians, 0 or more; infinity: free.
    positive_limits : sequence of float, optional
        The same about x, y, z.
    shift_limit : float, optional
        How far the two frames' origins may come apart; None: half a percent of the skeleton's diagonal.
    in_tree : bool, optional
        Whether it is one of those that make the skeleton a tree; others close loops.
    """

    name: str
    parent: int
    child: int
    parent_frame: ArrayLike | None = None
    child_frame: ArrayLike | None = None
    negative_limits: Sequence[float] = _FREE
    positive_limits: Sequence[float] = _FREE
    shift_limit: float | None = None
    in_tree: bool = True

    def _struct(self) -> interface.MlgJoint:
        found = interface.MlgJoint()
        native.get("joint_init", byref(found), found.struct_size)
        found.name = self.name.encode("utf-8")
        found.parent, found.child, found.in_tree = self.parent, self.child, int(self.in_tree)
        if self.parent_frame is not None or self.child_frame is not None:
            parent = self.child_frame if self.parent_frame is None else self.parent_frame
            child = self.parent_frame if self.child_frame is None else self.child_frame
            found.has_frames = 1
            found.world_from_parent_frame[:] = _frame(parent, self.name)
            found.world_from_child_frame[:] = _frame(child, self.name)
        found.negative_limits[:], found.positive_limits[:] = self.negative_limits, self.positive_limits
        if self.shift_limit is not None:
            found.shift_limit = self.shift_limit
        return found

    @classmethod
    def _of(cls, found: interface.MlgJoint) -> Joint:
        parent_frame, child_frame = found.world_from_parent_frame, found.world_from_child_frame
        return cls(
            found.name.decode("utf-8", "replace"), found.parent, found.child, numpy.reshape(parent_frame, (4, 4)),
            numpy.reshape(child_frame, (4, 4)), tuple(found.negative_limits), tuple(found.positive_limits),
            found.shift_limit, bool(found.in_tree),
        )


def _frame(matrix: Any, name: str) -> list[float]:
    flat = numpy.asarray(matrix, dtype=float)
    if flat.shape != (4, 4):
        raise ValueError(f"joint {name}: a frame has the shape (4, 4), not {flat.shape}")
    return [float(value) for value in flat.ravel()]


class Skeleton(Handle):
    """Bones with names and the joints between them. Immutable.

    Parameters
    ----------
    bones : iterable of (str, surface)
        Names, and surfaces as `TriMesh`, ``trimesh.Trimesh`` or ``pyvista.PolyData``.
    joints : iterable of Joint

    Raises
    ------
    Error
        Where two bones have one name, or a joint names a bone that is not there.
    """

    kind = "skeleton"

    def __init__(self, bones: Iterable[tuple[str, Surface]], joints: Iterable[Joint] = ()) -> None:
        kept = [(name, TriMesh.of(surface)) for name, surface in bones]
        given = (interface.MlgBone * len(kept))()
        for place, (name, surface) in zip(given, kept):
            place.struct_size = sizeof(interface.MlgBone)
            place.name, place.surface = name.encode("utf-8"), surface._handle
        structs = [joint._struct() for joint in joints]
        super().__init__(
            native.make("skeleton_new", given, len(given), (interface.MlgJoint * len(structs))(*structs), len(structs))
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Skeleton:
        """Read a file.

        Parameters
        ----------
        path : path
            .skeleton.json, or an OpenSim 4 .osim model, with the surfaces it names.

        Returns
        -------
        Skeleton

        Raises
        ------
        Error
            Names the file and what is wrong in it.
        """
        return cls._take(native.make("skeleton_load", native.path(path)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a file.

        Parameters
        ----------
        path : path
            .skeleton.json with bones/ beside it, or a .glb scene.
        """
        native.call("skeleton_save", self, native.path(path))

    def save_osim(
        self, model: str | os.PathLike[str], path: str | os.PathLike[str], mass: float | None = None
    ) -> list[str]:
        """Write this person into an OpenSim model.

        Parameters
        ----------
        model : path
            The .osim model that the template was converted from.
        path : path
            The .osim model to write; bones go into a folder of its name in Geometry/ beside it.
        mass : float, optional
            Of the person, kg. Without it the bodies keep the template's density.

        Returns
        -------
        list of str
            What was not carried over, one sentence each.
        """
        length = c_size_t()
        buffer = create_string_buffer(65536)
        function, kilograms = ("skeleton_save_osim", ()) if mass is None else ("skeleton_save_osim_mass", (mass,))
        native.call(
            function, self, native.path(model), *kilograms, native.path(path), addressof(buffer), len(buffer),
            byref(length),
        )
        return buffer.value.decode("utf-8", "replace").splitlines()

    def save_motion(
        self, motion: str | os.PathLike[str], path: str | os.PathLike[str], flipped: Sequence[str] = (),
        unit_in_metres: float = 0.0,
    ) -> None:
        """Write a scene that moves as a file says.

        Parameters
        ----------
        motion : path
            OpenSim's .mot or .sto, or a .bvh whose nodes are named as the bones.
        path : path
            The .glb scene to write.
        flipped : sequence of str
            Names of angles of the opposite sign.
        unit_in_metres : float
            Of the skeleton; 0: found by its size.
        """
        names = native.texts(list(flipped))
        native.call(
            "skeleton_save_motion", self, native.path(motion), names, len(names), unit_in_metres, native.path(path)
        )

    def __repr__(self) -> str:
        return f"Skeleton({len(self.bone_names)} bones, {len(self.joints)} joints)"

    @property
    def bone_names(self) -> list[str]:
        """The bones' names, in their order."""
        count = native.get("skeleton_bone_count", self)
        return [native.label("skeleton_bone_name", self, i) or "" for i in range(count)]

    def bone(self, bone: int | str) -> TriMesh:
        """Give a bone's surface.

        Parameters
        ----------
        bone : int or str
            Its number from 0, or its name.

        Returns
        -------
        TriMesh

        Raises
        ------
        KeyError, IndexError
            Where there is no such bone.
        """
        return TriMesh(self.bone_points(bone), self.bone_triangles(bone))

    def bone_points(self, bone: int | str) -> NDArray[numpy.float64]:
        """Give the points of a bone.

        Parameters
        ----------
        bone : int or str
            Its number from 0, or its name.

        Returns
        -------
        ndarray of float64, shape (n, 3)
        """
        return native.floats("skeleton_bone_points", self, 3, self.number(bone))

    def bone_triangles(self, bone: int | str) -> NDArray[numpy.uint32]:
        """Give the triangles of a bone.

        Parameters
        ----------
        bone : int or str
            Its number from 0, or its name.

        Returns
        -------
        ndarray of uint32, shape (m, 3)
            Numbers of its own points.
        """
        return native.indices("skeleton_bone_triangles", self, 3, self.number(bone))

    @property
    def surface(self) -> TriMesh:
        """All bones as one surface, one after the other."""
        triangles, start = [], 0
        for bone in range(len(self.bone_names)):
            triangles.append(self.bone_triangles(bone).astype(numpy.int64) + start)
            start += len(self.bone_points(bone))
        return TriMesh(self.points, numpy.concatenate(triangles))

    def number(self, bone: int | str) -> int:
        """Tell the number of a bone.

        Parameters
        ----------
        bone : int or str
            Its name; a number is returned as it is.

        Returns
        -------
        int
        """
        if not isinstance(bone, str):
            return bone
        names = self.bone_names
        if bone not in names:
            raise KeyError(f"there is no bone {bone!r}; there are {', '.join(names)}")
        return names.index(bone)

    @property
    def points(self) -> NDArray[numpy.float64]:
        """The points of all bones, one bone after the other, as previews have them, shape (n, 3)."""
        return native.floats("skeleton_points", self, 3)

    @property
    def joints(self) -> list[Joint]:
        """The joints, with their frames in this pose."""
        found = []
        for number in range(native.get("skeleton_joint_count", self)):
            struct = interface.MlgJoint()
            native.call("skeleton_joint", self, number, byref(struct))
            found.append(Joint._of(struct))
        return found

    @property
    def angles(self) -> dict[str, float]:
        """The named angles of the joints in the skeleton's pose, radians."""
        values = native.floats("skeleton_angles", self, 1)
        return {native.label("skeleton_angle_name", self, i) or "": float(v) for i, v in enumerate(values)}

    @property
    def notes(self) -> list[str]:
        """What was left out when it was read, one sentence each."""
        return (native.label("skeleton_notes", self) or "").splitlines()

    def to_pyvista(self) -> pyvista.MultiBlock:
        """Give all bones to pyvista.

        Returns
        -------
        pyvista.MultiBlock
            A block for each bone, by its name.
        """
        made = exchange.imported("pyvista", "to_pyvista").MultiBlock()
        for number, name in enumerate(self.bone_names):
            made.append(self.bone(number).to_pyvista(), name)
        return made  # type: ignore[no-any-return,unused-ignore]
