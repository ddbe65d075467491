//! What a reshaping gave.

use libc::c_char;

use super::access;
use super::boundary::{MlgError, MlgStatus, Outcome, name_of};
use super::buffers::{self, Versioned};
use super::tetrahedralization::MlgTetQuality;
use crate::fem::stretches_of;
use crate::job::write_deformed_tets;
use crate::math::Vec3;
use crate::measure::marker_distances;
use crate::mesh::TetQuality;
use crate::reshape::{Landmark, Problem, Reshaped, Stop};
use crate::separate::Body;

/// A reshaped template. Immutable; may be read from many threads.
pub struct MlgReshapingResult;

/// Why a reshaping ended. Reaching a limit is no error: the result is there.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MlgStop {
    /// The objective no longer falls by a relevant amount.
    Settled = 0,
    /// All markers are within the tolerance.
    ToleranceMet = 1,
    /// No step lowers the objective although it should.
    NoStep = 2,
    /// The iterations ran out.
    IterationLimit = 3,
    /// The caller asked to stop.
    Cancelled = 4,
}

/// The name of an `MlgStop`, e.g. "SETTLED"; "UNKNOWN" for other numbers. Static, never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn mlg_stop_name(stop: u32) -> *const c_char {
    const NAMES: [&str; 5] =
        ["SETTLED\0", "TOLERANCE_MET\0", "NO_STEP\0", "ITERATION_LIMIT\0", "CANCELLED\0"];
    name_of(&NAMES, stop)
}

/// The course of a reshaping. Lengths are in the template's unit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgReshapingSummary {
    /// `sizeof` this struct in the caller's header; set by the caller.
    pub struct_size: usize,
    /// Why it ended: a number of `MlgStop`.
    pub stop: u32,
    /// Gauss-Newton iterations.
    pub iterations: u32,
    /// Newton steps of all static solves.
    pub newton_steps: u32,
    /// Tets of no or negative volume in the result.
    pub inverted_tets: u32,
    /// Mean distance of the markers to the result; NaN without markers.
    pub mean_marker_distance: f64,
    /// Largest distance of a marker to the result; NaN without markers.
    pub max_marker_distance: f64,
    /// Seconds it took.
    pub seconds: f64,
    /// How often the shape reached was filled with new tets.
    pub remeshes: u32,
    /// Always 0.
    pub reserved: u32,
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgReshapingSummary {}

pub(super) struct ReshapingResult {
    reshaped: Reshaped,
    pub(super) distances: Distances,
    /// Largest and smallest principal stretch at each vertex of the surface.
    stretches: (Vec<f64>, Vec<f64>),
    seconds: f64,
}

/// How far data are from the result.
pub(super) struct Distances {
    pub markers: Vec<f64>,
    pub landmarks: Vec<f64>,
    pub attachments: Vec<f64>,
}

impl Distances {
    fn new(problem: &Problem, reshaped: &Reshaped) -> Outcome<Self> {
        let markers: Vec<Vec3> = problem.markers.iter().map(|m| m.position).collect();
        let triangles = &problem.surface.triangles;
        let (landmarks, attachments) = pair_distances(problem, reshaped)?;
        let markers = marker_distances(&reshaped.surface_points, triangles, &markers);
        Ok(Self { markers, landmarks, attachments })
    }
}

/// Of landmarks and of attachments: both are looked up in the tets at once.
fn pair_distances(problem: &Problem, reshaped: &Reshaped) -> Outcome<(Vec<f64>, Vec<f64>)> {
    let pairs: Vec<&Landmark> = problem.landmarks.iter().chain(&problem.attachments).collect();
    if pairs.is_empty() {
        return Ok((Vec::new(), Vec::new()));
    }
    let places: Vec<Vec3> =
        pairs.iter().map(|pair| pair.template.position(&problem.surface.points)).collect();
    let moved = reshaped.carry(&places)?;
    let mut landmarks: Vec<f64> =
        pairs.iter().zip(moved).map(|(pair, now)| (now - pair.target).norm()).collect();
    let attachments = landmarks.split_off(problem.landmarks.len());
    Ok((landmarks, attachments))
}

impl ReshapingResult {
    pub fn new(problem: &Problem, reshaped: Reshaped, seconds: f64) -> Outcome<Self> {
        let distances = Distances::new(problem, &reshaped)?;
        let last = &reshaped.problem;
        let stretches = stretches_of(&reshaped.gradients(), &last.tets, &last.embedding);
        Ok(Self { reshaped, distances, stretches, seconds })
    }

    pub fn reshaped(&self) -> &Reshaped {
        &self.reshaped
    }

    /// The result as a body that contact can push.
    pub fn body(&self, name: String) -> Body {
        let problem = &self.reshaped.problem;
        Body {
            name,
            tets: self.reshaped.deformed_tets(),
            embedding: problem.embedding.clone(),
            triangles: problem.surface.triangles.clone(),
            markers: problem.markers.iter().map(|m| m.position).collect(),
        }
    }

