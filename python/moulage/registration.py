"""Registering a skeleton: the options, the problem, a run of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy

from . import interface, native
from .handles import Handle
from .meshes import Surface, TriMesh
from .native import address, array
from .registration_result import RegistrationResult
from .runs import Run, Watcher
from .shape_models import ShapeModel
from .skeletons import Skeleton
from .volumes import Image, Volume


@dataclass(frozen=True, kw_only=True)
class RegistrationOptions:
    """How to register. The defaults are right for most skeletons.

    Parameters
    ----------
    align : bool, optional
        Whether many orientations of the template are tried; else it already lies where the person is.
    as_is : bool, optional
        Whether the target is meant as it is, even if it looks like a mirror image or another unit.
    limits : {"soft", "hard", "none"}
        What the joints' limits are to the search; "soft": 10 degrees of slack where the data insist.
    radii : sequence of float, optional
        Of the clusters, from coarse to fine, infinity for one cluster; empty: as the skeleton's file says, else
        chosen from its size.
    max_iterations : int, optional
        Iterations per level; 0: 30.
    thread_count : int, optional
        Threads to use; 0: all. The result does not depend on it.
    paper : bool, optional
        Whether to run the loop as published, for comparison.
    """

    align: bool = True
    as_is: bool = False
    limits: Literal["soft", "hard", "none"] = "soft"
    radii: Sequence[float] = ()
    max_iterations: int = 0
    thread_count: int = 0
    paper: bool = False


class Registration(Handle):
    """A template skeleton and what it is to follow: one surface of all bones, surfaces of single bones, or an image.

    Parameters
    ----------
    skeleton : Skeleton
        The template.
    """

    kind = "registration"

    def __init__(self, skeleton: Skeleton) -> None:
        super().__init__(native.make("registration_new", skeleton))
        self._skeleton = skeleton
        self._target: TriMesh | None = None

    def set_target(self, surface: Surface) -> None:
        """Set one surface of all the person's bones, which may be fused.

        Parameters
        ----------
        surface : TriMesh, trimesh.Trimesh or pyvista.PolyData
            In the skeleton's unit.
        """
        target = TriMesh.of(surface)
        native.call("registration_set_target", self, target)
        self._target = target

    def set_bone_target(self, bone: int | str, surface: Surface) -> None:
        """Set the person's surface of one bone; bones without one follow their joints.

        Parameters
        ----------
        bone : int or str
            Its number from 0, or its name.
        surface : TriMesh, trimesh.Trimesh or pyvista.PolyData
            In the skeleton's unit.
        """
        number = self._skeleton.number(bone)
        native.call("registration_set_bone_target", self, number, TriMesh.of(surface))

    def set_image(self, person: Image, reference: Image) -> None:
        """Set images of one kind, in millimetres.

        Parameters
        ----------
        person : path, Volume, nibabel image or SimpleITK.Image
            Of the person; the template must lie near the bones in it.
        reference : path, Volume, nibabel image or SimpleITK.Image
            In which the template lies on the bones.
        """
        native.call("registration_set_image", self, Volume.of(person), Volume.of(reference))

    def set_shape_model(self, model: ShapeModel | None) -> None:
        """Hold the bones to shapes that a model knows.

        Parameters
        ----------
        model : ShapeModel or None
            Of this template; None: the one that the template's file names, if any.
        """
        native.call("registration_set_shape_model", self, model)

    def start(self, options: RegistrationOptions | None = None) -> Run[RegistrationResult]:
        """Start on a thread of the library.

        Parameters
        ----------
        options : RegistrationOptions, optional

        Returns
        -------
        Run
            Its result is a `RegistrationResult`; its preview has the points of all bones.
        """
        wishes = options or RegistrationOptions()
        if wishes.limits not in interface.LIMITS:
            raise ValueError(f"limits is {wishes.limits!r}; known are {', '.join(interface.LIMITS)}")
        radii = array(wishes.radii, 1, numpy.float64, "radii")
        given = native.options(
            interface.MlgRegistrationOptions(), "registration_options_init", wishes,
            limits=interface.LIMITS.index(wishes.limits), radii=address(radii), radius_count=len(radii),
        )
        run = native.make("registration_start", self, given)
        skeleton, target = self._skeleton, self._target
        return Run(run, "run_wait_registration", lambda handle: RegistrationResult._of(handle, skeleton, target))

    def run(self, options: RegistrationOptions | None = None, progress: Watcher = None) -> RegistrationResult:
        """Register and wait for the result. Ctrl-C stops it.

        Parameters
        ----------
        options : RegistrationOptions, optional
        progress : callable or bool, optional
            Called with a `Progress` some times a second; when it returns False the run stops and what there is is the
            result. True draws a bar.

        Returns
        -------
        RegistrationResult

        Raises
        ------
        Error
            Where there is no target, or it cannot be of this skeleton: another unit, a mirror image.
        """
        return self.start(options).wait(progress)
