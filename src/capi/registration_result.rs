//! What a registration gave.

use libc::c_char;
use std::sync::Arc;

use super::boundary::{MlgError, MlgStatus, guard, name_of};
use super::buffers::{self, Versioned};
use super::mesh::{MlgTriMesh, Surface};
use super::skeleton::{MlgSkeleton, SkeletonObject};
use super::{access, handles};
use crate::job::{result_document, settle_paths};
use crate::register::transfer::carry_soft_tissue;
use crate::register::{Registered, Verdict};

/// A registered skeleton. Immutable; may be read from many threads.
pub struct MlgRegistrationResult;

/// How far a result, or one bone of it, can be trusted.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MlgVerdict {
    /// Nothing speaks against it.
    Good = 0,
    /// It may be wrong: look at it.
    Doubtful = 1,
    /// It is wrong.
    Failed = 2,
}

/// The name of an `MlgVerdict`, e.g. "DOUBTFUL"; "UNKNOWN" for other numbers. Static, never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn mlg_verdict_name(verdict: u32) -> *const c_char {
    const NAMES: [&str; 3] = ["GOOD\0", "DOUBTFUL\0", "FAILED\0"];
    name_of(&NAMES, verdict)
}

fn number_of(verdict: Verdict) -> u32 {
    let number = match verdict {
        Verdict::Good => MlgVerdict::Good,
        Verdict::Doubtful => MlgVerdict::Doubtful,
        Verdict::Failed => MlgVerdict::Failed,
    };
    number as u32
}

/// The course of a registration. Lengths are in the template's unit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgRegistrationSummary {
    /// `sizeof` this struct in the caller's header; set by the caller.
    pub struct_size: usize,
    /// 1 if it was stopped on request before its end.
    pub cancelled: u32,
    /// Closest-point iterations.
    pub iterations: u32,
    /// Bones whose verdict is not good.
    pub suspicious_bones: u32,
    /// Joints outside their limits.
    pub joints_outside: u32,
    /// Mean of the bones' mean residuals.
    pub mean_residual: f64,
    /// Largest residual of any bone.
    pub max_residual: f64,
    /// Seconds it took.
    pub seconds: f64,
    /// How far the whole can be trusted: a number of `MlgVerdict`.
    pub verdict: u32,
    /// Bones whose verdict is `FAILED`.
    pub failed_bones: u32,
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgRegistrationSummary {}

/// How a bone fits. Lengths are in the template's unit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgBoneFit {
    /// `sizeof` this struct in the caller's header; set by the caller.
    pub struct_size: usize,
    /// Mean distance to the target, both ways.
    pub mean_residual: f64,
    /// Largest such distance.
    pub max_residual: f64,
    /// Share of the bone's area that lies on the target, 0 to 1.
    pub seen: f64,
    /// 1 if its verdict is not good.
    pub suspicious: u32,
    /// 0.
    pub reserved: u32,
    /// How far it can be trusted: a number of `MlgVerdict`.
    pub verdict: u32,
    /// Why it is not good: sentences of `mlg_registration_result_bone_reasons`.
    pub reason_count: u32,
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgBoneFit {}

/// How a joint stands. Lengths are in the template's unit, angles in radians.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgJointPose {
    /// `sizeof` this struct in the caller's header; set by the caller.
    pub struct_size: usize,
    /// Its centre.
    pub centre: [f64; 3],
    /// Rotation vector of the child's frame seen from the parent's.
    pub rotation: [f64; 3],
    /// Share of the allowed rotation that is used; 1: on the limit.
    pub usage: f64,
    /// Rotation beyond the limit.
    pub excess_rotation: f64,
    /// Distance of the two frames' origins.
    pub shift: f64,
    /// Shift beyond the limit.
    pub excess_shift: f64,
    /// Distance at which the data alone would leave the two bones' points of the joint.
    pub seam: f64,
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgJointPose {}

/// Beyond its limits by less than this a joint counts as inside: radians, share of a length unit.
const NUMERICALLY_INSIDE: f64 = 1e-5;

pub(super) struct RegistrationResult {
    template: Arc<SkeletonObject>,
    registered: Registered,
    seconds: f64,
}

impl RegistrationResult {
    pub fn new(template: Arc<SkeletonObject>, registered: Registered, seconds: f64) -> Self {
        Self { template, registered, seconds }
    }

    fn summary(&self) -> MlgRegistrationSummary {
        let (bones, joints) = (&self.registered.bones, &self.registered.joints);
        let outside = |j: &&crate::register::summary::JointSummary| {
            j.excess_degrees.to_radians() > NUMERICALLY_INSIDE
                || j.excess_shift > NUMERICALLY_INSIDE
        };
        MlgRegistrationSummary {
            struct_size: size_of::<MlgRegistrationSummary>(),
            cancelled: u32::from(self.registered.cancelled),
            iterations: self.registered.iterations() as u32,
            suspicious_bones: self.registered.named_bones() as u32,
            joints_outside: joints.iter().filter(outside).count() as u32,
            mean_residual: bones.iter().map(|b| b.mean_residual).sum::<f64>()
                / bones.len().max(1) as f64,
            max_residual: bones.iter().map(|b| b.max_residual).fold(0.0, f64::max),
            seconds: self.seconds,
            verdict: number_of(self.registered.judgement.verdict),
            failed_bones: bones.iter().filter(|b| b.verdict == Verdict::Failed).count() as u32,
        }
    }
}

