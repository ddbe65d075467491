"""Skeletons: bones and the joints between them."""

from dataclasses import dataclass, field

import numpy

from . import interface, native
from .native import byref
from .shapes import Handle

_FREE = (numpy.inf,) * 3


@dataclass
class Joint:
    """A joint. `parent`, `child`: numbers of bones, from 0. Frames are matrices (4, 4), world from frame, in the
    skeleton's pose: on the parent bone, and on the child bone (the same in the neutral position); None: in the
    middle of the narrowest gap. Limits: largest rotations about x, y, z of the frame in either sense, radians,
    0 or more. `shift_limit`: None for half a percent of the skeleton's diagonal."""

    name: str
    parent: int
    child: int
    parent_frame: numpy.ndarray = None
    child_frame: numpy.ndarray = None
    negative_limits: tuple = field(default=_FREE)
    positive_limits: tuple = field(default=_FREE)
    shift_limit: float = None
    in_tree: bool = True

    def _struct(self):
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
    def _of(cls, found):
        frames = (numpy.array(f).reshape(4, 4) for f in (found.world_from_parent_frame, found.world_from_child_frame))
        return cls(
            found.name.decode("utf-8", "replace"), found.parent, found.child, *frames, tuple(found.negative_limits),
            tuple(found.positive_limits), found.shift_limit, bool(found.in_tree),
        )


def _frame(matrix, name):
    flat = numpy.asarray(matrix, dtype=float)
    if flat.shape != (4, 4):
        raise ValueError(f"joint {name}: a frame has the shape (4, 4), not {flat.shape}")
    return flat.ravel().tolist()


class Skeleton(Handle):
    """Bones with names and the joints between them; immutable."""

    kind = "skeleton"

    def __init__(self, bones, joints=()):
        """`bones`: pairs of a name and a TriMesh. `joints`: Joint objects."""
        bones = list(bones)
        given = (interface.MlgBone * len(bones))()
        for place, (name, surface) in zip(given, bones):
            place.struct_size = native.ctypes.sizeof(interface.MlgBone)
            place.name, place.surface = name.encode("utf-8"), surface._handle
        structs = [joint._struct() for joint in joints]
        super().__init__(
            native.make("skeleton_new", given, len(given), (interface.MlgJoint * len(structs))(*structs), len(structs))
        )

    @classmethod
    def load(cls, path):
        """Reads a .skeleton.json file or an OpenSim 4 .osim model with the surfaces it names."""
        return cls._take(native.make("skeleton_load", native.path(path)))

    def save(self, path):
        """Writes a .skeleton.json file with bones/ beside it, or a .glb scene."""
        native.call("skeleton_save", self._handle, native.path(path))

    def save_osim(self, model, path):
        """Writes this person into the OpenSim model that the template was converted from: .osim, bones in Geometry/
        beside it. Returns what was not carried over, one sentence each."""
        length = native.c_size_t()
        buffer = native.ctypes.create_string_buffer(65536)
        native.call(
            "skeleton_save_osim", self._handle, native.path(model), native.path(path), native.ctypes.addressof(buffer),
            len(buffer), byref(length),
        )
        return buffer.value.decode("utf-8", "replace").splitlines()

    def save_motion(self, motion, path, flipped=(), unit_in_metres=0.0):
        """Writes a .glb scene that moves as a .mot, .sto or .bvh file says. `flipped`: angles of the opposite sign."""
        names = native.texts(list(flipped))
        native.call(
            "skeleton_save_motion", self._handle, native.path(motion), names, len(names), unit_in_metres, native.path(path)
        )

    @property
    def bone_names(self):
        count = native.get("skeleton_bone_count", self._handle)
        return [native.label("skeleton_bone_name", self._handle, i) for i in range(count)]

    def bone_points(self, bone):
        """The points of a bone (n, 3), a number from 0."""
        return native.borrowed("skeleton_bone_points", self._handle, 3, numpy.float64, bone)

    def bone_triangles(self, bone):
        """The triangles of a bone (m, 3), of its own points."""
        return native.borrowed("skeleton_bone_triangles", self._handle, 3, numpy.uint32, bone)

    @property
    def points(self):
        """The points of all bones, one bone after the other, as previews have them."""
        return native.borrowed("skeleton_points", self._handle, 3, numpy.float64)

    @property
    def joints(self):
        found = []
        for number in range(native.get("skeleton_joint_count", self._handle)):
            struct = interface.MlgJoint()
            native.call("skeleton_joint", self._handle, number, byref(struct))
            found.append(Joint._of(struct))
        return found

    @property
    def angles(self):
        """The named angles of the joints in the skeleton's pose, radians."""
        values = native.borrowed("skeleton_angles", self._handle, 1, numpy.float64)
        return {native.label("skeleton_angle_name", self._handle, i): float(v) for i, v in enumerate(values)}

    @property
    def notes(self):
        """What was left out when it was read, one sentence each."""
        return (native.label("skeleton_notes", self._handle) or "").splitlines()
