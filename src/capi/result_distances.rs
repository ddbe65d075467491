//! What a reshaping gave: how far markers, landmarks and attachments are from it.

use super::boundary::lent;
use super::result::{MlgReshapingResult, ReshapingResult};
use super::{buffers, handles};

/// The distance of each marker to the result: `*out_count` numbers in the markers' order, borrowed
/// until the result is freed. NULL without markers or for a handle that is not valid. `out_count`:
/// may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_marker_distances(
    result: *const MlgReshapingResult,
    out_count: *mut usize,
) -> *const f64 {
    lent(out_count, || {
        let result = handles::get::<ReshapingResult, _>(result, "result")?;
        // SAFETY: the caller's promise (see the module); the list lives in the table.
        Ok(unsafe { buffers::lend(&result.distances.markers, out_count) })
    })
}

/// The distance of each landmark's place on the result to its target: `*out_count` numbers in the order in
/// which they were set, borrowed until the result is freed. NULL without landmarks or for a handle that is
/// not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_landmark_distances(
    result: *const MlgReshapingResult,
    out_count: *mut usize,
) -> *const f64 {
    lent(out_count, || {
        let result = handles::get::<ReshapingResult, _>(result, "result")?;
        // SAFETY: the caller's promise (see the module); the list lives in the table.
        Ok(unsafe { buffers::lend(&result.distances.landmarks, out_count) })
    })
}

/// The distance of each attachment's place on the result to its target: `*out_count` numbers in the order in
/// which they were set, borrowed until the result is freed. NULL without attachments or for a handle that is
/// not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_attachment_distances(
    result: *const MlgReshapingResult,
    out_count: *mut usize,
) -> *const f64 {
    lent(out_count, || {
        let result = handles::get::<ReshapingResult, _>(result, "result")?;
        // SAFETY: the caller's promise (see the module); the list lives in the table.
        Ok(unsafe { buffers::lend(&result.distances.attachments, out_count) })
    })
}
