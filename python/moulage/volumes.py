"""Medical images, slices of them, and the lines in which planes cut surfaces. All in millimetres, RAS."""

import numpy

from . import interface, native
from .native import address, array
from .shapes import Handle, Markers, TriMesh


class Plane:
    """A rectangle of square pixels: `corner` is the centre of the first (top left) pixel, `right` and
    `down` the steps to the next pixel and row, `width` and `height` the numbers of pixels."""

    def __init__(self, corner, right, down, width, height):
        self.corner, self.right, self.down = (numpy.asarray(v, dtype=float) for v in (corner, right, down))
        self.width, self.height = int(width), int(height)

    def _struct(self):
        return native.slice_plane(self.corner, self.right, self.down, self.width, self.height)

    @property
    def centre(self):
        """The middle of the rectangle."""
        return self.corner + self.right * (self.width - 1) / 2 + self.down * (self.height - 1) / 2


class Volume(Handle):
    """An image: NIfTI, NRRD, MetaImage, or a folder of DICOM slices."""

    kind = "volume"

    def __init__(self, path):
        super().__init__(native.make("volume_load", native.path(path)))

    @classmethod
    def from_array(cls, values, spacing=(1, 1, 1), origin=(0, 0, 0), directions=((1, 0, 0), (0, 1, 0), (0, 0, 1)), lps=False):
        """Of an array (i, j, k): labels, or anything that float32 holds. `spacing`: millimetres along each index. `origin`:
        the centre of the first voxel. `directions` (3, 3): its columns are those of the indices. `lps`: whether these are
        in LPS, as ITK has them, or in RAS.

            Volume.from_array(itk.array_from_image(i).T, i.GetSpacing(), i.GetOrigin(), i.GetDirection(), lps=True)
            Volume.from_array(nifti.get_fdata(), origin=nifti.affine[:3, 3], directions=nifti.affine[:3, :3])
        """
        values = numpy.asfortranarray(values, numpy.float32)
        if values.ndim != 3:
            raise ValueError(f"values: shape {values.shape} where {('i', 'j', 'k')} is needed")
        grid = interface.MlgVolumeGrid()
        native.get("volume_grid_init", native.byref(grid), grid.struct_size)
        grid.size[:], grid.spacing[:], grid.origin[:] = values.shape, spacing, origin
        grid.directions[:] = array(directions, 3, numpy.float64, "directions").ravel()
        grid.lps = int(lps)
        return cls._take(native.make("volume_new", address(values), native.byref(grid)))

    @property
    def values(self):
        """All voxels (i, j, k), float32."""
        flat = native.borrowed("volume_values", self._handle, 1, numpy.float32)
        return flat.reshape(self.info["size"], order="F")

    @property
    def info(self):
        """A dict: size, world_from_voxel (3, 4), spacing, range, window (width, level), box_low, box_high."""
        found = native.fill("volume_info", self._handle, interface.MlgVolumeInfo())
        found = {name: numpy.array(value) for name, value in found.items()}
        found["world_from_voxel"] = found["world_from_voxel"].reshape(3, 4)
        return found

    @property
    def notes(self):
        """What was noticed while reading, one sentence each."""
        return native.text("volume_notes", self._handle).splitlines()

    def plane(self, axis, position, pixel=0.0):
        """A plane as large as the image needs. `axis`: (0, 0, 1) axial, (0, 1, 0) coronal, (1, 0, 0) sagittal,
        or any other; `position`: millimetres along it; `pixel`: 0 for the image's smallest spacing."""
        axis = array([axis], 3, numpy.float64, "axis")
        found = interface.MlgSlicePlane()
        native.call("volume_plane", self._handle, address(axis), position, pixel, found)
        return Plane(found.corner[:], found.right[:], found.down[:], found.width, found.height)

    def slice(self, plane, window=None):
        """Red, green, blue, alpha (height, width, 4), uint8, rows from the top. `window`: width and level."""
        pixels = numpy.empty((plane.height, plane.width, 4), numpy.uint8)
        window = None if window is None else array(window, 1, numpy.float64, "window")
        native.call(
            "volume_slice", self._handle, plane._struct(), address(window), 4, address(pixels), pixels.size
        )
        return pixels

    @property
    def labels(self):
        """The numbers of a label map, ascending, without 0; raises Error for an image that is none."""
        count = native.c_size_t()
        native.call("volume_labels", self._handle, None, 0, native.byref(count))
        found = numpy.zeros(count.value, numpy.uint32)
        native.call("volume_labels", self._handle, address(found), len(found), native.byref(count))
        return found.tolist()

    def outlines(self, label, plane):
        """The outlines of a label on a Plane, as `section` gives lines."""
        return _lines(native.make("volume_outlines", self._handle, label, plane._struct()))

    def label_markers(self, label, axes=((0, 0, 1),), **clicks):
        """Markers on the outlines of a label, as a person would click them: Markers. `axes`: one direction per
        series of slices, as for `plane`. Keywords: every (mm between slices), spacing (mm along an outline),
        jitter (mm), seed."""
        axes = array(axes, 3, numpy.float64, "axes")
        wishes = native.options("clicks", interface.MlgClicks(), clicks, "clicks_init")
        return Markers._take(
            native.make("volume_label_markers", self._handle, label, address(axes), len(axes), wishes)
        )

    def label_surface(self, label):
        """The surface of a label: TriMesh; open where the image ends inside it."""
        return TriMesh._take(native.make("volume_label_surface", self._handle, label))


class _Polylines(Handle):
    kind = "polylines"


def section(surface, plane_point, plane_normal, points=None):
    """The lines in which a plane cuts a TriMesh: a list of (n, 3) arrays; closed ones end where they begin.
    `points`: in place of the surface's own."""
    points = None if points is None else array(points, 3, numpy.float64, "points")
    place = array([plane_point], 3, numpy.float64, "plane_point")
    normal = array([plane_normal], 3, numpy.float64, "plane_normal")
    count = 0 if points is None else len(points)
    return _lines(
        native.make(
            "tri_mesh_section", surface._handle, address(points), count, address(place), address(normal)
        )
    )


def _lines(handle):
    lines = _Polylines._take(handle)
    corners = native.borrowed("polylines_points", lines._handle, 3, numpy.float64)
    starts = native.borrowed("polylines_starts", lines._handle, 1, numpy.uint64).astype(int)
    closed = native.borrowed("polylines_closed", lines._handle, 1, numpy.uint8)
    found = [corners[start:end] for start, end in zip(starts, starts[1:])]
    return [numpy.vstack([line, line[:1]]) if ring else line for line, ring in zip(found, closed)]
