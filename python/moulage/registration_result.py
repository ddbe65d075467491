"""What comes out of a registration."""

from __future__ import annotations

import os
from collections.abc import Iterator
from ctypes import byref
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypedDict

import numpy
from numpy.typing import NDArray

from . import exchange, interface, native
from .handles import Handle
from .meshes import Surface, TriMesh
from .native import address
from .skeletons import Skeleton

if TYPE_CHECKING:
    import pyvista

Verdict: TypeAlias = Literal["good", "doubtful", "failed"]
# How pyvista draws verdicts: good, doubtful, failed.
_COLOURS = {"scalars": "verdict", "cmap": ["#7fb77e", "#f0b94d", "#d9534f"], "clim": (0, 2), "show_scalar_bar": False}


class RegistrationSummary(TypedDict):
    """What happened in a registration. Lengths are in the skeleton's unit."""

    verdict: Verdict
    """How far the whole can be trusted."""
    failed_bones: int
    suspicious_bones: int
    """Bones whose verdict is not good."""
    joints_outside: int
    """Joints outside their limits."""
    mean_residual: float
    """The mean of the bones' mean residuals."""
    max_residual: float
    iterations: int
    cancelled: bool
    seconds: float


class BoneFit(TypedDict):
    """How far a bone can be trusted, and why. Lengths are in the skeleton's unit."""

    verdict: Verdict
    reasons: list[str]
    """Why it is not good, and what to do, one sentence each."""
    mean_residual: float
    """The mean distance from the bone to the target and from the target to the bone."""
    max_residual: float
    seen: float
    """The share of the bone's area that lies on the target, 0 to 1."""
    suspicious: bool
    """Whether its verdict is not good."""


class JointPose(TypedDict):
    """How a joint stands. Lengths are in the skeleton's unit, angles in radians."""

    centre: NDArray[numpy.float64]
    """Shape (3,)."""
    rotation: NDArray[numpy.float64]
    """The rotation vector of the child's frame seen from the parent's, shape (3,)."""
    usage: float
    """The share of the allowed rotation that is used; 1: on the limit."""
    excess_rotation: float
    """Rotation beyond the limit."""
    shift: float
    """Distance of the two frames' origins."""
    excess_shift: float
    seam: float
    """Distance at which the data alone would leave the two bones' points of the joint."""


