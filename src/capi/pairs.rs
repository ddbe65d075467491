//! Landmarks and attachments: places on a template and their targets, from files or bones.

use libc::c_char;
use std::ffi::CString;
use std::path::PathBuf;
use std::ptr;

use super::boundary::{Failure, MlgError, MlgStatus, Outcome, guard};
use super::mesh::{MlgTriMesh, Surface, vertices_of};
use super::reshaping::{MlgReshaping, ProblemObject};
use super::{access, buffers, handles};
use crate::job::{Gap, read_attachment_pairs, read_fixed_vertices, read_landmark_pairs};
use crate::math::Vec3;
use crate::reshape::{Landmark, Pair, TemplatePoint, attach_to_bone, attach_vertices};

/// Places on a template with their targets: landmarks or attachments. Immutable; may be read from
/// many threads.
pub struct MlgPairs;

/// Vertex of a pair whose place is no vertex of the template.
pub const MLG_NO_VERTEX: u32 = u32::MAX;

struct Pairs {
    list: Vec<Pair>,
    places: Vec<Vec3>,
    vertices: Vec<u32>,
    targets: Vec<Vec3>,
    weights: Vec<f64>,
    within: Vec<f64>,
    labels: Vec<CString>,
    warning: Option<CString>,
}

impl Pairs {
    fn new(pairs: Vec<Pair>, warning: Option<String>) -> Self {
        Self {
            places: pairs.iter().map(|p| p.position).collect(),
            vertices: pairs.iter().map(|p| p.vertex.unwrap_or(MLG_NO_VERTEX)).collect(),
            targets: pairs.iter().map(|p| p.target).collect(),
            weights: pairs.iter().map(|p| p.weight).collect(),
            within: pairs.iter().map(|p| p.within.unwrap_or(-1.0)).collect(),
            labels: pairs.iter().map(|p| buffers::c_text(&p.label)).collect(),
            warning: warning.and_then(|w| CString::new(w).ok()),
            list: pairs,
        }
    }

    fn landmarks(&self) -> Vec<Landmark> {
        self.list.iter().map(Pair::landmark).collect()
    }
}

/// Makes pairs of template points and targets, `3 * count` coordinates each. `weights`: `count` numbers, 0
/// or more, or NULL for 1 throughout. `labels`: `count` strings, any of them NULL, or NULL for none;
/// a pair without one is called by its number. Free with `mlg_pairs_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_pairs_new(
    template_points: *const f64,
    targets: *const f64,
    weights: *const f64,
    labels: *const *const c_char,
    count: usize,
    out_pairs: *mut *mut MlgPairs,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_pairs, "out_pairs"), error, || {
        // SAFETY: the caller's promise (see the module).
        let places = unsafe { buffers::points(template_points, count, "template_points")? };
        // SAFETY: as above.
        let targets = unsafe { buffers::points(targets, count, "targets")? };
        // SAFETY: as above.
        let weights = unsafe { buffers::weights(weights, count)? };
        // SAFETY: as above.
        let labels = unsafe { buffers::texts(labels, count, "labels")? };
        let pair = |(i, position): (usize, Vec3)| Pair {
            label: labels[i].clone().unwrap_or_else(|| i.to_string()),
            position,
            vertex: None,
            target: targets[i],
            weight: weights[i],
            within: None,
        };
        Ok(Pairs::new(places.into_iter().enumerate().map(pair).collect(), None))
    })
}

/// The pairs of a handle; none for NULL.
pub(super) fn list_or_none(pairs: *const MlgPairs, name: &str) -> Outcome<Vec<Pair>> {
    if pairs.is_null() {
        return Ok(Vec::new());
    }
    Ok(handles::get::<Pairs, _>(pairs, name)?.list.clone())
}

