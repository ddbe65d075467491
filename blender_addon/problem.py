# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run needs, taken out of Blender: plain arrays and numbers in world coordinates."""

from dataclasses import dataclass, field

import numpy

from . import attachments, identity, landmarks, markers, mesh_data, preferences
from .library import Wrong, moulage


@dataclass
class Inputs:
    """All of one run. Points (n, 3) and lengths are in world coordinates."""

    name: str
    uid: str
    points: numpy.ndarray
    triangles: numpy.ndarray
    frame: numpy.ndarray
    method: str
    tet_count: int
    tetgen: str
    markers: numpy.ndarray = None
    landmarks: tuple = ()
    landmark_names: list = field(default_factory=list)
    within: numpy.ndarray = None
    attachments: tuple = ()
    fixed: numpy.ndarray = None
    options: dict = field(default_factory=dict)

    def key(self):
        """What the tets depend on."""
        shape = hash((self.points.tobytes(), self.triangles.tobytes()))
        return shape, self.method, self.tet_count, self.tetgen

    def asks_the_same(self, other):
        """Whether another run would find the same shape."""
        arrays = [
            (self.markers, other.markers), (self.within, other.within), *zip(self.landmarks, other.landmarks),
            *zip(self.attachments, other.attachments), (self.fixed, other.fixed),
        ]
        same = all(numpy.array_equal(a, b) for a, b in arrays)
        return same and self.key() == other.key() and self.options == other.options


def gather_shape(context, template):
    """The inputs for making tets; Wrong says what is missing."""
    _require_usable(template)
    context.view_layer.update()
    data = template.moulage
    own = preferences.get(context)
    frame = mesh_data.matrix(template)
    if abs(numpy.linalg.det(frame[:3, :3])) < 1e-30:
        raise Wrong(f"'{template.name}' is scaled to nothing: set its scale back.")
    faces = mesh_data.triangles(template)
    if len(faces) == 0:
        raise Wrong(f"'{template.name}' has no faces: pick a surface as template.")
    return Inputs(
        name=template.name, uid=identity.give(template), points=mesh_data.world_points(template), triangles=faces, frame=frame,
        method=data.method, tet_count=data.tet_count, tetgen=own.tetgen if own else "",
    )


def gather(context, template):
    """The inputs of a run; Wrong says what is missing or contradicts."""
    inputs = gather_shape(context, template)
    data = template.moulage
    inputs.markers = markers.points(template)
    inputs.landmarks = landmarks.pairs(template)
    inputs.landmark_names = [l.name for l in landmarks.used(template)]
    inputs.within = landmarks.within(template)
    inputs.attachments = attachments.pairs(template, inputs.points, inputs.triangles)
    inputs.fixed = _fixed(template)
    inputs.options = _options(context, data)
    return inputs


def _require_usable(template):
    if template is None:
        raise Wrong("Pick the mesh to reshape as template first.")
    if template.mode != "OBJECT":
        raise Wrong("Leave Edit Mode or the other mode of the template: go back to Object Mode.")


def _fixed(template):
    name = template.moulage.fixed_group
    if not name:
        return numpy.zeros(0, numpy.uint32)
    weights = mesh_data.group_weights(template, name)
    if weights is None:
        raise Wrong(f"The template has no vertex group '{name}' for its fixed vertices.")
    return numpy.flatnonzero(weights > 0.5).astype(numpy.uint32)


def _options(context, data):
    own = preferences.get(context)
    options = {
        "tolerance": data.tolerance, "landmark_tolerance": data.landmark_tolerance,
        "attachment_tolerance": data.attachment_tolerance,
        "hard_attachments": data.hard_attachments, "reverse_term": data.reverse_term,
        "smoothness": moulage().ReshapingOptions().smoothness * data.smoothness,
        "thread_count": own.threads if own else 0,
    }
    if data.max_iterations > 0:
        options["max_iterations"] = data.max_iterations
    return moulage().ReshapingOptions(**options)

