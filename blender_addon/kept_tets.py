# SPDX-License-Identifier: GPL-3.0-or-later
"""Tets that a run left in a mesh, in the present shape, kept on the object: they are saved, copied and undone with it.
Packed into a text, because Blender cuts bytes off at the first zero."""

import base64
import io

import numpy

from . import mesh_data

# A shape that is off by more than this share of its size is another one.
_SAME = 1e-4


def keep(ob, frame, surface, points, tets):
    """Keeps tets (m, 4), their points (n, 3) and the surface's points, both in world coordinates of `frame`."""
    inverse = numpy.linalg.inv(frame)
    file = io.BytesIO()
    numpy.savez_compressed(
        file, tets=numpy.asarray(tets, numpy.uint32), points=mesh_data.transform(inverse, points),
        surface=mesh_data.transform(inverse, surface).astype(numpy.float32),
    )
    ob.moulage.tets = base64.b64encode(file.getvalue()).decode()


def find(ob, frame, surface):
    """The points and tets of a mesh whose vertices are at `surface` now (n, 3), all in world coordinates; None where
    none were kept, or for another shape."""
    if not ob.moulage.tets:
        return None
    with numpy.load(io.BytesIO(base64.b64decode(ob.moulage.tets))) as kept:
        tets, points, before = kept["tets"], kept["points"], kept["surface"].astype(numpy.float64)
    if before.shape != surface.shape:
        return None
    size = numpy.linalg.norm(numpy.ptp(surface, axis=0))
    if numpy.linalg.norm(mesh_data.transform(frame, before) - surface, axis=1).max() > _SAME * size:
        return None
    points = mesh_data.transform(frame, points)
    if numpy.linalg.det(frame[:3, :3]) < 0:
        tets = tets[:, [0, 2, 1, 3]]
    # Folded tets cannot be pushed: others are to be made.
    return (points, tets) if (volumes(points, tets) > 0).all() else None


def volumes(points, tets):
    """The volume of each tet, below 0 if it is inverted."""
    a, b, c, d = (points[tets[:, k]] for k in range(4))
    return numpy.einsum("ij,ij->i", numpy.cross(b - a, c - a), d - a) / 6
