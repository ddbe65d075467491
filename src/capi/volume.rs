//! Medical images: slices, and lines on slices.

use libc::c_char;
use std::ptr;

use super::boundary::{Failure, MlgError, MlgStatus, Outcome};
use super::buffers::{self, Versioned};
use super::mesh::{MlgTriMesh, Surface};
use super::{access, handles};
use crate::io::{VolumeFile, read_volume};
use crate::math::Vec3;
use crate::math::polyline::Polyline;
use crate::mesh::{TriMesh, plane_section};
use crate::volume::{SlicePlane, View, Window};

/// A medical image, or a label map. Immutable; may be read from many threads. World coordinates are
/// millimetres in RAS: x to the person's right, y to the front, z to the head.
pub struct MlgVolume;

/// Lines, each open or closed. Immutable; may be read from many threads.
pub struct MlgPolylines;

/// What an image is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgVolumeInfo {
    /// `sizeof` this struct in the caller's header.
    pub struct_size: usize,
    /// Voxels along each index.
    pub size: [usize; 3],
    /// World from voxel: the first three rows of a 4x4 matrix, row by row. An integer index is a
    /// voxel's centre.
    pub world_from_voxel: [f64; 12],
    /// Millimetres between voxels along each index.
    pub spacing: [f64; 3],
    /// Smallest and largest value.
    pub range: [f64; 2],
    /// Width and level of the window that suits the image.
    pub window: [f64; 2],
    /// Lowest and highest corner of the box around the image, world.
    pub box_low: [f64; 3],
    /// Highest corner.
    pub box_high: [f64; 3],
}

/// A rectangle of pixels in the world. Made by `mlg_volume_plane`, or by the caller.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgSlicePlane {
    /// `sizeof` this struct in the caller's header.
    pub struct_size: usize,
    /// World position of the first (top left) pixel's centre.
    pub corner: [f64; 3],
    /// Step to the next pixel in a row, mm.
    pub right: [f64; 3],
    /// Step to the next row, mm.
    pub down: [f64; 3],
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgVolumeInfo {}
// SAFETY: as above.
unsafe impl Versioned for MlgSlicePlane {}

/// Polylines in flat arrays.
pub(super) struct Lines {
    points: Vec<Vec3>,
    starts: Vec<usize>,
    closed: Vec<u8>,
}

impl Lines {
    pub fn new(lines: &[Polyline]) -> Self {
        let mut starts = vec![0];
        for line in lines {
            starts.push(starts[starts.len() - 1] + line.points.len());
        }
        Self {
            points: lines.iter().flat_map(|l| l.points.iter().copied()).collect(),
            starts,
            closed: lines.iter().map(|l| u8::from(l.closed)).collect(),
        }
    }
}

/// Reads an image: NIfTI (`.nii`, `.nii.gz`), NRRD (`.nrrd`, `.nhdr`), MetaImage (`.mha`, `.mhd`), a
/// folder of DICOM slices, or the series of one DICOM file. `path`: UTF-8. Free with
/// `mlg_volume_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_volume_load(
    path: *const c_char,
    out_volume: *mut *mut MlgVolume,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_volume, "out_volume"), error, || {
        // SAFETY: the caller's promise (see the module).
        Ok(read_volume(&unsafe { buffers::path(path, "path")? })?)
    })
}

/// Writes what the image is. Set `out_info->struct_size` before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_volume_info(
    volume: *const MlgVolume,
    out_info: *mut MlgVolumeInfo,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill((volume, "volume"), (out_info, "out_info"), error, |file: &VolumeFile| {
        let volume = &file.volume;
        let (map, origin) = (volume.world_from_voxel(), volume.origin());
        let corners = volume.corners();
        let window = Window::fitting(volume);
        let info = MlgVolumeInfo {
            struct_size: size_of::<MlgVolumeInfo>(),
            size: volume.size(),
            world_from_voxel: std::array::from_fn(|i| {
                if i % 4 == 3 { origin[i / 4] } else { map[(i / 4, i % 4)] }
            }),
            spacing: volume.spacing().into(),
            range: volume.range().map(f64::from),
            window: [window.width, window.level],
            box_low: corners.iter().fold(corners[0], |low, c| low.inf(c)).into(),
            box_high: corners.iter().fold(corners[0], |high, c| high.sup(c)).into(),
        };
        Ok(info)
    })
}