/// Reads landmarks. `path`: a CSV file with `template_x,template_y,template_z` or `vertex`, and
/// `target_x,target_y,target_z`, and where they are there `label`, `weight`, `within`; or a marker file with points on the template, if `person_path` is
/// the marker file with the same labels on the person (else NULL). `template_surface`: where the
/// places are looked up. Free with `mlg_pairs_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_pairs_load_landmarks(
    template_surface: *const MlgTriMesh,
    path: *const c_char,
    person_path: *const c_char,
    out_pairs: *mut *mut MlgPairs,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_pairs, "out_pairs"), error, || {
        let surface = handles::get::<Surface, _>(template_surface, "template_surface")?;
        // SAFETY: the caller's promise (see the module).
        let mut files: Vec<PathBuf> = vec![unsafe { buffers::path(path, "path")? }];
        if !person_path.is_null() {
            // SAFETY: as above.
            files.push(unsafe { buffers::path(person_path, "person_path")? });
        }
        let (pairs, warning) = read_landmark_pairs(&files, &surface.mesh)?;
        Ok(Pairs::new(pairs, warning))
    })
}

/// Reads attachments from a CSV file: the template's place (`template_x`, ... or `vertex`), its
/// target (`target_x`, ...), and where they are there the template's bone point
/// (`template_bone_x`, ...), `label` and `weight`. `keep_gap`: 1 to keep the template's distance
/// between muscle and bone, turned as the bone is; 0 to go to the target itself. Free with
/// `mlg_pairs_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_pairs_load_attachments(
    template_surface: *const MlgTriMesh,
    path: *const c_char,
    keep_gap: u32,
    out_pairs: *mut *mut MlgPairs,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_pairs, "out_pairs"), error, || {
        let surface = handles::get::<Surface, _>(template_surface, "template_surface")?;
        let gap = if buffers::switch(keep_gap, "keep_gap")? { Gap::Keep } else { Gap::Close };
        // SAFETY: the caller's promise (see the module).
        let path = unsafe { buffers::path(path, "path")? };
        let pairs = Pairs::new(read_attachment_pairs(&path, &surface.mesh, gap)?, None);
        Ok(pairs)
    })
}

/// Attaches a template to a bone: each vertex of the bone within `distance` of the template holds
/// the template's point nearest to it, at the distance it has there. `bone`: the bone beside the
/// template at rest. `person_bone`: the same vertices where the person has them (`bone` itself if it
/// stays). Free with `mlg_pairs_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_pairs_from_bone(
    template_surface: *const MlgTriMesh,
    bone: *const MlgTriMesh,
    person_bone: *const MlgTriMesh,
    distance: f64,
    out_pairs: *mut *mut MlgPairs,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_pairs, "out_pairs"), error, || {
        let surface = handles::get::<Surface, _>(template_surface, "template_surface")?;
        surface.check_triangles("template_surface")?;
        let rest = handles::get::<Surface, _>(bone, "bone")?;
        let person = handles::get::<Surface, _>(person_bone, "person_bone")?;
        if !(distance > 0.0 && distance.is_finite()) {
            return Err(Failure::invalid(format!("distance is {distance}; it must be above 0")));
        }
        let (rest, person) = (&rest.mesh.points, &person.mesh.points);
        let pairs = attach_to_bone("bone", rest, person, &surface.mesh, distance)?;
        Ok(Pairs::new(pairs, None))
    })
}

/// Attaches chosen vertices of a template to a bone: each holds at the bone's vertex nearest to it, at the distance
/// it has there. `vertices`: `count` indices of the template. `bone` and `person_bone` as in
/// `mlg_pairs_from_bone`. Free with `mlg_pairs_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_pairs_from_vertices(
    template_surface: *const MlgTriMesh,
    vertices: *const u32,
    count: usize,
    bone: *const MlgTriMesh,
    person_bone: *const MlgTriMesh,
    out_pairs: *mut *mut MlgPairs,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_pairs, "out_pairs"), error, || {
        let surface = handles::get::<Surface, _>(template_surface, "template_surface")?;
        // SAFETY: the caller's promise (see the module).
        let vertices = unsafe { vertices_of(&surface.mesh, vertices, count, "vertices")? };
        let rest = handles::get::<Surface, _>(bone, "bone")?;
        let person = handles::get::<Surface, _>(person_bone, "person_bone")?;
        let (rest, person) = (&rest.mesh.points, &person.mesh.points);
        Ok(Pairs::new(attach_vertices("bone", &vertices, rest, person, &surface.mesh)?, None))
    })
}

/// The places on the template: `3 * *out_count` coordinates, borrowed until the pairs are freed.
/// NULL for a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_pairs_template_points(
    pairs: *const MlgPairs,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(pairs, out_count, |pairs: &Pairs| &pairs.places)
}