class RegistrationResult(Handle):
    """A registered skeleton."""

    kind = "registration_result"
    _template: Skeleton
    _target: TriMesh | None

    @classmethod
    def _of(cls, handle: Any, template: Skeleton, target: TriMesh | None) -> RegistrationResult:
        made = cls._take(handle)
        made._template, made._target = template, target
        return made

    def __repr__(self) -> str:
        found = self.summary
        return f"RegistrationResult({found['verdict']}; {found['suspicious_bones']} bones are not good)"

    @property
    def skeleton(self) -> Skeleton:
        """The person's: bones in the template's vertex order, joint frames inside their limits, or as far beyond as these give way."""
        return Skeleton._take(native.make("registration_result_skeleton", self))

    @property
    def summary(self) -> RegistrationSummary:
        """How far the whole can be trusted, and its figures."""
        found: Any = native.fill("registration_result_summary", self, interface.MlgRegistrationSummary())
        found["cancelled"] = found["cancelled"] == 1
        found["verdict"] = interface.VERDICT[found["verdict"]]
        return found  # type: ignore[no-any-return]

    def bone_fit(self, bone: int | str) -> BoneFit:
        """Tell how far a bone can be trusted, and why.

        Parameters
        ----------
        bone : int or str
            Its number from 0, or its name.

        Returns
        -------
        BoneFit
        """
        number = self._template.number(bone)
        struct = interface.MlgBoneFit()
        native.call("registration_result_bone_fit", self, number, byref(struct))
        found: Any = struct.fields()
        found.pop("reserved")
        found.pop("reason_count")
        found["suspicious"] = found["suspicious"] == 1
        found["verdict"] = interface.VERDICT[found["verdict"]]
        found["reasons"] = native.text("registration_result_bone_reasons", self, number).splitlines()
        return found  # type: ignore[no-any-return]

    def joint_pose(self, joint: int) -> JointPose:
        """Tell how a joint stands.

        Parameters
        ----------
        joint : int
            Its number from 0.

        Returns
        -------
        JointPose
        """
        struct = interface.MlgJointPose()
        native.call("registration_result_joint_pose", self, joint, byref(struct))
        found: Any = struct.fields()
        found["centre"], found["rotation"] = numpy.array(found["centre"]), numpy.array(found["rotation"])
        return found  # type: ignore[no-any-return]

    @property
    def coefficients(self) -> NDArray[numpy.float64]:
        """Of the shape model, in standard deviations, shape (modes,); empty without one."""
        return native.floats("registration_result_coefficients", self, 1)

    @property
    def seen(self) -> NDArray[numpy.float64]:
        """Whether each vertex of the skeleton lies on the target, shape (points,).

        1 or 0; in an image, how far it finds something like it, 0 to 1. What is not seen is a guess.
        """
        return native.floats("registration_result_seen", self, 1)

    def carry(self, tissue: Surface) -> NDArray[numpy.float64]:
        """Move a soft tissue with the bones.

        Parameters
        ----------
        tissue : TriMesh, trimesh.Trimesh or pyvista.PolyData
            In the template's pose.

        Returns
        -------
        ndarray of float64, shape (n, 3)
            Its points on the person.
        """
        given = TriMesh.of(tissue)
        points = numpy.empty_like(given.points)
        native.call("registration_result_carry", self, given, address(points))
        return points

    @property
    def warnings(self) -> list[str]:
        """What to look at, one sentence each: why the whole is not good, then the worst bones and joints."""
        return native.text("registration_result_warnings", self).splitlines()

    def to_pyvista(self) -> pyvista.MultiBlock:
        """Give all bones to pyvista, with what is known of each.

        Returns
        -------
        pyvista.MultiBlock
            A block for each bone, by its name, with arrays of its points: ``residual`` (the bone's mean distance to the
            target), ``verdict`` (0 good, 1 doubtful, 2 failed), ``seen`` (see there), and ``distance`` of each point to
            the target where that is one surface.
        """
        made: Any = self.skeleton.to_pyvista()
        seen = iter(self.seen)
        for number in range(made.n_blocks):
            fit, block = self.bone_fit(number), made[number]
            count = block.n_points
            block.point_data["residual"] = numpy.full(count, fit["mean_residual"])
            block.point_data["seen"] = numpy.fromiter(seen, float, count)
            block.point_data["verdict"] = numpy.full(count, interface.VERDICT.index(fit["verdict"]))
            if self._target is not None:
                block.point_data["distance"] = self._target.distances_of(block.points)
        return made  # type: ignore[no-any-return,unused-ignore]

    def plot(self, heat: str | None = None, screenshot: str | os.PathLike[str] | None = None, **show: Any) -> Any:
        """Draw the bones, and the target through which they are seen, with pyvista.

        Parameters
        ----------
        heat : {"distance", "residual", "seen"} or None
            What the colours show; None: the verdict of each bone, green, yellow or red.
        screenshot : path, optional
            A picture to write, in place of a window.
        **show
            For ``pyvista.Plotter.show``.

        Returns
        -------
        object
            What ``pyvista.Plotter.show`` returns.
        """
        return exchange.drawn(self._layers(heat), screenshot, show)

    def _layers(self, heat: str | None) -> Iterator[exchange.Layer]:
        colours = _COLOURS if heat is None else exchange.heat_map(heat, heat)
        yield self.to_pyvista(), {"smooth_shading": True, **colours}
        if self._target is not None:
            yield self._target.to_pyvista(), {"color": "lightgray", "opacity": 0.25}
