//! Marker files.

use libc::c_char;
use std::ptr;

use super::boundary::{MlgError, MlgStatus, guard, guard_or};
use super::{buffers, handles};
use crate::io::read_markers;
use crate::math::Vec3;

/// Points that somebody marked, read from a file. Immutable; may be read from many threads.
pub struct MlgMarkers;

struct Markers {
    points: Vec<Vec3>,
    weights: Vec<f64>,
}

/// Reads markers from `.csv`, `.txt`, `.xyz`, `.ply`, 3D Slicer `.mrk.json` and `.fcsv` (turned
/// into RAS) or MeshLab `.pp`. `path`: UTF-8. Free with `mlg_markers_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_markers_load(
    path: *const c_char,
    out_markers: *mut *mut MlgMarkers,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_markers, "out_markers")?;
        // SAFETY: the caller's promise (see the module).
        let markers = read_markers(&unsafe { buffers::path(path, "path")? })?;
        let points = markers.iter().map(|m| m.position).collect();
        let weights = markers.iter().map(|m| m.weight.unwrap_or(1.0)).collect();
        let handle = handles::give(Markers { points, weights });
        // SAFETY: as above.
        unsafe { buffers::write(out_markers, handle, "out_markers") }
    })
}

/// The positions: `3 * *out_count` coordinates, borrowed until the markers are freed. NULL for a
/// handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_markers_points(
    markers: *const MlgMarkers,
    out_count: *mut usize,
) -> *const f64 {
    guard_or(ptr::null(), || {
        let markers = handles::get::<Markers, _>(markers, "markers")?;
        // SAFETY: the caller's promise (see the module); the list lives in the table.
        Ok(unsafe { buffers::lend(&markers.points, out_count) })
    })
}

/// The weights: `*out_count` numbers, 1 where the file gives none, borrowed until the markers are
/// freed. NULL for a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_markers_weights(
    markers: *const MlgMarkers,
    out_count: *mut usize,
) -> *const f64 {
    guard_or(ptr::null(), || {
        let markers = handles::get::<Markers, _>(markers, "markers")?;
        // SAFETY: the caller's promise (see the module); the list lives in the table.
        Ok(unsafe { buffers::lend(&markers.weights, out_count) })
    })
}

/// Frees markers. NULL and handles freed already are allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_markers_free(markers: *mut MlgMarkers) {
    guard_or((), || {
        handles::free::<Markers, _>(markers);
        Ok(())
    });
}
