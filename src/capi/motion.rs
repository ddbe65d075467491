//! Motions of skeletons: angles of their joints over time.

use libc::c_char;
use std::ffi::CString;
use std::ptr;
use std::sync::Arc;

use super::boundary::{Failure, MlgError, MlgStatus, Outcome};
use super::skeleton::{MlgSkeleton, SkeletonObject};
use super::{access, buffers, handles};
use crate::error::Shown;
use crate::io::gltf::write_glb;
use crate::io::has_extension;
use crate::job::{read_motion, write_motion_file};
use crate::register::animation::{Motion, unknown_angles};

/// Named angles over time, and the skeleton that they move. Immutable; may be read from many threads.
pub struct MlgMotion;

struct MotionObject {
    skeleton: Arc<SkeletonObject>,
    motion: Motion,
    names: Vec<CString>,
    /// The angles of one frame after the other.
    angles: Vec<f64>,
    notes: CString,
}

impl MotionObject {
    fn new(skeleton: Arc<SkeletonObject>, motion: Motion) -> Self {
        Self {
            names: motion.names.iter().map(|n| buffers::c_text(n)).collect(),
            angles: motion.frames.concat(),
            notes: buffers::c_text(
                &unknown_angles(&skeleton.skeleton, &motion).unwrap_or_default(),
            ),
            skeleton,
            motion,
        }
    }
}

/// Makes a motion from arrays, which are copied.
///
/// `names`: `angle_count` names of angles, UTF-8, as `mlg_skeleton_angle_name` tells them. `times`:
/// `frame_count` seconds, rising. `angles`: `frame_count * angle_count` radians, one frame after the
/// other. None may be NULL unless its count is 0. Free with `mlg_motion_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_motion_new(
    skeleton: *const MlgSkeleton,
    names: *const *const c_char,
    angle_count: usize,
    times: *const f64,
    angles: *const f64,
    frame_count: usize,
    out_motion: *mut *mut MlgMotion,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_motion, "out_motion"), error, || {
        let skeleton = handles::get::<SkeletonObject, _>(skeleton, "skeleton")?;
        if names.is_null() && angle_count > 0 {
            return Err(Failure::null("names"));
        }
        // SAFETY: the caller's promise (see the module).
        let names = unsafe { buffers::texts(names, angle_count, "names")? };
        let names: Option<Vec<String>> = names.into_iter().collect();
        let names = names.ok_or_else(|| Failure::null("a name"))?;
        // SAFETY: as above.
        let times = unsafe { buffers::numbers(times, frame_count, "times")? };
        let count = frame_count.saturating_mul(angle_count);
        // SAFETY: as above.
        let angles = unsafe { buffers::numbers(angles, count, "angles")? };
        check(&names, &times, &angles)?;
        let frames = (0..frame_count)
            .map(|k| angles[k * angle_count..(k + 1) * angle_count].to_vec())
            .collect();
        let motion = MotionObject::new(skeleton, Motion { names, times, frames });
        Ok(motion)
    })
}

fn check(names: &[String], times: &[f64], angles: &[f64]) -> Outcome<()> {
    if let Some(k) = (1..names.len()).find(|&k| names[..k].contains(&names[k])) {
        return Err(Failure::invalid(format!("names: there is a second '{}'", names[k])));
    }
    if let Some(k) =
        (0..times.len()).find(|&k| !times[k].is_finite() || (k > 0 && times[k] <= times[k - 1]))
    {
        return Err(Failure::invalid(format!(
            "times: number {k} is {}; times are finite and rise",
            times[k]
        )));
    }
    match angles.iter().position(|a| !a.is_finite()) {
        Some(k) => Err(Failure::invalid(format!(
            "angles: frame {}, '{}' is {}; angles are finite",
            k / names.len(),
            names[k % names.len()],
            angles[k]
        ))),
        None => Ok(()),
    }
}

/// Reads a motion: OpenSim's `.mot` or `.sto`, or `.bvh` whose nodes are named as the bones.
///
/// `flipped`: `flipped_count` names of angles whose sign is the opposite of the skeleton's; may be NULL
/// if that is 0. `path`: UTF-8. Free with `mlg_motion_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_motion_load(
    skeleton: *const MlgSkeleton,
    path: *const c_char,
    flipped: *const *const c_char,
    flipped_count: usize,
    out_motion: *mut *mut MlgMotion,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_motion, "out_motion"), error, || {
        let skeleton = handles::get::<SkeletonObject, _>(skeleton, "skeleton")?;
        // SAFETY: the caller's promise (see the module).
        let path = unsafe { buffers::path(path, "path")? };
        // SAFETY: as above.
        let flipped = unsafe { buffers::texts(flipped, flipped_count, "flipped")? };
        let flipped: Vec<String> = flipped.into_iter().flatten().collect();
        let motion = read_motion(&path, &skeleton.skeleton, &flipped)?;
        let motion = MotionObject::new(skeleton, motion);
        Ok(motion)
    })
}

/// Writes a motion: `.mot` for OpenSim, `.bvh` with the bones as a tree, or `.glb`: a scene of the
/// skeleton that moves. `path`: UTF-8.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_motion_save(
    motion: *const MlgMotion,
    path: *const c_char,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((motion, "motion"), error, |object: &MotionObject| {
        // SAFETY: the caller's promise (see the module).
        let path = unsafe { buffers::new_path(path, "path")? };
        if has_extension(&path, "glb") {
            return Ok(write_glb(&path, &object.skeleton.scene(Some(&object.motion), None)?)?);
        }
        if has_extension(&path, "mot") || has_extension(&path, "bvh") {
            return Ok(write_motion_file(&path, &object.skeleton.skeleton, &object.motion)?);
        }
        Err(Failure {
            status: MlgStatus::Unsupported,
            message: format!("{}: motions are written as .mot, .bvh or .glb", path.shown()),
        })
    })
}

/// The times of the frames: `*out_count` seconds, borrowed until the motion is freed. NULL without
/// frames or for a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_motion_times(
    motion: *const MlgMotion,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(motion, out_count, |motion: &MotionObject| &motion.motion.times)
}

/// The angles, one frame after the other, in the order of their names: `*out_count` numbers in all,
/// radians (columns whose names end in `_tx`, `_ty` or `_tz`: lengths as in the file), borrowed until
/// the motion is freed. NULL without any or for a handle that is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_motion_angles(
    motion: *const MlgMotion,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(motion, out_count, |motion: &MotionObject| &motion.angles)
}

/// The name of an angle: UTF-8, borrowed until the motion is freed. NULL if there is no angle of that
/// number, from 0, or the handle is not valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_motion_angle_name(
    motion: *const MlgMotion,
    angle: usize,
) -> *const c_char {
    access::read_or(ptr::null(), motion, |motion: &MotionObject| {
        motion.names.get(angle).map_or(ptr::null(), |n| n.as_ptr())
    })
}

/// What of the motion the skeleton does not know, in a sentence: UTF-8, borrowed until the motion is
/// freed; empty if it knows all. NULL for a handle that is not valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_motion_notes(motion: *const MlgMotion) -> *const c_char {
    access::read_or(ptr::null(), motion, |motion: &MotionObject| motion.notes.as_ptr())
}

/// Frees a motion. NULL and handles freed already are allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_motion_free(motion: *mut MlgMotion) {
    access::free::<MotionObject, _>(motion);
}
