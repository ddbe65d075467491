//! Reshaping: the problem and its options.

use std::ptr;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::boundary::{Failure, MlgError, MlgStatus, Outcome, guard};
use super::buffers::{self, Versioned};
use super::mesh::vertices_of;
use super::tetrahedralization::{Carried, MlgTetrahedralization};
use super::{access, handles};
use crate::reshape::{Landmark, Marker, Options, Problem, TemplatePoint};

/// A template and the data it is to follow. May be used by one thread at a time.
pub struct MlgReshaping;

pub(super) struct ProblemObject(Mutex<Problem>);

impl ProblemObject {
    pub fn lock(&self) -> MutexGuard<'_, Problem> {
        // Each setter changes one list in one go, so the data is whole whatever panicked.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// How to reshape. Set with `mlg_reshaping_options_init`. Lengths are in the template's unit; 0
/// takes a default relative to the template's size.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgReshapingOptions {
    /// `sizeof` this struct in the caller's header.
    pub struct_size: usize,
    /// How far a marker may be off. 0 (default): the template's diagonal / 1000.
    pub tolerance: f64,
    /// How far a landmark may be off. 0 (default): 5 times `tolerance`.
    pub landmark_tolerance: f64,
    /// How far an attachment may be off. 0 (default): `tolerance`.
    pub attachment_tolerance: f64,
    /// Weight of the smoothness of the plastic strain, dimensionless. Default: 0.08.
    pub smoothness: f64,
    /// Distance over which the strain returns to its mean away from data, as a multiple of the cube
    /// root of the template's volume; INFINITY: never. 0 (default): by how much of it was seen.
    pub screening: f64,
    /// Poisson's ratio of the tissue, above 0 and below 0.5. Default: 0.3.
    pub poisson: f64,
    /// 1: attachments are met whatever the markers say. 0 (default): they are weighed.
    pub hard_attachments: u32,
    /// Gauss-Newton iterations allowed. Default: 80; 0 stands for it, too.
    pub max_iterations: u32,
    /// Threads to use, up to 1024; 0 (default): all. The result does not depend on it.
    pub thread_count: u32,
    /// 1: the published formulation, for comparison. 0 (default): the improved one.
    pub paper: u32,
    /// 1 (default): template points far from every marker are pulled back, except beyond the ends of
    /// a scan that cuts the organ. 0: they are left alone.
    pub reverse_term: u32,
    /// Leave at 0.
    pub reserved: u32,
    /// How often the shape reached may be filled with new tets, where a very large change has made the
    /// old ones so flat that nothing more is gained. Default: 3; 0: never. The result's tets are the new ones.
    pub max_remeshes: u32,
    /// Leave at 0.
    pub reserved_too: u32,
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgReshapingOptions {}

fn defaults() -> MlgReshapingOptions {
    let options = Options::default();
    MlgReshapingOptions {
        struct_size: size_of::<MlgReshapingOptions>(),
        tolerance: options.tolerance.unwrap_or(0.0),
        landmark_tolerance: options.landmark_tolerance.unwrap_or(0.0),
        attachment_tolerance: options.attachment_tolerance.unwrap_or(0.0),
        smoothness: options.smoothness,
        screening: options.screening.unwrap_or(0.0),
        poisson: options.poisson,
        hard_attachments: u32::from(options.hard_attachments),
        max_iterations: options.max_iterations as u32,
        thread_count: 0,
        paper: u32::from(options.paper),
        reverse_term: u32::from(options.reverse_term),
        reserved: 0,
        max_remeshes: options.max_remeshes as u32,
        reserved_too: 0,
    }
}

/// Writes the defaults. `struct_size`: `sizeof *out_options`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_options_init(
    out_options: *mut MlgReshapingOptions,
    struct_size: usize,
) -> MlgStatus {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write_versioned(out_options, struct_size, defaults(), "out_options") }
    })
}

