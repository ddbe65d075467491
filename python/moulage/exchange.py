"""What other packages have for surfaces and images, by their shape: none of them is needed to import moulage."""

from __future__ import annotations

import importlib
import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    import pyvista


class TrimeshLike(Protocol):
    """A ``trimesh.Trimesh``, or what looks like one."""

    @property
    def vertices(self) -> Any: ...

    @property
    def faces(self) -> Any: ...


class PolyDataLike(Protocol):
    """A ``pyvista.PolyData``, or what looks like one."""

    @property
    def points(self) -> Any: ...

    @property
    def faces(self) -> Any: ...


class NiftiLike(Protocol):
    """What ``nibabel.load`` returns, and its images are."""

    @property
    def header(self) -> Any: ...

    def to_filename(self, filename: Any) -> None: ...


class ItkLike(Protocol):
    """A ``SimpleITK.Image``."""

    def GetSpacing(self) -> Any: ...

    def GetOrigin(self) -> Any: ...

    def GetDirection(self) -> Any: ...


def imported(package: str, what_for: str) -> Any:
    """A package that moulage does not need, or a sentence on how to get it."""
    try:
        return importlib.import_module(package)
    except ImportError as error:
        raise ImportError(f"{what_for} needs {package}, which is not installed here: pip install {package}") from error


def triangles_of(given: Any) -> tuple[Any, Any]:
    """Points and triangles of another package's surface; quads and polygons of pyvista are split."""
    if hasattr(given, "vertices") and hasattr(given, "faces"):
        return given.vertices, given.faces
    if hasattr(given, "points") and hasattr(given, "faces"):
        surface = given if given.is_all_triangles else given.triangulate()
        return surface.points, surface.faces.reshape(-1, 4)[:, 1:]
    raise TypeError(
        f"a {type(given).__name__} is no surface; give a moulage.TriMesh, a trimesh.Trimesh, a pyvista.PolyData or points "
        "and triangles"
    )


def polydata(points: ArrayLike, triangles: NDArray[Any], **arrays: ArrayLike) -> pyvista.PolyData:
    """A ``pyvista.PolyData`` with arrays of its points."""
    made = imported("pyvista", "A pyvista surface").PolyData.from_regular_faces(numpy.asarray(points), triangles.astype(int))
    for name, values in arrays.items():
        made.point_data[name] = values
    return made  # type: ignore[no-any-return,unused-ignore]


def heat_map(name: str | None, title: str | None) -> dict[str, Any]:
    """How pyvista is to draw an array of a surface's points: from blue (low) to red (high), with a bar."""
    bar = {"title": f"{title}\n", "n_labels": 4, "width": 0.6, "position_x": 0.2, "height": 0.12}
    return {"scalars": name, "cmap": "turbo", "scalar_bar_args": bar}


# A mesh, and what ``Plotter.add_mesh`` is told of its look.
Layer: TypeAlias = tuple[Any, dict[str, Any]]


def drawn(layers: Iterable[Layer], screenshot: str | os.PathLike[str] | None, show: dict[str, Any]) -> Any:
    """Draws meshes into a picture or a window."""
    scene = imported("pyvista", "plot").Plotter(off_screen=True if screenshot else None)
    for mesh, look in layers:
        scene.add_mesh(mesh, **look)
    return scene.show(screenshot=screenshot and os.fspath(screenshot), **show)


def voxels_of(image: Any) -> dict[str, Any]:
    """The arguments of `Volume.from_array` for another package's image."""
    if hasattr(image, "affine") and hasattr(image, "dataobj"):
        affine = numpy.asarray(image.affine)
        return {"values": numpy.asarray(image.dataobj), "origin": affine[:3, 3], "directions": affine[:3, :3]}
    if all(hasattr(image, name) for name in ("GetSpacing", "GetOrigin", "GetDirection")):
        values = imported("SimpleITK", "A SimpleITK image").GetArrayViewFromImage(image).T
        directions = numpy.reshape(image.GetDirection(), (3, 3)) if values.ndim == 3 else numpy.eye(3)
        return {
            "values": values, "spacing": image.GetSpacing(), "origin": image.GetOrigin(), "directions": directions, "lps": True,
        }
    raise TypeError(
        f"a {type(image).__name__} is no image; give a path, a moulage.Volume, an image of nibabel or a SimpleITK.Image"
    )
