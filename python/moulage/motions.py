"""Motions of skeletons."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

import numpy
from numpy.typing import ArrayLike, NDArray

from . import native
from .handles import Handle
from .native import address, array
from .skeletons import Skeleton


class Motion(Handle):
    """Named angles of a skeleton's joints over time. Immutable.

    Parameters
    ----------
    skeleton : Skeleton
    times : array_like, shape (n,)
        Seconds, rising.
    angles : mapping of str to array_like, shape (n,)
        One number for each time, radians.
    """

    kind = "motion"

    def __init__(self, skeleton: Skeleton, times: ArrayLike, angles: Mapping[str, ArrayLike]) -> None:
        names = native.texts(list(angles))
        times = array(times, 1, numpy.float64, "times")
        columns = [array(column, 1, numpy.float64, name) for name, column in angles.items()]
        if any(len(column) != len(times) for column in columns):
            raise ValueError(f"angles: every one needs {len(times)} numbers, one for each time")
        rows = numpy.ascontiguousarray(numpy.stack(columns, axis=1)) if columns else numpy.empty(0)
        super().__init__(
            native.make(
                "motion_new", skeleton, names, len(names), address(times), address(rows), len(times)
            )
        )

    @classmethod
    def load(cls, skeleton: Skeleton, path: str | os.PathLike[str], flipped: Sequence[str] = ()) -> Motion:
        """Read a file.

        Parameters
        ----------
        skeleton : Skeleton
        path : path
            OpenSim's .mot or .sto, or a .bvh whose nodes are named as the bones.
        flipped : sequence of str
            Names of angles of the opposite sign.

        Returns
        -------
        Motion
        """
        names = native.texts(list(flipped))
        return cls._take(native.make("motion_load", skeleton, native.path(path), names, len(names)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a file.

        Parameters
        ----------
        path : path
            .mot, .bvh, or a .glb scene that moves.
        """
        native.call("motion_save", self, native.path(path))

    @property
    def times(self) -> NDArray[numpy.float64]:
        """Seconds, shape (n,)."""
        return native.floats("motion_times", self, 1)

    @property
    def angles(self) -> dict[str, NDArray[numpy.float64]]:
        """By their names, radians, shape (n,) each."""
        rows = native.floats("motion_angles", self, 1).reshape(len(self.times), -1)
        return {native.label("motion_angle_name", self, k) or "": rows[:, k] for k in range(rows.shape[1])}

    @property
    def notes(self) -> str:
        """What of the motion the skeleton does not know, in a sentence; empty if it knows all."""
        return native.label("motion_notes", self) or ""
