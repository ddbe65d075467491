# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes in their present shape, and the shape key that a separation writes on them."""

import numpy

from . import identity, kept_tets, markers, mesh_data, result
from .library import Wrong


class Body:
    """A mesh that may be pushed. `points` (n, 3): where it is now, world."""

    def __init__(self, ob):
        _require_writable(ob)
        self.name, self.uid = ob.name, identity.give(ob)
        self.frame = mesh_data.matrix(ob)
        self.points, self.triangles = surface(ob)
        self.tets = kept_tets.find(ob, self.frame, self.points)
        self.markers = markers.points(ob) if self.tets is not None and ob.moulage.result.key else numpy.zeros((0, 3))
        self._key = SeparatedKey(ob)

    def write(self, ob, points):
        """Shows points (n, 3), world, as the mesh's shape key."""
        self._key.write(ob, mesh_data.transform(numpy.linalg.inv(self.frame), points))

    def put_back(self, ob):
        self._key.before.restore(ob)


class SeparatedKey:
    """The key of the separated shape. It lies over the shape that there is without it, so that its slider goes from the
    one to the other and all other keys stay as they are."""

    def __init__(self, ob):
        keys = ob.data.shape_keys
        own = keys.key_blocks.get(result.SEPARATED) if keys else None
        self.before = result.Before(ob, own.name if own else "", result.SEPARATED)
        self._pinned = keys is not None and ob.show_only_shape_key
        if keys is None:
            self._relative, self._without = None, mesh_data.rest_points(ob.data).astype(numpy.float64)
            return
        if self._pinned and own != ob.active_shape_key:
            self._relative = ob.active_shape_key.name
        elif self._pinned:
            self._relative = own.relative_key.name
        else:
            self._relative = _one_shown(keys, own).name
        value = own.value if own else 0.0
        if own:
            own.value = 0.0
        self._without = mix(ob)
        if own:
            own.value = value

    def write(self, ob, points):
        key = self.before.key(ob)
        blocks = ob.data.shape_keys.key_blocks
        relative = blocks.get(self._relative or "") or ob.data.shape_keys.reference_key
        key.relative_key, key.value, key.mute = relative, 1.0, False
        # Where one key alone makes the shape, its points are what lies below, and the new ones are taken as they are.
        below = mesh_data.key_points(relative) if not self._pinned else self._without
        mesh_data.set_key_points(key, points + (below - self._without))
        ob.active_shape_key_index = blocks.find(key.name)
        ob.data.update()


def _one_shown(keys, own):
    """The key that makes the present shape, if it is one alone; else the first."""
    shown = [k for k in keys.key_blocks if k not in (own, keys.reference_key) and not k.mute and k.value != 0.0]
    one = len(shown) == 1 and shown[0].value == 1.0 and not shown[0].vertex_group
    return shown[0] if one and shown[0].relative_key == keys.reference_key else keys.reference_key


def mix(ob):
    """The vertices (n, 3), in the object's coordinates, as the shape keys put them now."""
    if ob.data.shape_keys is None:
        return mesh_data.rest_points(ob.data).astype(numpy.float64)
    active = ob.active_shape_key_index
    key = ob.shape_key_add(name="moulage", from_mix=True)
    points = mesh_data.key_points(key).astype(numpy.float64)
    ob.shape_key_remove(key)
    ob.active_shape_key_index = active
    return points


def surface(ob):
    """Vertices as they are now (n, 3), world, and triangles (m, 3); Wrong if it is none."""
    if ob.mode != "OBJECT":
        raise Wrong(f"'{ob.name}' is being edited: go back to Object Mode.")
    if len(ob.data.polygons) == 0:
        raise Wrong(f"'{ob.name}' has no faces: only surfaces can be separated.")
    frame = mesh_data.matrix(ob)
    if abs(numpy.linalg.det(frame[:3, :3])) < 1e-30:
        raise Wrong(f"'{ob.name}' is scaled to nothing: set its scale back.")
    return mesh_data.transform(frame, mix(ob)), mesh_data.triangles(ob)


def _require_writable(ob):
    if ob.library is not None or ob.data.library is not None:
        raise Wrong(f"'{ob.name}' is linked from another file: make it local (Object > Relations > Make Local).")
    keys = ob.data.shape_keys
    if keys is not None and not keys.use_relative:
        raise Wrong(f"The shape keys of '{ob.name}' are absolute: make them relative (Object Data > Shape Keys).")
