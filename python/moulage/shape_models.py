"""Shape statistics of a skeleton's bones."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

import numpy
from numpy.typing import ArrayLike, NDArray

from . import native
from .handles import Handle
from .native import address, array
from .skeletons import Skeleton


class ShapeModel(Handle):
    """Mean shape and modes of all bones of a template together, pose removed. Immutable.

    Parameters
    ----------
    template : Skeleton
    samples : iterable of Skeleton
        Two or more, with the template's bones and vertices, in any pose.

    Raises
    ------
    Error
        Where a sample is not of this template.
    """

    kind = "shape_model"

    def __init__(self, template: Skeleton, samples: Iterable[Skeleton]) -> None:
        kept = list(samples)
        handles = _handles(kept)
        super().__init__(native.make("shape_model_fit", template, address(handles), len(handles)))

    @classmethod
    def load(cls, template: Skeleton, path: str | os.PathLike[str]) -> ShapeModel:
        """Read a file.

        Parameters
        ----------
        template : Skeleton
        path : path
            .h5.json, as `save` and scalismo write it.

        Returns
        -------
        ShapeModel
        """
        return cls._take(native.make("shape_model_load", template, native.path(path)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a file, in single precision.

        Parameters
        ----------
        path : path
            .h5.json.
        """
        native.call("shape_model_save", self, native.path(path))

    @property
    def deviations(self) -> NDArray[numpy.float64]:
        """How far the surface moves at one standard deviation of each mode, root mean square, falling; shape (modes,)."""
        return native.floats("shape_model_deviations", self, 1)

    @property
    def explained(self) -> NDArray[numpy.float64]:
        """The share of the variance in the first modes, rising to 1, shape (modes,)."""
        return native.floats("shape_model_explained", self, 1)

    def shape(self, coefficients: ArrayLike = ()) -> Skeleton:
        """Make a skeleton in the template's pose.

        Parameters
        ----------
        coefficients : array_like, shape (k,)
            Of the first modes, in standard deviations.

        Returns
        -------
        Skeleton
        """
        coefficients = array(coefficients, 1, numpy.float64, "coefficients")
        return Skeleton._take(native.make("shape_model_shape", self, address(coefficients), len(coefficients)))


def left_out(template: Skeleton, samples: Iterable[Skeleton]) -> NDArray[numpy.float64]:
    """Measure how well shape models fit new persons.

    Parameters
    ----------
    template : Skeleton
    samples : iterable of Skeleton
        Three or more.

    Returns
    -------
    ndarray of float64, shape (samples,)
        For each, the root mean square distance from what a model of the others makes of it.
    """
    kept = list(samples)
    handles = _handles(kept)
    distances = numpy.empty(len(handles))
    native.call("shape_model_left_out", template, address(handles), len(handles), address(distances))
    return distances


def _handles(samples: list[Skeleton]) -> NDArray[Any]:
    """Handles as an array for a call; the caller keeps the samples alive."""
    return numpy.array([sample._handle for sample in samples], numpy.uintp)
