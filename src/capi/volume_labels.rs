//! Label maps: which labels there are, their outlines, markers on them, their surfaces.

use libc::c_char;
use std::ptr;

use super::boundary::{Failure, MlgError, MlgStatus, Outcome, guard};
use super::buffers::{self, Versioned};
use super::markers::{Markers, MlgMarkers};
use super::mesh::{MlgTriMesh, Surface};
use super::volume::{Lines, MlgPolylines, MlgSlicePlane, MlgVolume, plane_of, view_along};
use super::{access, handles};
use crate::io::{Marker, VolumeFile};
use crate::mesh::TriMesh;
use crate::volume::{Clicks, View, label_markers, label_surface, outlines};

/// How markers are put on the outlines of a label. Set with `mlg_clicks_init`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgClicks {
    /// `sizeof` this struct in the caller's header.
    pub struct_size: usize,
    /// Millimetres between slices. Default: 9.
    pub every: f64,
    /// Millimetres between markers along an outline. Default: 8.
    pub spacing: f64,
    /// Standard deviation of a hand's error, mm. Default: 0, none.
    pub jitter: f64,
    /// Another number gives other errors. Default: 1.
    pub seed: u64,
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgClicks {}

/// The labels of a label map, ascending, without 0: writes the first `capacity` of them to
/// `out_labels` and their number to `out_count`. An image whose values are no whole numbers, or more
/// than 4096 different ones, is refused. `out_labels` may be NULL if `capacity` is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_volume_labels(
    labels: *const MlgVolume,
    out_labels: *mut u32,
    capacity: usize,
    out_count: *mut usize,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_count, "out_count")?;
        if capacity > 0 {
            buffers::check_out(out_labels, "out_labels")?;
        }
        let file = handles::get::<VolumeFile, _>(labels, "labels")?;
        let known = file.volume.labels().ok_or_else(|| {
            Failure::invalid(
                "the image is not a label map: its values are not whole numbers, or too many",
            )
        })?;
        for (k, (label, _)) in known.iter().take(capacity).enumerate() {
            // SAFETY: the caller's promise (see the module): room for `capacity` numbers.
            unsafe { out_labels.add(k).write(*label) };
        }
        // SAFETY: as above.
        unsafe { buffers::write(out_count, known.len(), "out_count") }
    })
}

/// The name that the file has for a label (TotalSegmentator's and 3D Slicer's have), in UTF-8, written as by
/// `mlg_tri_mesh_check`; empty where it has none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_volume_label_name(
    labels: *const MlgVolume,
    label: u32,
    buffer: *mut c_char,
    capacity: usize,
    out_length: *mut usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((labels, "labels"), error, |file: &VolumeFile| {
        let name = file.label_names.get(&label).map_or("", String::as_str);
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write_text(name, buffer, capacity, out_length) }
    })
}

/// The outlines of one label of a label map on a plane, smooth over the voxels' stairs. Free with
/// `mlg_polylines_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_volume_outlines(
    labels: *const MlgVolume,
    label: u32,
    plane: *const MlgSlicePlane,
    out_lines: *mut *mut MlgPolylines,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_lines, "out_lines"), error, || {
        let file = handles::get::<VolumeFile, _>(labels, "labels")?;
        // SAFETY: the caller's promise (see the module).
        let plane = unsafe { plane_of(plane)? };
        let lines = Lines::new(&outlines(&file.volume, label, &plane));
        Ok(lines)
    })
}

/// Writes the defaults. `struct_size`: `sizeof *out_clicks`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_clicks_init(
    out_clicks: *mut MlgClicks,
    struct_size: usize,
) -> MlgStatus {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write_versioned(out_clicks, struct_size, defaults(), "out_clicks") }
    })
}

/// Markers on the outlines of one label, as a person would click them on slices. Free with
/// `mlg_markers_free`.
///
/// `axes`: `3 * axis_count` numbers, one view each as in `mlg_volume_plane`. `clicks`: NULL for the
/// defaults.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_volume_label_markers(
    labels: *const MlgVolume,
    label: u32,
    axes: *const f64,
    axis_count: usize,
    clicks: *const MlgClicks,
    out_markers: *mut *mut MlgMarkers,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_markers, "out_markers"), error, || {
        let file = handles::get::<VolumeFile, _>(labels, "labels")?;
        // SAFETY: the caller's promise (see the module).
        let axes = unsafe { buffers::points(axes, axis_count, "axes")? };
        let views: Outcome<Vec<View>> = axes.iter().map(view_along).collect();
        // SAFETY: as above.
        let given = unsafe { buffers::options(clicks, defaults())? };
        let MlgClicks { every, spacing, jitter, seed, .. } = given;
        let clicks = Clicks { every, spacing, jitter, seed };
        let points = label_markers(&file.volume, label, &views?, &clicks)?;
        let markers = points.into_iter().map(Marker::at).collect();
        Ok(Markers::new(markers))
    })
}

/// The surface of one label, outwards, smooth over the voxels' stairs; open where the image ends inside
/// the label. Free with `mlg_tri_mesh_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_volume_label_surface(
    labels: *const MlgVolume,
    label: u32,
    out_mesh: *mut *mut MlgTriMesh,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_mesh, "out_mesh"), error, || {
        let file = handles::get::<VolumeFile, _>(labels, "labels")?;
        let (points, triangles) = label_surface(&file.volume, label).ok_or_else(|| {
            Failure::invalid(format!(
                "label {label} has no surface: no voxel of the image has it, or all have"
            ))
        })?;
        let mesh = TriMesh::new(points, triangles)?;
        Ok(Surface { mesh, file: None })
    })
}

fn defaults() -> MlgClicks {
    let Clicks { every, spacing, jitter, seed } = Clicks::default();
    MlgClicks { struct_size: size_of::<MlgClicks>(), every, spacing, jitter, seed }
}
