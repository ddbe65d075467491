//! Skeletons from arrays: bones and joints.

use libc::c_char;
use std::ffi::CString;
use std::path::PathBuf;
use std::ptr;
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};

use super::boundary::{Failure, MlgError, MlgStatus, Outcome, guard};
use super::buffers::{self, Versioned};
use super::mesh::{MlgTriMesh, Surface};
use super::{access, handles};
use crate::error::Result;
use crate::io::gltf::GltfScene;
use crate::io::skeleton::{BoneEntry, FORMAT, JointEntry, SkeletonDocument, VERSION};
use crate::job::skeleton_build::{build_skeleton, joint_entry};
use crate::job::{Tissue, metres_per_unit, scene};
use crate::math::Mat3;
use crate::register::animation::{Motion, present_angles};
use crate::register::{Joint, JointLimits, Skeleton};

/// Bones and the joints between them. Immutable; may be read from many threads.
pub struct MlgSkeleton;

/// Marks numbers that are to be chosen by the library.
const CHOSEN: f64 = -1.0;

/// A bone to make a skeleton of.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgBone {
    /// `sizeof` this struct in the caller's header.
    pub struct_size: usize,
    /// Its name, UTF-8, unique.
    pub name: *const c_char,
    /// Its surface; may be freed afterwards.
    pub surface: *const MlgTriMesh,
}

// SAFETY: repr(C), pointers, size first.
unsafe impl Versioned for MlgBone {}

/// A joint between two bones. Set with `mlg_joint_init`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgJoint {
    /// `sizeof` this struct in the caller's header.
    pub struct_size: usize,
    /// Its name, UTF-8, unique. As an answer: borrowed until the skeleton is freed.
    pub name: *const c_char,
    /// Number of the parent bone, from 0.
    pub parent: u32,
    /// Number of the child bone, from 0.
    pub child: u32,
    /// 1 (default), or 0 for a joint that only closes a loop.
    pub in_tree: u32,
    /// 1: the frames below are given. 0 (default): the joint is put in the middle of the narrowest
    /// gap between its bones, and the frames are not read.
    pub has_frames: u32,
    /// World from the joint's frame on the parent bone, in the skeleton's pose: a 4x4 matrix, row by
    /// row, without scale.
    pub world_from_parent_frame: [f64; 16],
    /// World from the joint's frame on the child bone; the same in the neutral position.
    pub world_from_child_frame: [f64; 16],
    /// Largest rotations in the negative sense about x, y and z of the frame: radians, 0 or more;
    /// INFINITY (default) leaves it free.
    pub negative_limits: [f64; 3],
    /// Largest rotations in the positive sense.
    pub positive_limits: [f64; 3],
    /// Largest distance of the two frames' origins, in the skeleton's unit. Below 0 (default): half a
    /// percent of the skeleton's diagonal.
    pub shift_limit: f64,
}

// SAFETY: repr(C), plain numbers and a pointer, size first.
unsafe impl Versioned for MlgJoint {}

const IDENTITY: [f64; 16] =
    [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

const JOINT_DEFAULTS: MlgJoint = MlgJoint {
    struct_size: size_of::<MlgJoint>(),
    name: ptr::null(),
    parent: 0,
    child: 0,
    in_tree: 1,
    has_frames: 0,
    world_from_parent_frame: IDENTITY,
    world_from_child_frame: IDENTITY,
    negative_limits: [f64::INFINITY; 3],
    positive_limits: [f64::INFINITY; 3],
    shift_limit: CHOSEN,
};

/// A skeleton with its files.
pub(super) struct SkeletonObject {
    pub document: SkeletonDocument,
    pub skeleton: Skeleton,
    /// Each bone as it was given; a result shares them with its template.
    pub surfaces: Vec<Arc<Surface>>,
    /// The soft tissues that its file names.
    pub tissues: Vec<Tissue>,
    /// The shape model that its file names.
    pub statistics: Option<PathBuf>,
    /// What was left out when it was read, one sentence per line.
    pub notes: CString,
    pub bone_names: Vec<CString>,
    pub joint_names: Vec<CString>,
    pub angle_names: Vec<CString>,
    pub angles: Vec<f64>,
}

impl SkeletonObject {
    pub fn new(
        document: SkeletonDocument,
        skeleton: Skeleton,
        surfaces: Vec<Arc<Surface>>,
        notes: &[String],
    ) -> Self {
        let (angle_names, angles) = present_angles(&skeleton)
            .into_iter()
            .map(|(name, a)| (buffers::c_text(&name), a))
            .unzip();
        Self {
            bone_names: skeleton.bones.iter().map(|b| buffers::c_text(&b.name)).collect(),
            joint_names: skeleton.joints.iter().map(|j| buffers::c_text(&j.name)).collect(),
            tissues: Vec::new(),
            statistics: None,
            notes: buffers::c_text(&notes.join("\n")),
            angle_names,
            angles,
            document,
            skeleton,
            surfaces,
        }
    }

    /// The skeleton with its soft tissues. `unit`: metres; what its file says where it is none.
    pub fn scene(&self, motion: Option<&Motion>, unit: Option<f64>) -> Result<GltfScene> {
        let unit = unit.unwrap_or(metres_per_unit(self.document.units.as_deref()));
        scene(&self.skeleton, &self.tissues, motion, unit)
    }
}

/// Writes the defaults of a joint. `struct_size`: `sizeof *out_joint`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_joint_init(out_joint: *mut MlgJoint, struct_size: usize) -> MlgStatus {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write_versioned(out_joint, struct_size, JOINT_DEFAULTS, "out_joint") }
    })
}