/// The options in Rust's form, and the thread count.
pub(super) unsafe fn options_of(given: *const MlgReshapingOptions) -> Outcome<(Options, usize)> {
    // SAFETY: passed on from the caller.
    let given = unsafe { buffers::options(given, defaults())? };
    if given.hard_attachments > 1
        || given.paper > 1
        || given.reverse_term > 1
        || given.reserved != 0
        || given.reserved_too != 0
    {
        return Err(Failure::invalid(
            "options: hard_attachments, paper and reverse_term must be 0 or 1 and the reserved ones 0; start from mlg_reshaping_options_init",
        ));
    }
    let length = |value: f64| if value == 0.0 { None } else { Some(value) };
    let options = Options {
        tolerance: length(given.tolerance),
        landmark_tolerance: length(given.landmark_tolerance),
        attachment_tolerance: length(given.attachment_tolerance),
        smoothness: given.smoothness,
        screening: length(given.screening),
        poisson: given.poisson,
        hard_attachments: given.hard_attachments == 1,
        paper: given.paper == 1,
        reverse_term: given.reverse_term == 1,
        max_iterations: match given.max_iterations {
            0 => Options::default().max_iterations,
            given => given as usize,
        },
        max_remeshes: given.max_remeshes as usize,
    };
    options.check()?;
    Ok((options, given.thread_count as usize))
}

/// Makes a problem of a carried template, without data yet. Free with `mlg_reshaping_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_new(
    template_tets: *const MlgTetrahedralization,
    out_problem: *mut *mut MlgReshaping,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_problem, "out_problem"), error, || {
        let carried = handles::get::<Carried, _>(template_tets, "template_tets")?;
        let mut problem = Problem::new(carried.surface.mesh.clone(), carried.tets.clone());
        if let Some(options) = &carried.options {
            problem.new_tets = options.clone();
        }
        Ok(ProblemObject(Mutex::new(problem)))
    })
}

/// Sets the markers: points of the person's surface, without correspondence. Replaces earlier ones.
///
/// `points`: `3 * count` coordinates, finite, in the template's unit and frame. `weights`: `count`
/// numbers, 0 or more, or NULL for 1 throughout.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_set_markers(
    problem: *mut MlgReshaping,
    points: *const f64,
    weights: *const f64,
    count: usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        // SAFETY: the caller's promise (see the module).
        let points = unsafe { buffers::points(points, count, "points")? };
        // SAFETY: as above.
        let weights = unsafe { buffers::weights(weights, count)? };
        let markers = points.into_iter().zip(weights);
        problem.lock().markers =
            markers.map(|(position, weight)| Marker { weight, ..Marker::at(position) }).collect();
        Ok(())
    })
}

/// Sets each marker's own noise, in place of the `tolerance` of all. `sigmas`: `count` numbers, finite
/// and 0 or more, as many as there are markers; 0 stands for the tolerance. Other markers forget it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_set_marker_sigmas(
    problem: *mut MlgReshaping,
    sigmas: *const f64,
    count: usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        // SAFETY: the caller's promise (see the module).
        let sigmas = unsafe { buffers::sizes(sigmas, count, "sigmas")? };
        let mut problem = problem.lock();
        let markers = problem.markers.len();
        if count != markers {
            return Err(Failure::invalid(format!("{count} sigmas for {markers} markers")));
        }
        for (marker, sigma) in problem.markers.iter_mut().zip(sigmas) {
            marker.sigma = (sigma > 0.0).then_some(sigma);
        }
        Ok(())
    })
}

/// Sets the landmarks: template points with known targets. Replaces earlier ones.
///
/// `template_points` and `targets`: `3 * count` coordinates each, finite; the template points lie
/// on or in the template at rest. `weights`: `count` numbers, 0 or more, or NULL for 1 throughout.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_set_landmarks(
    problem: *mut MlgReshaping,
    template_points: *const f64,
    targets: *const f64,
    weights: *const f64,
    count: usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        // SAFETY: the caller's promise (see the module).
        let places = unsafe { at_points(template_points, count)? };
        // SAFETY: as above.
        problem.lock().landmarks = unsafe { pairs("landmark", places, targets, weights, count)? };
        Ok(())
    })
}

/// Like `mlg_reshaping_set_landmarks`, the template points being vertices of the surface:
/// `template_vertices` holds `count` indices from 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_set_landmarks_at_vertices(
    problem: *mut MlgReshaping,
    template_vertices: *const u32,
    targets: *const f64,
    weights: *const f64,
    count: usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        // SAFETY: the caller's promise (see the module).
        let places = unsafe { at_vertices(problem, template_vertices, count)? };
        // SAFETY: as above.
        problem.lock().landmarks = unsafe { pairs("landmark", places, targets, weights, count)? };
        Ok(())
    })
}

