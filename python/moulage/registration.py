"""Registering a skeleton: the problem, a run of it, the result."""

import numpy

from . import interface, native
from .native import address, array, byref
from .shapes import Handle
from .skeletons import Skeleton
from .tets import Run, follow

# By the number of MlgLimits.
LIMITS = ("hard", "soft", "none")


class Registration(Handle):
    """A template skeleton and what it is to follow: one surface of all bones, surfaces of single bones, or an image."""

    kind = "registration"

    def __init__(self, skeleton):
        super().__init__(native.make("registration_new", skeleton._handle))

    def set_target(self, surface):
        """One surface of all the person's bones, which may be fused."""
        native.call("registration_set_target", self._handle, surface._handle)

    def set_bone_target(self, bone, surface):
        """The person's surface of one bone, a number from 0; bones without one follow their joints."""
        native.call("registration_set_bone_target", self._handle, bone, surface._handle)

    def set_image(self, person, reference):
        """A Volume of the person, and one of the same kind in which the template lies on the bones. In the person's
        the template must lie near them. Millimetres."""
        native.call("registration_set_image", self._handle, person._handle, reference._handle)

    def set_shape_model(self, model):
        """A ShapeModel of this template that holds the bones to shapes it knows; None: the one that the template's file
        names, if any."""
        native.call("registration_set_shape_model", self._handle, None if model is None else model._handle)

    def start(self, radii=None, limits="hard", **options):
        """Starts on a thread of the library and returns the Run; its preview has the points of all bones. Options as
        in the header's MlgRegistrationOptions: align, as_is, max_iterations, thread_count, paper. `radii`: of the clusters,
        from coarse to fine. `limits`: what those of the joints are, "hard", "soft" (10 degrees of slack) or "none"."""
        if limits not in LIMITS:
            raise ValueError(f"limits is {limits!r}; known are {', '.join(LIMITS)}")
        options["limits"] = LIMITS.index(limits)
        given = native.options("registration", interface.MlgRegistrationOptions(), options)
        radii = array([] if radii is None else radii, 1, numpy.float64, "radii")
        given.radii, given.radius_count = address(radii), len(radii)
        run = native.make("registration_start", self._handle, given)
        return Run(run, "run_wait_registration", RegistrationResult)

    def run(self, progress=None, radii=None, limits="hard", **options):
        """Registers and returns the result. `progress(Progress)` is called some times a second; when it returns
        False the run stops and what there is is the result."""
        return follow(self.start(radii, limits, **options), progress)


class RegistrationResult(Handle):
    """A registered skeleton."""

    kind = "registration_result"

    @property
    def skeleton(self):
        """The person's: bones in the template's vertex order, joint frames inside all limits."""
        return Skeleton._take(native.make("registration_result_skeleton", self._handle))

    @property
    def summary(self):
        """A dict: verdict ("good", "doubtful", "failed"), failed_bones, suspicious_bones (not good), cancelled,
        iterations, joints_outside, mean_residual, max_residual, seconds."""
        found = native.fill("registration_result_summary", self._handle, interface.MlgRegistrationSummary())
        found["cancelled"] = found["cancelled"] == 1
        found["verdict"] = interface.VERDICT[found["verdict"]]
        return found

    def bone_fit(self, bone):
        """A dict: verdict ("good", "doubtful", "failed"), reasons (why it is not good, a list of sentences),
        mean_residual, max_residual, seen (share of its area that lies on the target), suspicious (not good)."""
        found = interface.MlgBoneFit()
        native.call("registration_result_bone_fit", self._handle, bone, byref(found))
        found = found.fields()
        found.pop("reserved")
        found.pop("reason_count")
        found["suspicious"] = found["suspicious"] == 1
        found["verdict"] = interface.VERDICT[found["verdict"]]
        found["reasons"] = native.text("registration_result_bone_reasons", self._handle, bone).splitlines()
        return found

    def joint_pose(self, joint):
        """A dict: centre, rotation (vector, radians), usage (1: on the limit), excess_rotation, shift, excess_shift,
        seam."""
        found = interface.MlgJointPose()
        native.call("registration_result_joint_pose", self._handle, joint, byref(found))
        found = found.fields()
        found["centre"], found["rotation"] = numpy.array(found["centre"]), numpy.array(found["rotation"])
        return found

    @property
    def coefficients(self):
        """Of the shape model, in standard deviations; empty without one."""
        return native.borrowed("registration_result_coefficients", self._handle, 1, numpy.float64)

    def carry(self, tissue):
        """The points of a soft tissue TriMesh, given in the template's pose, moved with the bones (n, 3)."""
        points = numpy.empty_like(tissue.points)
        native.call("registration_result_carry", self._handle, tissue._handle, address(points))
        return points

    @property
    def warnings(self):
        """What to look at, one sentence each: why the whole is not good, then the worst bones and joints."""
        return native.text("registration_result_warnings", self._handle).splitlines()