/// The person's skeleton: bones in the template's vertex order, joint frames inside their limits or as
/// far beyond as these give way (`MlgLimits`). It is an object of its own and may be the template of
/// another registration. Free with `mlg_skeleton_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_result_skeleton(
    result: *const MlgRegistrationResult,
    out_skeleton: *mut *mut MlgSkeleton,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_skeleton, "out_skeleton"), error, || {
        let result = handles::get::<RegistrationResult, _>(result, "result")?;
        let mut document = result_document(&result.template.document, &result.registered);
        let mut skeleton = result.registered.skeleton.clone();
        let notes = settle_paths(&mut skeleton, &mut document);
        let surfaces = result.template.surfaces.clone();
        Ok(SkeletonObject::new(document, skeleton, surfaces, &notes))
    })
}

/// Tells how it went. `out_summary`: its `struct_size` must be set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_result_summary(
    result: *const MlgRegistrationResult,
    out_summary: *mut MlgRegistrationSummary,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill(
        (result, "result"),
        (out_summary, "out_summary"),
        error,
        |result: &RegistrationResult| Ok(result.summary()),
    )
}

/// Tells how a bone, a number from 0, fits. `out_fit`: its `struct_size` must be set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_result_bone_fit(
    result: *const MlgRegistrationResult,
    bone: usize,
    out_fit: *mut MlgBoneFit,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill((result, "result"), (out_fit, "out_fit"), error, |result: &RegistrationResult| {
        let found = buffers::entry(&result.registered.bones, bone, "bone")?;
        Ok(MlgBoneFit {
            struct_size: size_of::<MlgBoneFit>(),
            mean_residual: found.mean_residual,
            max_residual: found.max_residual,
            seen: found.seen,
            suspicious: u32::from(found.verdict > Verdict::Good),
            reserved: 0,
            verdict: number_of(found.verdict),
            reason_count: found.reasons.len() as u32,
        })
    })
}

/// Tells how a joint, a number from 0, stands to its limits. `out_pose`: its `struct_size` must be
/// set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_result_joint_pose(
    result: *const MlgRegistrationResult,
    joint: usize,
    out_pose: *mut MlgJointPose,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill(
        (result, "result"),
        (out_pose, "out_pose"),
        error,
        |result: &RegistrationResult| {
            let found = buffers::entry(&result.registered.joints, joint, "joint")?;
            Ok(MlgJointPose {
                struct_size: size_of::<MlgJointPose>(),
                centre: found.centre.into(),
                rotation: found.rotation.into(),
                usage: found.usage,
                excess_rotation: found.excess_degrees.to_radians(),
                shift: found.shift,
                excess_shift: found.excess_shift,
                seam: found.seam,
            })
        },
    )
}

/// The coefficients of the shape model, in standard deviations: `*out_count` numbers, borrowed until the
/// result is freed. NULL without a model or for a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_result_coefficients(
    result: *const MlgRegistrationResult,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(result, out_count, |result: &RegistrationResult| &result.registered.coefficients)
}

/// For each vertex of the skeleton, bone after bone, whether it lies on the target, 1 or 0; in an image, how
/// far it finds something like it, 0 to 1: `*out_count` numbers, borrowed until the result is freed. What is
/// not seen is a guess. NULL for a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_result_seen(
    result: *const MlgRegistrationResult,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(result, out_count, |result: &RegistrationResult| &result.registered.seen)
}

/// Carries a soft tissue surface along with the bones; takes seconds for large ones.
///
/// `tissue`: in the template's pose. `out_points`: room for 3 coordinates per point of it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_result_carry(
    result: *const MlgRegistrationResult,
    tissue: *const MlgTriMesh,
    out_points: *mut f64,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_points, "out_points")?;
        let result = handles::get::<RegistrationResult, _>(result, "result")?;
        let tissue = handles::get::<Surface, _>(tissue, "tissue")?;
        tissue.check_triangles("tissue")?;
        let bones = &result.registered.skeleton.points;
        let carried = carry_soft_tissue(&result.template.skeleton, bones, &tissue.mesh)?;
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::copy_points(&carried, out_points, carried.len()) }
    })
}

/// Writes why the verdict on a bone, a number from 0, is not good and what can be done about it, one
/// sentence per line, worst first, into `buffer`: UTF-8, zero-terminated, cut to `capacity` bytes; empty
/// for a good bone. `buffer` may be NULL if `capacity` is 0. `out_length`: bytes of the whole text
/// without the zero; may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_result_bone_reasons(
    result: *const MlgRegistrationResult,
    bone: usize,
    buffer: *mut c_char,
    capacity: usize,
    out_length: *mut usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((result, "result"), error, |result: &RegistrationResult| {
        let text = buffers::entry(&result.registered.bones, bone, "bone")?.reasons.join("\n");
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write_text(&text, buffer, capacity, out_length) }
    })
}

/// Writes what to look at, first why the verdict on the whole is not good, then the worst bones and
/// joints, one sentence per line, into `buffer`: UTF-8, zero-terminated, cut to
/// `capacity` bytes; empty if there is nothing. `buffer` may be NULL if `capacity` is 0.
/// `out_length`: bytes of the whole text without the zero; may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_result_warnings(
    result: *const MlgRegistrationResult,
    buffer: *mut c_char,
    capacity: usize,
    out_length: *mut usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((result, "result"), error, |result: &RegistrationResult| {
        let text = result.registered.warnings(&result.template.skeleton).join("\n");
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write_text(&text, buffer, capacity, out_length) }
    })
}

/// Frees a result. NULL and handles freed already are allowed. Objects made from it stay valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_result_free(result: *mut MlgRegistrationResult) {
    access::free::<RegistrationResult, _>(result);
}