/// The template's vertices: `*out_count` indices, `MLG_NO_VERTEX` where the file names none;
/// borrowed until the pairs are freed. NULL for a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_pairs_template_vertices(
    pairs: *const MlgPairs,
    out_count: *mut usize,
) -> *const u32 {
    access::lend(pairs, out_count, |pairs: &Pairs| &pairs.vertices)
}

/// The targets: `3 * *out_count` coordinates, borrowed until the pairs are freed. NULL for a handle
/// that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_pairs_targets(
    pairs: *const MlgPairs,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(pairs, out_count, |pairs: &Pairs| &pairs.targets)
}

/// The weights: `*out_count` numbers, borrowed until the pairs are freed. NULL for a handle that is
/// not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_pairs_weights(
    pairs: *const MlgPairs,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(pairs, out_count, |pairs: &Pairs| &pairs.weights)
}

/// How far each landmark that is a pin may end from its target, below 0 for those that are none:
/// `*out_count` numbers, borrowed until the pairs are freed. NULL for a handle that is not valid.
/// `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_pairs_within(
    pairs: *const MlgPairs,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(pairs, out_count, |pairs: &Pairs| &pairs.within)
}

/// The name of one pair: UTF-8, borrowed until the pairs are freed. NULL if `index` is not below the
/// count or the handle is not valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_pairs_label(pairs: *const MlgPairs, index: usize) -> *const c_char {
    access::read_or(ptr::null(), pairs, |pairs: &Pairs| {
        pairs.labels.get(index).map_or(ptr::null(), |l| l.as_ptr())
    })
}

/// What was left out, such as labels that only one file has: a sentence in UTF-8, borrowed until the
/// pairs are freed; NULL if nothing was.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_pairs_warning(pairs: *const MlgPairs) -> *const c_char {
    access::read_or(ptr::null(), pairs, |pairs: &Pairs| {
        pairs.warning.as_ref().map_or(ptr::null(), |w| w.as_ptr())
    })
}

/// Frees pairs. NULL and handles freed already are allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_pairs_free(pairs: *mut MlgPairs) {
    access::free::<Pairs, _>(pairs);
}

/// Sets the landmarks of a problem; replaces earlier ones. Like `mlg_reshaping_set_landmarks`, with
/// the names and vertices that `pairs` has.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_set_landmark_pairs(
    problem: *mut MlgReshaping,
    pairs: *const MlgPairs,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        let (problem, landmarks) = problem_and_pairs(problem, pairs)?;
        problem.lock().landmarks = landmarks;
        Ok(())
    })
}

/// Sets the attachments of a problem; replaces earlier ones. Like `mlg_reshaping_set_attachments`,
/// with the names and vertices that `pairs` has.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_set_attachment_pairs(
    problem: *mut MlgReshaping,
    pairs: *const MlgPairs,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        let (problem, attachments) = problem_and_pairs(problem, pairs)?;
        problem.lock().attachments = attachments;
        Ok(())
    })
}

/// Sets the vertices that stay from a CSV file with `vertex`, or `x,y,z`, or both; replaces earlier
/// ones. `path`: UTF-8.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_load_fixed(
    problem: *mut MlgReshaping,
    path: *const c_char,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        // SAFETY: the caller's promise (see the module).
        let path = unsafe { buffers::path(path, "path")? };
        let mut problem = problem.lock();
        problem.fixed = read_fixed_vertices(&path, &problem.surface)?;
        Ok(())
    })
}

type ProblemAndPairs = (std::sync::Arc<ProblemObject>, Vec<Landmark>);

fn problem_and_pairs(
    problem: *mut MlgReshaping,
    pairs: *const MlgPairs,
) -> Outcome<ProblemAndPairs> {
    let problem = handles::get::<ProblemObject, _>(problem, "problem")?;
    let landmarks = handles::get::<Pairs, _>(pairs, "pairs")?.landmarks();
    let known = problem.lock().surface.points.len();
    let beyond =
        |l: &&Landmark| matches!(l.template, TemplatePoint::Vertex(v) if v as usize >= known);
    match landmarks.iter().find(beyond) {
        Some(l) => Err(Failure::invalid(format!(
            "pairs: '{}' names a vertex that this template does not have; read them for this template",
            l.label
        ))),
        None => Ok((problem, landmarks)),
    }
}
