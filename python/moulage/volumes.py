"""Medical images, slices of them, and the lines in which planes cut surfaces. All in millimetres, RAS."""

from __future__ import annotations

import os
from ctypes import byref, c_size_t
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias, TypedDict

import numpy
from numpy.typing import ArrayLike, NDArray

from . import exchange, interface, native
from .exchange import ItkLike, NiftiLike
from .handles import Handle
from .markers import Markers
from .meshes import Surface, TriMesh
from .native import address, array

if TYPE_CHECKING:
    import nibabel
    import SimpleITK


class VolumeInfo(TypedDict):
    """Where an image lies and what it holds."""

    size: NDArray[Any]
    """Voxels along each index, shape (3,)."""
    world_from_voxel: NDArray[numpy.float64]
    """Shape (3, 4); a whole index is a voxel's centre."""
    spacing: NDArray[numpy.float64]
    """Millimetres between voxels along each index, shape (3,)."""
    range: NDArray[numpy.float64]
    """The smallest and the largest value, shape (2,)."""
    window: NDArray[numpy.float64]
    """Width and level of the window that suits the image, shape (2,)."""
    box_low: NDArray[numpy.float64]
    """The lowest corner of the box around the image, shape (3,)."""
    box_high: NDArray[numpy.float64]


class Plane:
    """A rectangle of square pixels.

    Parameters
    ----------
    corner : array_like, shape (3,)
        The centre of the first (top left) pixel.
    right, down : array_like, shape (3,)
        The steps to the next pixel and to the next row.
    width, height : int
        The numbers of pixels.
    """

    def __init__(self, corner: ArrayLike, right: ArrayLike, down: ArrayLike, width: int, height: int) -> None:
        self.corner, self.right, self.down = (numpy.asarray(v, dtype=float) for v in (corner, right, down))
        self.width, self.height = int(width), int(height)

    def _struct(self) -> interface.MlgSlicePlane:
        return native.slice_plane(self.corner, self.right, self.down, self.width, self.height)

    @property
    def centre(self) -> NDArray[numpy.float64]:
        """The middle of the rectangle, shape (3,)."""
        middle: NDArray[numpy.float64] = self.corner + self.right * (self.width - 1) / 2 + self.down * (self.height - 1) / 2
        return middle


@dataclass(frozen=True, kw_only=True)
class Clicks:
    """How a person would click markers on a label map. Millimetres.

    Parameters
    ----------
    every : float, optional
        Between slices.
    spacing : float, optional
        Between markers along an outline.
    jitter : float, optional
        The standard deviation of a hand's error.
    seed : int, optional
        Another number gives other errors.
    """

    every: float = 9.0
    spacing: float = 8.0
    jitter: float = 0.0
    seed: int = 1


