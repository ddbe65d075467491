//! Markers, from arrays and files.

use libc::c_char;
use std::ffi::CString;
use std::ptr;

use super::boundary::{MlgError, MlgStatus};
use super::{access, buffers};
use crate::io::{self, read_markers, write_markers};
use crate::math::Vec3;

/// Points that somebody marked. Immutable; may be read from many threads.
pub struct MlgMarkers;

pub(super) struct Markers {
    points: Vec<Vec3>,
    weights: Vec<f64>,
    sigmas: Vec<f64>,
    labels: Vec<Option<CString>>,
    /// As the file has them: what is not said there is not written either.
    original: Vec<io::Marker>,
}

impl Markers {
    pub fn new(markers: Vec<io::Marker>) -> Self {
        let label = |m: &io::Marker| m.label.as_deref().and_then(|l| CString::new(l).ok());
        Self {
            points: markers.iter().map(|m| m.position).collect(),
            weights: markers.iter().map(|m| m.weight.unwrap_or(1.0)).collect(),
            sigmas: markers.iter().map(|m| m.sigma.unwrap_or(0.0)).collect(),
            labels: markers.iter().map(label).collect(),
            original: markers,
        }
    }
}

/// Makes markers from arrays, which are copied.
///
/// `points`: `3 * count` coordinates, finite. `weights`: `count` numbers, 0 or more, or NULL for 1
/// throughout. `labels`: `count` names in UTF-8, each of which may be NULL; or NULL for none. Free
/// with `mlg_markers_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_markers_new(
    points: *const f64,
    weights: *const f64,
    labels: *const *const c_char,
    count: usize,
    out_markers: *mut *mut MlgMarkers,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_markers, "out_markers"), error, || {
        // SAFETY: the caller's promise (see the module).
        let places = unsafe { buffers::points(points, count, "points")? };
        let given = !weights.is_null();
        // SAFETY: as above.
        let weights = unsafe { buffers::weights(weights, count)? };
        // SAFETY: as above.
        let labels = unsafe { buffers::texts(labels, count, "labels")? };
        let markers = places.into_iter().zip(weights).zip(labels);
        let markers = markers.map(|((position, weight), label)| io::Marker {
            label,
            weight: given.then_some(weight),
            ..io::Marker::at(position)
        });
        Ok(Markers::new(markers.collect()))
    })
}

/// Reads markers from `.csv`, `.txt`, `.xyz`, `.ply`, 3D Slicer `.mrk.json` and `.fcsv` (turned
/// into RAS) or MeshLab `.pp`. `path`: UTF-8. Free with `mlg_markers_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_markers_load(
    path: *const c_char,
    out_markers: *mut *mut MlgMarkers,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_markers, "out_markers"), error, || {
        // SAFETY: the caller's promise (see the module).
        let markers = read_markers(&unsafe { buffers::path(path, "path")? })?;
        Ok(Markers::new(markers))
    })
}

/// Writes markers as `.csv`, 3D Slicer `.mrk.json` or `.fcsv` (said to be RAS) or MeshLab `.pp`.
/// `path`: UTF-8.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_markers_save(
    markers: *const MlgMarkers,
    path: *const c_char,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((markers, "markers"), error, |markers: &Markers| {
        // SAFETY: the caller's promise (see the module).
        Ok(write_markers(&unsafe { buffers::new_path(path, "path")? }, &markers.original)?)
    })
}

/// The positions: `3 * *out_count` coordinates, borrowed until the markers are freed. NULL for a
/// handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_markers_points(
    markers: *const MlgMarkers,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(markers, out_count, |markers: &Markers| &markers.points)
}

/// The noise of each: `*out_count` numbers, 0 where the file gives none, borrowed until the markers are
/// freed. NULL for a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_markers_sigmas(
    markers: *const MlgMarkers,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(markers, out_count, |markers: &Markers| &markers.sigmas)
}

/// The weights: `*out_count` numbers, 1 where the file gives none, borrowed until the markers are
/// freed. NULL for a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_markers_weights(
    markers: *const MlgMarkers,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(markers, out_count, |markers: &Markers| &markers.weights)
}

/// The name of one marker: UTF-8, borrowed until the markers are freed. NULL where it has none, if
/// `index` is not below the count, or for a handle that is not valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_markers_label(
    markers: *const MlgMarkers,
    index: usize,
) -> *const c_char {
    access::read_or(ptr::null(), markers, |markers: &Markers| {
        let label = markers.labels.get(index).and_then(Option::as_ref);
        label.map_or(ptr::null(), |l| l.as_ptr())
    })
}

/// Frees markers. NULL and handles freed already are allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_markers_free(markers: *mut MlgMarkers) {
    access::free::<Markers, _>(markers);
}
