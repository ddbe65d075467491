"""What is suspicious before a reshaping is run, and what mends it."""

from __future__ import annotations

from ctypes import byref
from dataclasses import dataclass
from typing import Any

import numpy
from numpy.typing import ArrayLike, NDArray

from . import interface, native
from .handles import Handle
from .markers import Markers, Pairs
from .meshes import Surface, TriMesh
from .native import address, array


@dataclass(frozen=True, eq=False)
class Finding:
    """Something suspicious about a template and what it is to follow. Lengths are in the template's unit.

    Parameters
    ----------
    concern : str
        What it is about: "amount", "surface", "unit", "frame", "up_axis", "place", "side", "exchange", "landmarks" or
        "attachments".
    severity : str
        What becomes of a run all the same: "note" (good, perhaps less than could be), "doubtful" (probably nonsense)
        or "refused" (nonsense: the command line refuses to begin).
    text : str
        What is wrong and what can be done, one sentence.
    distance : float
        How far the person's points are from the template on average; nan where that is not the matter.
    mended_distance : float
        How far they are once it is mended; nan where that is not known.
    motion : ndarray of float64, shape (4, 4), or None
        Where to move the template; a mirror image where its determinant is below 0.
    exchange : tuple of int, or None
        Two landmarks, by their numbers, whose targets are to be swapped.
    """

    concern: str
    severity: str
    text: str
    distance: float
    mended_distance: float
    motion: NDArray[numpy.float64] | None
    exchange: tuple[int, int] | None


class _Findings(Handle):
    kind = "findings"


def inspect(
    template: Surface, markers: Markers | ArrayLike = (), landmarks: Pairs | None = None,
    attachments: Pairs | None = None, fixed: ArrayLike = (),
) -> list[Finding]:
    """Look at a template and what it is to follow before any tets are made: units, frames, landmarks, holes.

    Parameters
    ----------
    template : TriMesh, trimesh.Trimesh or pyvista.PolyData
        At rest.
    markers : Markers, or array_like, shape (n, 3)
        Points of the person's surface.
    landmarks, attachments : Pairs, optional
        Places on the template and where they are on the person.
    fixed : array_like of int, shape (k,)
        Vertices that stay where they are.

    Returns
    -------
    list of Finding
        Nothing where all is well.
    """
    points = array(markers.points if isinstance(markers, Markers) else markers, 3, numpy.float64, "markers")
    held = array(fixed, 1, numpy.uint32, "fixed")
    found = _Findings(
        native.make(
            "tri_mesh_inspect", TriMesh.of(template), address(points), len(points), landmarks, attachments,
            address(held), len(held),
        )
    )
    return [_finding(found, number) for number in range(native.get("findings_count", found))]


def _finding(findings: _Findings, number: int) -> Finding:
    struct: Any = interface.MlgFinding()
    native.call("findings_get", findings, number, byref(struct))
    return Finding(
        concern=interface.CONCERN[struct.concern], severity=interface.SEVERITY[struct.severity],
        text=native.label("findings_text", findings, number) or "",
        distance=struct.distance, mended_distance=struct.mended_distance,
        motion=numpy.array(struct.motion).reshape(4, 4) if struct.has_motion else None,
        exchange=(struct.first, struct.second) if struct.has_exchange else None,
    )