class Volume(Handle):
    """A medical image. Immutable.

    Parameters
    ----------
    path : path
        NIfTI, NRRD, MetaImage, or a folder of DICOM slices.

    Raises
    ------
    Error
        Names the file and what is wrong in it.
    """

    kind = "volume"

    def __init__(self, path: str | os.PathLike[str]) -> None:
        super().__init__(native.make("volume_load", native.path(path)))

    @classmethod
    def of(cls, image: Image) -> Volume:
        """Take another package's image. `Registration.set_image` does so by itself.

        Parameters
        ----------
        image : path, Volume, nibabel image or SimpleITK.Image

        Returns
        -------
        Volume
            The same object if it is one already.
        """
        if isinstance(image, Volume):
            return image
        if isinstance(image, (str, os.PathLike)):
            return cls(image)
        return cls.from_array(**exchange.voxels_of(image))

    @classmethod
    def from_array(
        cls, values: ArrayLike, spacing: ArrayLike = (1, 1, 1), origin: ArrayLike = (0, 0, 0),
        directions: ArrayLike = ((1, 0, 0), (0, 1, 0), (0, 0, 1)), lps: bool = False,
    ) -> Volume:
        """Make an image of an array.

        Parameters
        ----------
        values : array_like, shape (i, j, k)
            Labels, or anything that float32 holds.
        spacing : array_like, shape (3,)
            Millimetres along each index.
        origin : array_like, shape (3,)
            The centre of the first voxel.
        directions : array_like, shape (3, 3)
            Its columns are those of the indices.
        lps : bool
            Whether origin and directions are in LPS, as ITK has them, or in RAS.

        Returns
        -------
        Volume
        """
        voxels = numpy.asfortranarray(values, numpy.float32)
        if voxels.ndim != 3:
            raise ValueError(f"values: shape {voxels.shape} where {('i', 'j', 'k')} is needed")
        grid = interface.MlgVolumeGrid()
        native.get("volume_grid_init", byref(grid), grid.struct_size)
        grid.size[:], grid.spacing[:], grid.origin[:] = voxels.shape, spacing, origin
        grid.directions[:] = array(directions, 3, numpy.float64, "directions").ravel()
        grid.lps = int(lps)
        return cls._take(native.make("volume_new", address(voxels), byref(grid)))

    def to_nibabel(self) -> nibabel.Nifti1Image:
        """Give it to nibabel, float32.

        Returns
        -------
        nibabel.Nifti1Image
        """
        affine = numpy.vstack([self.info["world_from_voxel"], [0, 0, 0, 1]])
        made = exchange.imported("nibabel", "to_nibabel").Nifti1Image(self.values, affine)
        return made  # type: ignore[no-any-return,unused-ignore]

    def to_sitk(self) -> SimpleITK.Image:
        """Give it to SimpleITK, float32, in LPS as ITK has it.

        Returns
        -------
        SimpleITK.Image
        """
        info = self.info
        lps = numpy.diag([-1.0, -1.0, 1.0]) @ info["world_from_voxel"]
        made = exchange.imported("SimpleITK", "to_sitk").GetImageFromArray(numpy.ascontiguousarray(self.values.T))
        made.SetSpacing(info["spacing"].tolist())
        made.SetOrigin(lps[:, 3].tolist())
        made.SetDirection((lps[:, :3] / info["spacing"]).ravel().tolist())
        return made  # type: ignore[no-any-return,unused-ignore]

    def __repr__(self) -> str:
        size, spacing = self.info["size"], self.info["spacing"]
        return f"Volume({' x '.join(map(str, size))} voxels of {' x '.join(f'{mm:.3g}' for mm in spacing)} mm)"

    @property
    def values(self) -> NDArray[numpy.float32]:
        """All voxels, shape (i, j, k)."""
        flat = native.borrowed("volume_values", self, 1, numpy.float32)
        return flat.reshape(tuple(self.info["size"]), order="F")

    @property
    def info(self) -> VolumeInfo:
        """Where it lies and what it holds."""
        found: Any = native.fill("volume_info", self, interface.MlgVolumeInfo())
        found = {name: numpy.array(value) for name, value in found.items()}
        found["world_from_voxel"] = found["world_from_voxel"].reshape(3, 4)
        return found  # type: ignore[no-any-return]

    @property
    def notes(self) -> list[str]:
        """What was noticed while reading, one sentence each."""
        return native.text("volume_notes", self).splitlines()

    def plane(self, axis: ArrayLike, position: float, pixel: float = 0.0) -> Plane:
        """Make a plane as large as the image needs.

        Parameters
        ----------
        axis : array_like, shape (3,)
            (0, 0, 1) axial, (0, 1, 0) coronal, (1, 0, 0) sagittal, or any other.
        position : float
            Millimetres along it.
        pixel : float
            Millimetres; 0: the image's smallest spacing.

        Returns
        -------
        Plane
        """
        along = array(numpy.reshape(axis, (1, -1)), 3, numpy.float64, "axis")
        found = interface.MlgSlicePlane()
        native.call("volume_plane", self, address(along), position, pixel, found)
        return Plane(found.corner[:], found.right[:], found.down[:], found.width, found.height)

    def slice(self, plane: Plane, window: ArrayLike | None = None) -> NDArray[numpy.uint8]:
        """Draw the image on a plane.

        Parameters
        ----------
        plane : Plane
        window : array_like, shape (2,), optional
            Width and level.

        Returns
        -------
        ndarray of uint8, shape (height, width, 4)
            Red, green, blue, alpha, rows from the top.
        """
        pixels = numpy.empty((plane.height, plane.width, 4), numpy.uint8)
        given = None if window is None else array(window, 1, numpy.float64, "window")
        native.call("volume_slice", self, plane._struct(), address(given), 4, address(pixels), pixels.size)
        return pixels

    @property
    def labels(self) -> list[int]:
        """The numbers of a label map, ascending, without 0; raises `Error` for an image that is none."""
        count = c_size_t()
        native.call("volume_labels", self, None, 0, byref(count))
        found = numpy.zeros(count.value, numpy.uint32)
        native.call("volume_labels", self, address(found), len(found), byref(count))
        return [int(label) for label in found]

    @property
    def label_names(self) -> dict[int, str]:
        """The names that the file has for its labels, as TotalSegmentator's and 3D Slicer's have; may be empty."""
        names = {label: native.text("volume_label_name", self, label) for label in self.labels}
        return {label: name for label, name in names.items() if name}

    def outlines(self, label: int, plane: Plane) -> list[NDArray[numpy.float64]]:
        """Find the outlines of a label on a plane.

        Parameters
        ----------
        label : int
        plane : Plane

        Returns
        -------
        list of ndarray of float64, shape (n, 3)
            Closed ones end where they begin.
        """
        return _lines(native.make("volume_outlines", self, label, plane._struct()))

    def label_markers(
        self, label: int, axes: ArrayLike = ((0, 0, 1),), clicks: Clicks | None = None
    ) -> Markers:
        """Make markers on the outlines of a label, as a person would click them.

        Parameters
        ----------
        label : int
        axes : array_like, shape (n, 3)
            One direction for each series of slices, as for `plane`.
        clicks : Clicks, optional

        Returns
        -------
        Markers

        Raises
        ------
        Error
            Where the image has no such label.
        """
        directions = array(axes, 3, numpy.float64, "axes")
        wishes = native.options(interface.MlgClicks(), "clicks_init", clicks or Clicks())
        return Markers._take(
            native.make("volume_label_markers", self, label, address(directions), len(directions), wishes)
        )

    def label_surface(self, label: int) -> TriMesh:
        """Make the surface of a label.

        Parameters
        ----------
        label : int

        Returns
        -------
        TriMesh
            Open where the image ends inside it.
        """
        return TriMesh._take(native.make("volume_label_surface", self, label))


