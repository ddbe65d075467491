//! Findings: what is suspicious before a reshaping is run, and what mends it.

use std::ffi::CString;
use std::ptr;

use libc::c_char;
use nalgebra::Matrix4;

use super::boundary::{MlgError, MlgStatus, guard, name_of};
use super::buffers::{self, Versioned};
use super::mesh::{MlgTriMesh, Surface, vertices_of};
use super::pairs::{self, MlgPairs};
use super::reshaping::{MlgReshaping, ProblemObject};
use super::{access, handles};
use crate::math::Vec3;
use crate::reshape::{
    Concern, Data, Finding, Landmark, Pair, Remedy, Severity, inspect, inspect_data,
};

/// What is suspicious about a template and its data. Immutable; may be read from many threads.
pub struct MlgFindings;

/// What a finding is about.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MlgConcern {
    /// Too few points.
    Amount = 0,
    /// The template's surface: holes, flipped triangles.
    Surface = 1,
    /// Template and person are in two units.
    Unit = 2,
    /// One is in LPS, the other in RAS.
    Frame = 3,
    /// Y is up in one, Z in the other.
    UpAxis = 4,
    /// The template lies somewhere else.
    Place = 5,
    /// The template is of the other side of the body.
    Side = 6,
    /// Two landmarks have each other's targets.
    Exchange = 7,
    /// Landmarks or attachments are not on the template, or contradict each other.
    Landmarks = 8,
    /// The attachments do not hold the body.
    Attachments = 9,
}

/// What becomes of a run all the same.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MlgSeverity {
    /// A good result, perhaps less than could be.
    Note = 0,
    /// Probably nonsense.
    Doubtful = 1,
    /// Nonsense: the command line refuses to begin.
    Refused = 2,
}

/// A finding. Lengths are in the template's unit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgFinding {
    /// `sizeof` this struct in the caller's header; set by the caller.
    pub struct_size: usize,
    /// A number of `MlgConcern`.
    pub concern: u32,
    /// A number of `MlgSeverity`.
    pub severity: u32,
    /// How far the person's points are from the template on average; NAN where that is not the matter.
    pub distance: f64,
    /// How far they are once it is mended; NAN where that is not known.
    pub mended_distance: f64,
    /// 1 if `motion` mends it.
    pub has_motion: u32,
    /// 1 if swapping the targets of the landmarks `first` and `second` mends it.
    pub has_exchange: u32,
    /// A landmark, by its number from 0.
    pub first: u32,
    /// The other one.
    pub second: u32,
    /// Where to move the template: a 4x4 matrix, row by row, for points as columns. A mirror image
    /// where its determinant is below 0. The identity if `has_motion` is 0.
    pub motion: [f64; 16],
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgFinding {}

struct Findings {
    list: Vec<Finding>,
    texts: Vec<CString>,
}

/// The name of an `MlgConcern`, e.g. "UP_AXIS"; "UNKNOWN" for other numbers. Static, never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn mlg_concern_name(concern: u32) -> *const c_char {
    const NAMES: [&str; 10] = [
        "AMOUNT\0",
        "SURFACE\0",
        "UNIT\0",
        "FRAME\0",
        "UP_AXIS\0",
        "PLACE\0",
        "SIDE\0",
        "EXCHANGE\0",
        "LANDMARKS\0",
        "ATTACHMENTS\0",
    ];
    name_of(&NAMES, concern)
}

/// The name of an `MlgSeverity`, e.g. "DOUBTFUL"; "UNKNOWN" for other numbers. Static, never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn mlg_severity_name(severity: u32) -> *const c_char {
    const NAMES: [&str; 3] = ["NOTE\0", "DOUBTFUL\0", "REFUSED\0"];
    name_of(&NAMES, severity)
}

fn concern(concern: Concern) -> MlgConcern {
    match concern {
        Concern::Amount => MlgConcern::Amount,
        Concern::Surface => MlgConcern::Surface,
        Concern::Unit => MlgConcern::Unit,
        Concern::Frame => MlgConcern::Frame,
        Concern::UpAxis => MlgConcern::UpAxis,
        Concern::Place => MlgConcern::Place,
        Concern::Side => MlgConcern::Side,
        Concern::Exchange => MlgConcern::Exchange,
        Concern::Landmarks => MlgConcern::Landmarks,
        Concern::Attachments => MlgConcern::Attachments,
    }
}

fn severity(severity: Severity) -> MlgSeverity {
    match severity {
        Severity::Note => MlgSeverity::Note,
        Severity::Doubtful => MlgSeverity::Doubtful,
        Severity::Refused => MlgSeverity::Refused,
    }
}

