//! What a reshaping gave: how far markers, landmarks and attachments are from it.

use super::access;
use super::result::{MlgReshapingResult, ReshapingResult};

/// The distance of each marker to the result: `*out_count` numbers in the markers' order, borrowed
/// until the result is freed. NULL without markers or for a handle that is not valid. `out_count`:
/// may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_marker_distances(
    result: *const MlgReshapingResult,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(result, out_count, |result: &ReshapingResult| &result.distances.markers)
}

/// The distance of each landmark's place on the result to its target: `*out_count` numbers in the order in
/// which they were set, borrowed until the result is freed. NULL without landmarks or for a handle that is
/// not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_landmark_distances(
    result: *const MlgReshapingResult,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(result, out_count, |result: &ReshapingResult| &result.distances.landmarks)
}

/// The distance of each attachment's place on the result to its target: `*out_count` numbers in the order in
/// which they were set, borrowed until the result is freed. NULL without attachments or for a handle that is
/// not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_attachment_distances(
    result: *const MlgReshapingResult,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(result, out_count, |result: &ReshapingResult| &result.distances.attachments)
}