    fn summary(&self) -> MlgReshapingSummary {
        let stop = match self.reshaped.summary.stop {
            Stop::Settled => MlgStop::Settled,
            Stop::ToleranceMet => MlgStop::ToleranceMet,
            Stop::NoStep => MlgStop::NoStep,
            Stop::IterationLimit => MlgStop::IterationLimit,
            Stop::Cancelled => MlgStop::Cancelled,
        };
        let distances = &self.distances.markers;
        MlgReshapingSummary {
            struct_size: size_of::<MlgReshapingSummary>(),
            stop: stop as u32,
            iterations: self.reshaped.summary.iteration_count() as u32,
            newton_steps: self.reshaped.summary.newton_steps as u32,
            inverted_tets: self.quality().inverted as u32,
            mean_marker_distance: distances.iter().sum::<f64>() / distances.len() as f64,
            max_marker_distance: distances.iter().copied().fold(f64::NAN, f64::max),
            seconds: self.seconds,
            remeshes: self.reshaped.summary.remeshes.len() as u32,
            reserved: 0,
        }
    }

    fn quality(&self) -> TetQuality {
        TetQuality::of(&self.reshaped.problem.tets.tets, &self.reshaped.tet_points)
    }
}

/// The surface's points, in the template's order: `3 * *out_count` coordinates, borrowed until the
/// result is freed. NULL for a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_points(
    result: *const MlgReshapingResult,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(result, out_count, |result: &ReshapingResult| &result.reshaped.surface_points)
}

/// The four corners of each tet of the result: `4 * *out_count` indices, borrowed until the result is
/// freed. The tets of the problem, unless new ones were made (`remeshes` in the summary). NULL for a
/// handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_tets(
    result: *const MlgReshapingResult,
    out_count: *mut usize,
) -> *const u32 {
    access::lend(result, out_count, |result: &ReshapingResult| &result.reshaped.problem.tets.tets)
}

/// The points of these tets, in their order: `3 * *out_count` coordinates, borrowed until the result is
/// freed. NULL for a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_tet_points(
    result: *const MlgReshapingResult,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(result, out_count, |result: &ReshapingResult| &result.reshaped.tet_points)
}

/// The plastic strain Fp of each of these tets, from the template to the person: `9 * *out_count`
/// numbers, a symmetric 3x3 matrix each; borrowed until the result is freed. NULL for a handle that is
/// not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_plastic_strains(
    result: *const MlgReshapingResult,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(result, out_count, |result: &ReshapingResult| &result.reshaped.plastic_strain)
}

/// The largest principal stretch of the deformation at each vertex of the surface: `*out_count`
/// numbers, 1 where nothing was stretched; borrowed until the result is freed. NULL for a handle that
/// is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_max_stretches(
    result: *const MlgReshapingResult,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(result, out_count, |result: &ReshapingResult| &result.stretches.0)
}

/// The smallest principal stretch of the deformation at each vertex of the surface, as
/// `mlg_reshaping_result_max_stretches`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_min_stretches(
    result: *const MlgReshapingResult,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(result, out_count, |result: &ReshapingResult| &result.stretches.1)
}

/// Carries other points along by the deformation: vessels inside, a textured mesh around.
///
/// `points`: `3 * count` coordinates at rest, finite; those outside the tets go with the nearest
/// one. `out_points`: room for `3 * count` coordinates; may be `points` itself.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_carry(
    result: *const MlgReshapingResult,
    points: *const f64,
    count: usize,
    out_points: *mut f64,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((result, "result"), error, |result: &ReshapingResult| {
        // SAFETY: the caller's promise (see the module).
        let points = unsafe { buffers::points(points, count, "points")? };
        let carried = result.reshaped.carry(&points)?;
        // SAFETY: as above.
        unsafe { buffers::copy_points(&carried, out_points, count) }
    })
}

/// Writes the deformed tets as `.vtu` (VTK, for ParaView) with the plastic strain, its principal
/// stretches and the inside fraction of each tet and the rest position of each point. `path`: UTF-8.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_save_tets(
    result: *const MlgReshapingResult,
    path: *const c_char,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((result, "result"), error, |result: &ReshapingResult| {
        // SAFETY: the caller's promise (see the module).
        let path = unsafe { buffers::new_path(path, "path")? };
        Ok(write_deformed_tets(&path, &result.reshaped)?)
    })
}

/// Tells how it went. `out_summary`: its `struct_size` must be set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_summary(
    result: *const MlgReshapingResult,
    out_summary: *mut MlgReshapingSummary,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill(
        (result, "result"),
        (out_summary, "out_summary"),
        error,
        |result: &ReshapingResult| Ok(result.summary()),
    )
}

/// Measures the tets of the result. `out_quality`: its `struct_size` must be set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_quality(
    result: *const MlgReshapingResult,
    out_quality: *mut MlgTetQuality,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill(
        (result, "result"),
        (out_quality, "out_quality"),
        error,
        |result: &ReshapingResult| Ok((&result.quality()).into()),
    )
}

/// Frees a result. NULL and handles freed already are allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_result_free(result: *mut MlgReshapingResult) {
    access::free::<ReshapingResult, _>(result);
}