/// What was noticed while reading, such as a tilted gantry: one sentence per line, written as by
/// `mlg_tri_mesh_check`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_volume_notes(
    volume: *const MlgVolume,
    buffer: *mut c_char,
    capacity: usize,
    out_length: *mut usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((volume, "volume"), error, |file: &VolumeFile| {
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write_text(&file.notes.join("\n"), buffer, capacity, out_length) }
    })
}

/// A plane through an image, as large as the image needs, with square pixels. Set
/// `out_plane->struct_size` before.
///
/// `axis`: three numbers; 0,0,1 is axial seen from the feet, 0,1,0 coronal seen from the front, 1,0,0
/// sagittal seen from the left, other directions are looked along. `position`: mm along the axis.
/// `pixel`: mm; 0: the image's smallest spacing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_volume_plane(
    volume: *const MlgVolume,
    axis: *const f64,
    position: f64,
    pixel: f64,
    out_plane: *mut MlgSlicePlane,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill((volume, "volume"), (out_plane, "out_plane"), error, |file: &VolumeFile| {
        // SAFETY: the caller's promise (see the module).
        let view = unsafe { view(axis)? };
        let pixel = if pixel == 0.0 { None } else { Some(pixel) };
        let plane = SlicePlane::of(&file.volume, view, position, pixel)?;
        let plane = MlgSlicePlane {
            struct_size: size_of::<MlgSlicePlane>(),
            corner: plane.corner.into(),
            right: plane.right.into(),
            down: plane.down.into(),
            width: plane.width,
            height: plane.height,
        };
        Ok(plane)
    })
}

/// Draws a slice into the caller's buffer, row by row from the top.
///
/// `channels`: 1 (grey) or 4 (red, green, blue, alpha; transparent outside the image).
/// `window`: two numbers, width and level: the values between black and white; NULL takes those of
/// `mlg_volume_info`. `pixels`: `capacity` bytes, at least `width * height * channels`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_volume_slice(
    volume: *const MlgVolume,
    plane: *const MlgSlicePlane,
    window: *const f64,
    channels: u32,
    pixels: *mut u8,
    capacity: usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((volume, "volume"), error, |file: &VolumeFile| {
        // SAFETY: the caller's promise (see the module).
        let plane = unsafe { plane_of(plane)? };
        let window = if window.is_null() {
            Window::fitting(&file.volume)
        } else {
            // SAFETY: not NULL, and the caller promises two numbers.
            let [width, level] = unsafe { window.cast::<[f64; 2]>().read() };
            Window { width, level }
        };
        if !(window.width.is_finite() && window.width > 0.0 && window.level.is_finite()) {
            return Err(Failure::invalid("window: the width must be above 0 and the level finite"));
        }
        if channels != 1 && channels != 4 {
            return Err(Failure::invalid(format!("channels is {channels}; it must be 1 or 4")));
        }
        let needed = plane.width * plane.height * channels as usize;
        if capacity < needed {
            return Err(Failure::invalid(format!(
                "pixels: the slice has {needed} bytes, the buffer {capacity}"
            )));
        }
        buffers::check_out(pixels, "pixels")?;
        let values = plane.sample(&file.volume);
        let grey = values.iter().map(|v| (window.grey(*v), if v.is_nan() { 0 } else { 255 }));
        let bytes: Vec<u8> = match channels {
            1 => grey.map(|(g, _)| g).collect(),
            _ => grey.flat_map(|(g, alpha)| [g, g, g, alpha]).collect(),
        };
        // SAFETY: not NULL, and the caller promises `capacity` bytes.
        unsafe { ptr::copy_nonoverlapping(bytes.as_ptr(), pixels, bytes.len()) };
        Ok(())
    })
}

/// Frees an image. NULL and handles freed already are allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_volume_free(volume: *mut MlgVolume) {
    access::free::<VolumeFile, _>(volume);
}

