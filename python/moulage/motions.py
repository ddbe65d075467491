"""Motions of skeletons."""

import numpy

from . import native
from .native import address, array
from .shapes import Handle


class Motion(Handle):
    """Named angles of a skeleton's joints over time; immutable."""

    kind = "motion"

    def __init__(self, skeleton, times, angles):
        """`times`: seconds, rising. `angles`: a dict from names to one number per time, radians."""
        names = native.texts(list(angles))
        times = array(times, 1, numpy.float64, "times")
        columns = [array(column, 1, numpy.float64, name) for name, column in angles.items()]
        if any(len(column) != len(times) for column in columns):
            raise ValueError(f"angles: every one needs {len(times)} numbers, one for each time")
        rows = numpy.ascontiguousarray(numpy.stack(columns, axis=1)) if columns else numpy.empty(0)
        super().__init__(
            native.make(
                "motion_new", skeleton._handle, names, len(names), address(times), address(rows), len(times)
            )
        )

    @classmethod
    def load(cls, skeleton, path, flipped=()):
        """Reads OpenSim's .mot or .sto, or a .bvh whose nodes are named as the bones. `flipped`: angles of the opposite
        sign."""
        names = native.texts(list(flipped))
        return cls._take(native.make("motion_load", skeleton._handle, native.path(path), names, len(names)))

    def save(self, path):
        """Writes .mot, .bvh, or a .glb scene that moves."""
        native.call("motion_save", self._handle, native.path(path))

    @property
    def times(self):
        """Seconds."""
        return native.borrowed("motion_times", self._handle, 1, numpy.float64)

    @property
    def angles(self):
        """A dict from names to one number per time, radians."""
        flat = native.borrowed("motion_angles", self._handle, 1, numpy.float64)
        rows = flat.reshape(len(self.times), -1)
        return {native.label("motion_angle_name", self._handle, k): rows[:, k] for k in range(rows.shape[1])}

    @property
    def notes(self):
        """What of the motion the skeleton does not know, in a sentence; empty if it knows all."""
        return native.label("motion_notes", self._handle) or ""
