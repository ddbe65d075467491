"""Shape statistics of a skeleton's bones."""

import numpy

from . import native
from .native import address, array
from .shapes import Handle
from .skeletons import Skeleton


class ShapeModel(Handle):
    """Mean shape and modes of all bones of a template together, pose removed; immutable."""

    kind = "shape_model"

    def __init__(self, template, samples):
        """Learnt from two or more Skeletons with the template's bones and vertices, in any pose."""
        handles = _handles(samples)
        super().__init__(native.make("shape_model_fit", template._handle, address(handles), len(handles)))

    @classmethod
    def load(cls, template, path):
        """Reads a .h5.json file, as `save` and scalismo write it."""
        return cls._take(native.make("shape_model_load", template._handle, native.path(path)))

    def save(self, path):
        """Writes .h5.json, in single precision."""
        native.call("shape_model_save", self._handle, native.path(path))

    @property
    def deviations(self):
        """How far the surface moves at one standard deviation of each mode, root mean square; falling."""
        return native.borrowed("shape_model_deviations", self._handle, 1, numpy.float64)

    @property
    def explained(self):
        """The share of the variance in the first modes, rising to 1."""
        return native.borrowed("shape_model_explained", self._handle, 1, numpy.float64)

    def shape(self, coefficients=()):
        """A Skeleton in the template's pose. `coefficients`: of the first modes, in standard deviations."""
        coefficients = array(coefficients, 1, numpy.float64, "coefficients")
        return Skeleton._take(
            native.make("shape_model_shape", self._handle, address(coefficients), len(coefficients))
        )


def left_out(template, samples):
    """How well models fit new persons: for each of three or more samples, the root mean square distance from what a
    model of the others makes of it."""
    handles = _handles(samples)
    distances = numpy.empty(len(handles))
    native.call("shape_model_left_out", template._handle, address(handles), len(handles), address(distances))
    return distances


def _handles(samples):
    """Handles as an array for a call; the caller keeps the samples alive."""
    return numpy.array([sample._handle for sample in samples], numpy.uintp)
