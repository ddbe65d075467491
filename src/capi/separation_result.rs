//! What a separation gave.

use libc::c_char;

use super::access;
use super::boundary::{MlgError, MlgStatus, name_of};
use super::buffers::{self, Versioned};
use crate::separate::{Body, Ending, MovedBody, Obstacle, OverlapLine, Separation, Summary};

/// Bodies that were pushed apart. Immutable; may be read from many threads.
pub struct MlgSeparationResult;

/// Why a separation ended.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MlgEnding {
    /// No contact is left.
    Parted = 0,
    /// Overlaps no longer shrank; the shapes with the least are the result.
    Stalled = 1,
    /// It was stopped on request; the shapes with the least overlap so far are the result.
    Cancelled = 2,
}

/// The name of an `MlgEnding`, e.g. "PARTED"; "UNKNOWN" for other numbers. Static, never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn mlg_ending_name(ending: u32) -> *const c_char {
    name_of(&["PARTED\0", "STALLED\0", "CANCELLED\0"], ending)
}

/// The course of a separation.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgSeparationSummary {
    /// `sizeof` this struct in the caller's header; set by the caller.
    pub struct_size: usize,
    /// Why it ended: an `MlgEnding`.
    pub ending: u32,
    /// 1: no triangle of one surface crosses or lies inside another; decided exactly.
    pub separated: u32,
    /// Rounds of finding contacts and solving.
    pub rounds: u32,
    /// Pairs of surfaces that overlap or did; `mlg_separation_result_overlap` tells about each.
    pub overlap_count: u32,
    /// Seconds it took.
    pub seconds: f64,
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgSeparationSummary {}

/// Two surfaces that overlap or did, before (index 0) and after (index 1). Lengths are in the bodies'
/// unit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgOverlap {
    /// `sizeof` this struct in the caller's header; set by the caller.
    pub struct_size: usize,
    /// Number of the first surface: bodies from 0, then obstacles.
    pub first: u32,
    /// Number of the second.
    pub second: u32,
    /// Largest distance of a vertex inside to the other's surface.
    pub depth: [f64; 2],
    /// Vertices of either that lie inside the other.
    pub vertices_inside: [u32; 2],
    /// Pairs of triangles that cross.
    pub crossings: [u32; 2],
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgOverlap {}

/// What a separation did to one body. Lengths are in the bodies' unit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgSeparatedBody {
    /// `sizeof` this struct in the caller's header; set by the caller.
    pub struct_size: usize,
    /// Vertices of its surface that moved.
    pub moved_vertices: u32,
    /// Tets of no or negative volume.
    pub inverted_tets: u32,
    /// The farthest move.
    pub largest_move: f64,
    /// Mean distance of its markers to its surface before (index 0) and after (1), of those outside
    /// all obstacles; NaN without any.
    pub mean_marker_distance: [f64; 2],
    /// Largest such distance.
    pub max_marker_distance: [f64; 2],
    /// Markers inside an obstacle, which cannot be met.
    pub markers_inside_obstacles: u32,
    /// 0.
    pub reserved: u32,
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgSeparatedBody {}

pub(super) struct SeparationResult {
    separation: Separation,
    summary: Summary,
    /// Names of bodies, then obstacles.
    names: Vec<String>,
    seconds: f64,
}

impl SeparationResult {
    pub fn new(
        bodies: &[Body],
        obstacles: &[Obstacle],
        separation: Separation,
        seconds: f64,
    ) -> Self {
        let names = bodies.iter().map(|b| &b.name).chain(obstacles.iter().map(|o| &o.name));
        Self {
            summary: Summary::new(bodies, obstacles, &separation),
            names: names.cloned().collect(),
            separation,
            seconds,
        }
    }