/// Makes landmarks pins: they end within a distance of their targets, whatever the markers say. `within`:
/// `count` lengths, as many as there are landmarks; 0: at the target itself; below 0: no pin, weighed
/// against the markers by the `landmark_tolerance`. Other landmarks forget it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_set_pins(
    problem: *mut MlgReshaping,
    within: *const f64,
    count: usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        // SAFETY: the caller's promise (see the module).
        let within = unsafe { buffers::numbers(within, count, "within")? };
        let mut problem = problem.lock();
        let landmarks = problem.landmarks.len();
        if count != landmarks {
            return Err(Failure::invalid(format!("{count} lengths for {landmarks} landmarks")));
        }
        for (landmark, within) in problem.landmarks.iter_mut().zip(within) {
            landmark.within = (within >= 0.0).then_some(within);
        }
        Ok(())
    })
}

/// Sets the attachments: template points that are held at their targets mechanically, such as the
/// places where a muscle grows on a bone. Replaces earlier ones. Arrays as for
/// `mlg_reshaping_set_landmarks`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_set_attachments(
    problem: *mut MlgReshaping,
    template_points: *const f64,
    targets: *const f64,
    weights: *const f64,
    count: usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        // SAFETY: the caller's promise (see the module).
        let places = unsafe { at_points(template_points, count)? };
        // SAFETY: as above.
        let attachments = unsafe { pairs("attachment", places, targets, weights, count)? };
        problem.lock().attachments = attachments;
        Ok(())
    })
}

/// Like `mlg_reshaping_set_attachments`, the template points being vertices of the surface:
/// `template_vertices` holds `count` indices from 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_set_attachments_at_vertices(
    problem: *mut MlgReshaping,
    template_vertices: *const u32,
    targets: *const f64,
    weights: *const f64,
    count: usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        // SAFETY: the caller's promise (see the module).
        let places = unsafe { at_vertices(problem, template_vertices, count)? };
        // SAFETY: as above.
        let attachments = unsafe { pairs("attachment", places, targets, weights, count)? };
        problem.lock().attachments = attachments;
        Ok(())
    })
}

/// Sets the vertices of the surface that stay where they are. Replaces earlier ones. `vertices`:
/// `count` indices from 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_set_fixed(
    problem: *mut MlgReshaping,
    vertices: *const u32,
    count: usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        // SAFETY: the caller's promise (see the module).
        let vertices = unsafe { checked_vertices(problem, vertices, count)? };
        problem.lock().fixed = vertices;
        Ok(())
    })
}

/// Frees a problem. NULL and handles freed already are allowed. Runs started from it go on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_free(problem: *mut MlgReshaping) {
    access::free::<ProblemObject, _>(problem);
}

unsafe fn at_points(points: *const f64, count: usize) -> Outcome<Vec<TemplatePoint>> {
    // SAFETY: passed on from the caller.
    let points = unsafe { buffers::points(points, count, "template_points")? };
    Ok(points.into_iter().map(TemplatePoint::Position).collect())
}

unsafe fn at_vertices(
    problem: &ProblemObject,
    vertices: *const u32,
    count: usize,
) -> Outcome<Vec<TemplatePoint>> {
    // SAFETY: passed on from the caller.
    let vertices = unsafe { checked_vertices(problem, vertices, count)? };
    Ok(vertices.into_iter().map(TemplatePoint::Vertex).collect())
}

unsafe fn checked_vertices(
    problem: &ProblemObject,
    vertices: *const u32,
    count: usize,
) -> Outcome<Vec<u32>> {
    // SAFETY: passed on from the caller.
    unsafe { vertices_of(&problem.lock().surface, vertices, count, "vertices") }
}

unsafe fn pairs(
    kind: &str,
    places: Vec<TemplatePoint>,
    targets: *const f64,
    weights: *const f64,
    count: usize,
) -> Outcome<Vec<Landmark>> {
    // SAFETY: passed on from the caller.
    let targets = unsafe { buffers::points(targets, count, "targets")? };
    // SAFETY: as above.
    let weights = unsafe { buffers::weights(weights, count)? };
    let pair = |(i, ((template, target), weight))| Landmark {
        label: format!("{kind} {i}"),
        template,
        target,
        weight,
        within: None,
    };
    Ok(places.into_iter().zip(targets).zip(weights).enumerate().map(pair).collect())
}