/// The lines along which a plane cuts a surface. Free with `mlg_polylines_free`.
///
/// `points`: `3 * point_count` coordinates in place of the mesh's own, or NULL; `point_count` must be
/// that of the mesh (ignored for NULL). `plane_point`, `plane_normal`: three numbers each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tri_mesh_section(
    mesh: *const MlgTriMesh,
    points: *const f64,
    point_count: usize,
    plane_point: *const f64,
    plane_normal: *const f64,
    out_lines: *mut *mut MlgPolylines,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_lines, "out_lines"), error, || {
        let surface = handles::get::<Surface, _>(mesh, "mesh")?;
        // SAFETY: the caller's promise (see the module).
        let point = unsafe { vector(plane_point, "plane_point")? };
        // SAFETY: as above.
        let normal = unsafe { vector(plane_normal, "plane_normal")? };
        let lines = if points.is_null() {
            plane_section(&surface.mesh, &point, &normal)
        } else {
            // SAFETY: as above.
            let points = unsafe { buffers::points(points, point_count, "points")? };
            if points.len() != surface.mesh.points.len() {
                return Err(Failure::invalid(format!(
                    "points: {} given, but the mesh has {}",
                    points.len(),
                    surface.mesh.points.len()
                )));
            }
            let triangles = surface.mesh.triangles.clone();
            plane_section(&TriMesh { points, triangles }, &point, &normal)
        };
        Ok(Lines::new(&lines))
    })
}

/// The points of all lines, one line after the other: `3 * *out_count` coordinates, borrowed until
/// the lines are freed. NULL without points or for a handle that is not valid. `out_count`: may be
/// NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_polylines_points(
    lines: *const MlgPolylines,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(lines, out_count, |lines: &Lines| &lines.points)
}

/// Where each line begins among the points, and at the end their number: `*out_count` is one more
/// than the number of lines. Borrowed until the lines are freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_polylines_starts(
    lines: *const MlgPolylines,
    out_count: *mut usize,
) -> *const usize {
    access::lend(lines, out_count, |lines: &Lines| &lines.starts)
}

/// For each line 1 if its last point is joined to its first, else 0. Borrowed until the lines are
/// freed; NULL without lines.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_polylines_closed(
    lines: *const MlgPolylines,
    out_count: *mut usize,
) -> *const u8 {
    access::lend(lines, out_count, |lines: &Lines| &lines.closed)
}

/// Frees lines. NULL and handles freed already are allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_polylines_free(lines: *mut MlgPolylines) {
    access::free::<Lines, _>(lines);
}

unsafe fn vector(pointer: *const f64, name: &str) -> Outcome<Vec3> {
    // SAFETY: passed on from the caller.
    Ok(unsafe { buffers::points(pointer, 1, name)? }[0])
}

unsafe fn view(axis: *const f64) -> Outcome<View> {
    // SAFETY: passed on from the caller.
    view_along(&unsafe { vector(axis, "axis")? })
}

pub(super) fn view_along(axis: &Vec3) -> Outcome<View> {
    let Some(unit) = axis.try_normalize(f64::MIN_POSITIVE) else {
        return Err(Failure::invalid("axis must not be 0,0,0"));
    };
    let own = [(Vec3::x(), View::Sagittal), (Vec3::y(), View::Coronal), (Vec3::z(), View::Axial)];
    let found = own.into_iter().find(|(own, _)| (own - unit).norm() < 1e-9);
    Ok(found.map_or(View::Along(unit), |(_, view)| view))
}

pub(super) unsafe fn plane_of(given: *const MlgSlicePlane) -> Outcome<SlicePlane> {
    const MOST_PIXELS: usize = 1 << 28;
    buffers::check_out(given, "plane")?;
    let (zero, struct_size) = ([0.0; 3], size_of::<MlgSlicePlane>());
    let empty =
        MlgSlicePlane { struct_size, corner: zero, right: zero, down: zero, width: 0, height: 0 };
    // SAFETY: passed on from the caller.
    let given = unsafe { buffers::options(given, empty)? };
    let [corner, right, down] = [given.corner, given.right, given.down].map(Vec3::from);
    let finite = [corner, right, down].iter().all(|v| v.iter().all(|x| x.is_finite()));
    if !finite || right.cross(&down).norm() <= 0.0 {
        return Err(Failure::invalid("plane: right and down must be finite and span a plane"));
    }
    let (width, height) = (given.width, given.height);
    if width.checked_mul(height).is_none_or(|count| count > MOST_PIXELS) {
        return Err(Failure::invalid(format!("plane: {width} x {height} pixels are too many")));
    }
    Ok(SlicePlane { corner, right, down, width, height })
}