    fn summary(&self) -> MlgSeparationSummary {
        let ending = match self.separation.ending {
            Ending::Parted => MlgEnding::Parted,
            Ending::Stalled => MlgEnding::Stalled,
            Ending::Cancelled => MlgEnding::Cancelled,
        };
        MlgSeparationSummary {
            struct_size: size_of::<MlgSeparationSummary>(),
            ending: ending as u32,
            separated: u32::from(self.summary.separated),
            rounds: self.separation.rounds as u32,
            overlap_count: self.summary.overlaps.len() as u32,
            seconds: self.seconds,
        }
    }

    fn overlap(&self, line: &OverlapLine) -> MlgOverlap {
        let number = |name: &String| self.names.iter().position(|n| n == name);
        let [first, second] = [0, 1].map(|k| number(&line.between[k]).unwrap_or_default() as u32);
        MlgOverlap {
            struct_size: size_of::<MlgOverlap>(),
            first,
            second,
            depth: line.depth,
            vertices_inside: line.vertices_inside.map(|n| n as u32),
            crossings: line.crossings.map(|n| n as u32),
        }
    }
}

fn body_of(found: &MovedBody) -> MlgSeparatedBody {
    let distances = |of: fn(&crate::measure::Spread) -> f64| {
        found.marker_distance.as_ref().map_or([f64::NAN; 2], |[a, b]| [of(a), of(b)])
    };
    MlgSeparatedBody {
        struct_size: size_of::<MlgSeparatedBody>(),
        moved_vertices: found.moved as u32,
        inverted_tets: found.inverted_tets as u32,
        largest_move: found.largest_move,
        mean_marker_distance: distances(|s| s.mean),
        max_marker_distance: distances(|s| s.max),
        markers_inside_obstacles: found.contradicting_markers.len() as u32,
        reserved: 0,
    }
}

/// The points of a body's surface, in its order: `3 * *out_count` coordinates, borrowed until the
/// result is freed. NULL if `body` is not below the count or the handle is not valid. `out_count`: may
/// be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_result_points(
    result: *const MlgSeparationResult,
    body: usize,
    out_count: *mut usize,
) -> *const f64 {
    access::lend_some(result, out_count, |result: &SeparationResult| {
        result.separation.surface_points.get(body).map(Vec::as_slice)
    })
}

/// The points of a body's tets, in their order, as `mlg_separation_result_points`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_result_tet_points(
    result: *const MlgSeparationResult,
    body: usize,
    out_count: *mut usize,
) -> *const f64 {
    access::lend_some(result, out_count, |result: &SeparationResult| {
        result.separation.tet_points.get(body).map(Vec::as_slice)
    })
}

/// Tells how it went. `out_summary`: its `struct_size` must be set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_result_summary(
    result: *const MlgSeparationResult,
    out_summary: *mut MlgSeparationSummary,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill(
        (result, "result"),
        (out_summary, "out_summary"),
        error,
        |result: &SeparationResult| Ok(result.summary()),
    )
}

/// Tells about a pair of surfaces that overlap or did, a number from 0 below `overlap_count` in the
/// summary. `out_overlap`: its `struct_size` must be set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_result_overlap(
    result: *const MlgSeparationResult,
    overlap: usize,
    out_overlap: *mut MlgOverlap,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill(
        (result, "result"),
        (out_overlap, "out_overlap"),
        error,
        |result: &SeparationResult| {
            let found =
                result.overlap(buffers::entry(&result.summary.overlaps, overlap, "overlap")?);
            Ok(found)
        },
    )
}

/// Tells what was done to a body, a number from 0. `out_body`: its `struct_size` must be set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_result_body(
    result: *const MlgSeparationResult,
    body: usize,
    out_body: *mut MlgSeparatedBody,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill((result, "result"), (out_body, "out_body"), error, |result: &SeparationResult| {
        let found = body_of(buffers::entry(&result.summary.bodies, body, "body")?);
        Ok(found)
    })
}

/// Frees a result. NULL and handles freed already are allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_result_free(result: *mut MlgSeparationResult) {
    access::free::<SeparationResult, _>(result);
}
