# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of a run on the template: a shape key, per-vertex values, residuals, carried meshes."""

import contextlib
import math

import numpy

from . import heat_map, landmarks, library, mesh_data, units

KEY = "Reshaped"
# The key that lies over it after a separation.
SEPARATED = "Separated"

_ENDINGS = {
    "settled": "Done: the shape no longer changes.",
    "tolerance_met": "Done: all markers are within the tolerance.",
    "no_step": "Gave up: look for markers or landmarks that contradict each other, or allow a larger tolerance.",
    "iteration_limit": "The iterations ran out: allow more, or a larger tolerance.",
    "cancelled": "Stopped: the best shape so far is kept.",
}


class Before:
    """The shape keys of a mesh as they were before a run, to put them back if it fails. The run writes the key `name`,
    or one that is made and called `new`."""

    def __init__(self, template, name, new=KEY):
        keys = template.data.shape_keys
        old = keys.key_blocks.get(name) if keys and name else None
        self.name, self._new = old.name if old else "", new
        self._relative, self._mute = (old.relative_key.name, old.mute) if old else ("", False)
        self.had_keys = keys is not None
        self.points = mesh_data.key_points(old) if old else None
        self.values = {key.name: key.value for key in keys.key_blocks} if keys else {}
        self.active = template.active_shape_key_index
        self.made = False

    def key(self, template):
        """The key that the run writes, made when it is first needed."""
        keys = template.data.shape_keys
        key = keys.key_blocks.get(self.name) if keys and self.name else None
        if key is None:
            if keys is None:
                template.shape_key_add(name="Basis", from_mix=False)
            key = template.shape_key_add(name=self._new, from_mix=False)
            self.name, self.made = key.name, True
        return key

    def restore(self, template):
        """Puts the keys back; also after undo has taken some of them away."""
        keys = template.data.shape_keys
        key = keys.key_blocks.get(self.name) if keys else None
        if key is not None and self.made:
            template.shape_key_remove(key)
            if not self.had_keys and template.data.shape_keys and len(template.data.shape_keys.key_blocks) == 1:
                template.shape_key_clear()
        elif key is not None and self.points is not None and len(self.points) == len(template.data.vertices):
            mesh_data.set_key_points(key, self.points)
            key.relative_key, key.mute = keys.key_blocks.get(self._relative) or key.relative_key, self._mute
        if template.data.shape_keys:
            for key in template.data.shape_keys.key_blocks:
                key.value = self.values.get(key.name, key.value)
            template.active_shape_key_index = self.active
        template.data.update()


def fits(template, inputs):
    """Whether points of the run can be written to the template: same vertices, not being edited."""
    return template.mode != "EDIT" and len(template.data.vertices) == len(inputs.points)


def write_shape(template, inputs, before, points):
    """Shows points (n, 3), in the run's world coordinates, as the template's shape key."""
    key = before.key(template)
    local = mesh_data.transform(numpy.linalg.inv(inputs.frame), points)
    mesh_data.set_key_points(key, local)
    for other in template.data.shape_keys.key_blocks:
        if other.name.startswith((KEY, SEPARATED)):
            other.value = 1.0 if other.name == key.name else 0.0
    # A pinned key hides all others.
    template.active_shape_key_index = template.data.shape_keys.key_blocks.find(key.name)
    template.data.update()


def write(context, template, inputs, before, found, warnings, seconds, edited=False):
    """Writes all of a result; returns what to tell the user. `edited`: in live editing, where how sure it is would
    take longer than the run."""
    data, summary = template.moulage, found.summary
    write_shape(template, inputs, before, found.points)
    mesh_data.set_attribute(template.data, heat_map.SOURCES["STRETCH"], "FLOAT", found.max_stretches)
    distances = found.marker_distances
    near = heat_map.spread(found.points, inputs.triangles, inputs.markers, distances)
    mesh_data.set_attribute(template.data, heat_map.SOURCES["DISTANCE"], "FLOAT", near)
    heat_map.keep_marker_distances(template, distances)
    _residuals(template, inputs, found)
    _how_sure(template, None if edited else found)
    for item in data.carried:
        if item.object is not None and item.object != template:
            carry(item.object, found)
    kept = data.result
    kept.key = before.name
    kept.ending = _ENDINGS[summary["stop"]]
    kept.mean_distance = _known(summary["mean_marker_distance"])
    kept.max_distance = _known(summary["max_marker_distance"])
    kept.iterations, kept.inverted_tets = summary["iterations"], summary["inverted_tets"]
    kept.seconds = seconds
    kept.warnings = "\n".join(library.sentence(line) for line in warnings)
    heat_map.paint(template)
    template.data.update()
    return sentence(context.scene, kept)


def sentence(scene, kept):
    """The result in one line."""
    text = kept.ending
    if kept.mean_distance >= 0:
        mean, largest = units.texts(scene, kept.mean_distance, kept.max_distance)
        text += f" Markers: mean {mean}, largest {largest}."
    if kept.inverted_tets:
        text += f" {kept.inverted_tets} tets are inverted: the shape is folded there."
    return text


def _how_sure(template, found):
    """Standard deviations of vertices and volume; nothing is known of them without a result."""
    kept = template.moulage.result
    kept.volume = -1.0, -1.0
    deviations = numpy.full(len(template.data.vertices), -1.0)
    if found is not None:
        # The result is there, whatever becomes of this.
        with contextlib.suppress(library.Wrong), library.calls():
            sure = found.uncertainty()
            size, deviations = sure.summary, sure.sd_normal
            if not math.isnan(size["volume"]):
                kept.volume = size["volume"], size["volume_sd"]
    mesh_data.set_attribute(template.data, heat_map.SOURCES["SURE"], "FLOAT", deviations)


def _known(value):
    return -1.0 if math.isnan(value) else value


def _residuals(template, inputs, found):
    points, targets, _weights = inputs.landmarks
    for landmark in template.moulage.landmarks:
        landmark.residual = -1.0
    if len(points) == 0:
        return
    moved = found.carry(points)
    by_name = dict(zip(inputs.landmark_names, zip(moved, numpy.linalg.norm(moved - targets, axis=1))))
    for landmark in landmarks.used(template):
        if landmark.name in by_name:
            landmark.moved, landmark.residual = by_name[landmark.name]


def carry(ob, found):
    """Moves another mesh with the template: a shape key of its own."""
    if ob.mode == "EDIT" or len(ob.data.vertices) == 0:
        return
    moved = found.carry(mesh_data.world_points(ob))
    if ob.data.shape_keys is None:
        ob.shape_key_add(name="Basis", from_mix=False)
    key = ob.data.shape_keys.key_blocks.get(KEY) or ob.shape_key_add(name=KEY, from_mix=False)
    mesh_data.set_key_points(key, mesh_data.transform(numpy.linalg.inv(mesh_data.matrix(ob)), moved))
    key.value = 1.0
    ob.active_shape_key_index = ob.data.shape_keys.key_blocks.find(key.name)
    ob.data.update()
