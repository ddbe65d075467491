"""How sure a reshaped template is."""

from __future__ import annotations

from typing import Any, TypedDict

import numpy
from numpy.typing import NDArray

from . import interface, native
from .handles import Handle
from .native import address


class UncertaintySummary(TypedDict):
    """Size of a result and how sure it is, in the template's unit."""

    shapes: int
    """Plausible shapes."""
    volume: float
    """Inside the surface; NaN for one that is not closed."""
    volume_sd: float
    """Its standard deviation."""
    area: float
    area_sd: float


class Uncertainty(Handle):
    """Shapes that explain the data about as well as the result; made by ``ReshapingResult.uncertainty``."""

    kind = "uncertainty"

    def __repr__(self) -> str:
        return f"Uncertainty({len(self)} plausible shapes)"

    def __len__(self) -> int:
        return self.summary["shapes"]

    @property
    def sd_normal(self) -> NDArray[numpy.float64]:
        """The standard deviation of each vertex across the surface, shape (n,)."""
        return native.floats("uncertainty_sd_normal", self, 1)

    @property
    def sd(self) -> NDArray[numpy.float64]:
        """The same in all directions: the root of the mean squared distance, shape (n,)."""
        return native.floats("uncertainty_sd", self, 1)

    def shape(self, number: int) -> NDArray[numpy.float64]:
        """Give the points of one plausible shape.

        Parameters
        ----------
        number : int
            From 0.

        Returns
        -------
        ndarray of float64, shape (n, 3)
            In the template's order.
        """
        points: NDArray[numpy.float64] = numpy.empty((len(self.sd), 3))
        native.call("uncertainty_shape", self, number, address(points), len(points))
        return points

    @property
    def summary(self) -> UncertaintySummary:
        """Volume and area of the result with their standard deviations."""
        found: Any = native.fill("uncertainty_summary", self, interface.MlgUncertaintySummary())
        return found  # type: ignore[no-any-return]