/// Checks a problem's template, markers and pairs against each other, as the command line does before
/// it starts: other units, another frame, contradictory landmarks, holes. What cannot work is an
/// error. What may be a mistake is written into `buffer`, one sentence per line: UTF-8,
/// zero-terminated, cut to `capacity` bytes. `buffer` may be NULL if `capacity` is 0. `out_length`:
/// bytes of the whole text without the zero; may be NULL. `mlg_tri_mesh_inspect` tells more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_check(
    problem: *const MlgReshaping,
    buffer: *mut c_char,
    capacity: usize,
    out_length: *mut usize,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        let problem = handles::get::<ProblemObject, _>(problem, "problem")?.lock().clone();
        let markers: Vec<Vec3> =
            problem.markers.iter().filter(|m| m.weight > 0.0).map(|m| m.position).collect();
        let pairs = |list: &[Landmark]| -> Vec<Pair> {
            list.iter().map(|l| Pair::of(l, &problem.surface)).collect()
        };
        let data = Data {
            surface: (&problem.surface, "the template"),
            markers: &markers,
            landmarks: &pairs(&problem.landmarks),
            attachments: &pairs(&problem.attachments),
            fixed: &problem.fixed,
        };
        let text = inspect_data(&data, None)?.join("\n");
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write_text(&text, buffer, capacity, out_length) }
    })
}

/// Looks at a template and what it is to follow before any tets are made: units, frames, up axes, place,
/// side, exchanged or contradictory landmarks, holes. It is no error that something is found.
///
/// `markers`: `3 * marker_count` coordinates; those that count. `landmarks`, `attachments`: NULL for none.
/// `fixed`: `fixed_count` vertices. Free with `mlg_findings_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_tri_mesh_inspect(
    template_surface: *const MlgTriMesh,
    markers: *const f64,
    marker_count: usize,
    landmarks: *const MlgPairs,
    attachments: *const MlgPairs,
    fixed: *const u32,
    fixed_count: usize,
    out_findings: *mut *mut MlgFindings,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_findings, "out_findings"), error, || {
        let surface = handles::get::<Surface, _>(template_surface, "template_surface")?;
        surface.check_triangles("template_surface")?;
        // SAFETY: the caller's promise (see the module).
        let markers = unsafe { buffers::points(markers, marker_count, "markers")? };
        // SAFETY: as above.
        let fixed = unsafe { vertices_of(&surface.mesh, fixed, fixed_count, "fixed")? };
        let data = Data {
            surface: (&surface.mesh, "the template"),
            markers: &markers,
            landmarks: &pairs::list_or_none(landmarks, "landmarks")?,
            attachments: &pairs::list_or_none(attachments, "attachments")?,
            fixed: &fixed,
        };
        let list = inspect(&data, None);
        let texts = list.iter().map(|finding| buffers::c_text(&finding.text)).collect();
        Ok(Findings { list, texts })
    })
}

/// How many findings there are; 0 for a handle that is not valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_findings_count(findings: *const MlgFindings) -> usize {
    access::read_or(0, findings, |findings: &Findings| findings.list.len())
}

/// Tells a finding, a number from 0. `out_finding`: its `struct_size` must be set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_findings_get(
    findings: *const MlgFindings,
    index: usize,
    out_finding: *mut MlgFinding,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill(
        (findings, "findings"),
        (out_finding, "out_finding"),
        error,
        |findings: &Findings| {
            let found = buffers::entry(&findings.list, index, "index")?;
            let (motion, exchange) = match found.remedy {
                Some(Remedy::Move(motion)) => (Some(motion), None),
                Some(Remedy::Exchange(first, second)) => (None, Some([first, second])),
                None => (None, None),
            };
            let [first, second] = exchange.unwrap_or_default().map(|number| number as u32);
            Ok(MlgFinding {
                struct_size: size_of::<MlgFinding>(),
                concern: concern(found.concern) as u32,
                severity: severity(found.severity) as u32,
                distance: found.distance.unwrap_or(f64::NAN),
                mended_distance: found.mended_distance.unwrap_or(f64::NAN),
                has_motion: u32::from(motion.is_some()),
                has_exchange: u32::from(exchange.is_some()),
                first,
                second,
                motion: buffers::rows_of(&motion.unwrap_or_else(Matrix4::identity)),
            })
        },
    )
}

/// What is wrong, and what can be done: one sentence, borrowed until the findings are freed; NULL if there
/// is no such finding.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_findings_text(
    findings: *const MlgFindings,
    index: usize,
) -> *const c_char {
    access::read_or(ptr::null(), findings, |findings: &Findings| {
        findings.texts.get(index).map_or(ptr::null(), |text| text.as_ptr())
    })
}

/// Frees findings; NULL is fine.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_findings_free(findings: *mut MlgFindings) {
    access::free::<Findings, _>(findings);
}