# What every method takes that takes an image.
Image: TypeAlias = Volume | NiftiLike | ItkLike | str | os.PathLike[str]


class _Polylines(Handle):
    kind = "polylines"


def section(
    surface: Surface, plane_point: ArrayLike, plane_normal: ArrayLike, points: ArrayLike | None = None
) -> list[NDArray[numpy.float64]]:
    """Find the lines in which a plane cuts a surface.

    Parameters
    ----------
    surface : TriMesh, trimesh.Trimesh or pyvista.PolyData
    plane_point, plane_normal : array_like, shape (3,)
    points : array_like, shape (n, 3), optional
        In place of the surface's own.

    Returns
    -------
    list of ndarray of float64, shape (k, 3)
        Closed ones end where they begin.
    """
    moved = None if points is None else array(points, 3, numpy.float64, "points")
    place = array(numpy.reshape(plane_point, (1, -1)), 3, numpy.float64, "plane_point")
    normal = array(numpy.reshape(plane_normal, (1, -1)), 3, numpy.float64, "plane_normal")
    count, cut = 0 if moved is None else len(moved), TriMesh.of(surface)
    return _lines(
        native.make("tri_mesh_section", cut, address(moved), count, address(place), address(normal))
    )


def _lines(handle: Any) -> list[NDArray[numpy.float64]]:
    lines = _Polylines._take(handle)
    corners = native.floats("polylines_points", lines, 3)
    starts = native.borrowed("polylines_starts", lines, 1, numpy.uint64).astype(int)
    closed = native.borrowed("polylines_closed", lines, 1, numpy.uint8)
    found = [corners[start:end] for start, end in zip(starts, starts[1:])]
    return [numpy.vstack([line, line[:1]]) if ring else line for line, ring in zip(found, closed)]