/// Makes a skeleton from arrays, which are copied. `bones`: `bone_count` elements, at least one.
/// `joints`: `joint_count` elements; may be NULL if that is 0. All elements of an array have the same
/// `struct_size`. Free with `mlg_skeleton_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_new(
    bones: *const MlgBone,
    bone_count: usize,
    joints: *const MlgJoint,
    joint_count: usize,
    out_skeleton: *mut *mut MlgSkeleton,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_skeleton, "out_skeleton"), error, || {
        let no_bone =
            MlgBone { struct_size: size_of::<MlgBone>(), name: ptr::null(), surface: ptr::null() };
        // SAFETY: the caller's promise (see the module).
        let bones = unsafe { buffers::structs(bones, bone_count, no_bone, "bones")? };
        // SAFETY: as above.
        let joints = unsafe { buffers::structs(joints, joint_count, JOINT_DEFAULTS, "joints")? };
        let mut document = SkeletonDocument {
            format: FORMAT.into(),
            version: VERSION,
            ..SkeletonDocument::default()
        };
        let mut surfaces = Vec::new();
        for bone in &bones {
            // SAFETY: as above.
            let name = unsafe { buffers::text(bone.name, "the name of a bone")? };
            surfaces.push(handles::get::<Surface, _>(bone.surface, "the surface of a bone")?);
            document.bones.push(BoneEntry { name, ..BoneEntry::default() });
        }
        for joint in &joints {
            // SAFETY: as above.
            let entry = unsafe { entry_of(joint, &document.bones)? };
            document.joints.push(entry);
        }
        let meshes = surfaces.iter().map(|s| s.mesh.clone()).collect();
        let skeleton = build_skeleton(&document, meshes)?;
        Ok(SkeletonObject::new(document, skeleton, surfaces, &[]))
    })
}

unsafe fn entry_of(joint: &MlgJoint, bones: &[BoneEntry]) -> Outcome<JointEntry> {
    // SAFETY: passed on from the caller.
    let name = unsafe { buffers::text(joint.name, "the name of a joint")? };
    let wrong = |what: &str| Failure::invalid(format!("joint {name}: {what}"));
    let bone = |number: u32| {
        bones.get(number as usize).map(|b| b.name.clone()).ok_or_else(|| {
            wrong(&format!(
                "there is no bone {number}; there are {} (numbered from 0)",
                bones.len()
            ))
        })
    };
    let limits = JointLimits::new(
        joint.negative_limits.into(),
        joint.positive_limits.into(),
        joint.shift_limit.max(0.0),
    )
    .map_err(|e| wrong(&e.to_string()))?;
    let frame = |matrix: &[f64; 16]| {
        frame_of(matrix).ok_or_else(|| {
            wrong("its frames must be 4x4 matrices of a rotation and a translation, row by row, without scale")
        })
    };
    let has_frames = buffers::switch(joint.has_frames, "has_frames")?;
    let frames = if has_frames {
        [frame(&joint.world_from_parent_frame)?, frame(&joint.world_from_child_frame)?]
    } else {
        [Isometry3::identity(); 2]
    };
    let full = Joint {
        name: name.clone(),
        parent: joint.parent as usize,
        child: joint.child as usize,
        parent_frame: frames[0],
        child_frame: frames[1],
        limits,
        in_tree: buffers::switch(joint.in_tree, "in_tree")?,
        coordinates: Vec::new(),
        path: None,
    };
    let mut entry = joint_entry([bone(joint.parent)?, bone(joint.child)?], &full);
    if !has_frames {
        (entry.parent_frame, entry.child_frame) = (None, None);
    }
    if joint.shift_limit < 0.0 {
        entry.limits.shift = None;
    }
    Ok(entry)
}

/// How far the axes of a frame may be from unit length and right angles: single precision.
const SKEW: f64 = 1e-5;

fn frame_of(matrix: &[f64; 16]) -> Option<Isometry3<f64>> {
    let rows = Mat3::from_fn(|r, c| matrix[4 * r + c]);
    let skew = (rows * rows.transpose() - Mat3::identity()).abs().max();
    let is_frame = skew < SKEW
        && rows.determinant() > 0.0
        && matrix[12..] == IDENTITY[12..]
        && matrix.iter().all(|x| x.is_finite());
    let rotation =
        || Rotation3::from_matrix_eps(&Matrix3::from(rows), 1e-15, 100, Rotation3::identity());
    is_frame.then(|| {
        Isometry3::from_parts(
            Translation3::new(matrix[3], matrix[7], matrix[11]),
            UnitQuaternion::from_rotation_matrix(&rotation()),
        )
    })
}

pub(super) fn matrix_of(frame: &Isometry3<f64>) -> [f64; 16] {
    buffers::rows_of(&frame.to_homogeneous())
}

/// Frees a skeleton. NULL and handles freed already are allowed. Objects made from it stay valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_free(skeleton: *mut MlgSkeleton) {
    access::free::<SkeletonObject, _>(skeleton);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_survive_and_scaled_or_mirrored_ones_are_refused() {
        let turn = UnitQuaternion::from_euler_angles(0.3, -1.2, 2.0);
        let frame = Isometry3::from_parts(Translation3::new(1.0, 2.0, 3.0), turn);
        let matrix = matrix_of(&frame);
        let again = frame_of(&matrix).unwrap();
        assert!((again.to_homogeneous() - frame.to_homogeneous()).norm() < 1e-12);
        let mut scaled = matrix;
        scaled[..3].iter_mut().for_each(|x| *x *= 1.01);
        assert!(frame_of(&scaled).is_none());
        let mut mirrored = matrix;
        mirrored[..3].iter_mut().for_each(|x| *x = -*x);
        assert!(frame_of(&mirrored).is_none());
        let mut undefined = matrix;
        undefined[7] = f64::NAN;
        assert!(frame_of(&undefined).is_none());
    }
}
