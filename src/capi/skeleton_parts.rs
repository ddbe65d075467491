//! What is in a skeleton: names, surfaces, joints, angles.

use libc::c_char;
use std::ptr;

use super::access;
use super::boundary::{Failure, MlgError, MlgStatus};
use super::skeleton::{MlgJoint, MlgSkeleton, SkeletonObject, matrix_of};
use crate::math::Vec3;

/// Number of bones; 0 for a handle that is not valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_bone_count(skeleton: *const MlgSkeleton) -> usize {
    access::read_or(0, skeleton, |skeleton: &SkeletonObject| skeleton.skeleton.bones.len())
}

/// Number of joints; 0 for a handle that is not valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_joint_count(skeleton: *const MlgSkeleton) -> usize {
    access::read_or(0, skeleton, |skeleton: &SkeletonObject| skeleton.skeleton.joints.len())
}

/// The name of a bone: UTF-8, borrowed until the skeleton is freed. NULL if `bone` is not below the
/// count or the handle is not valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_bone_name(
    skeleton: *const MlgSkeleton,
    bone: usize,
) -> *const c_char {
    access::read_or(ptr::null(), skeleton, |object: &SkeletonObject| {
        object.bone_names.get(bone).map_or(ptr::null(), |n| n.as_ptr())
    })
}

/// The points of a bone: `3 * *out_count` coordinates, borrowed until the skeleton is freed. NULL if
/// `bone` is not below the count or the handle is not valid. `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_bone_points(
    skeleton: *const MlgSkeleton,
    bone: usize,
    out_count: *mut usize,
) -> *const f64 {
    access::lend_some(skeleton, out_count, |object: &SkeletonObject| {
        let range = object.skeleton.bones.get(bone)?.vertices.clone();
        Some(&object.skeleton.points[range])
    })
}

/// The triangles of a bone: `3 * *out_count` indices of its own points, borrowed until the skeleton
/// is freed. NULL if `bone` is not below the count or the handle is not valid. `out_count`: may be
/// NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_bone_triangles(
    skeleton: *const MlgSkeleton,
    bone: usize,
    out_count: *mut usize,
) -> *const u32 {
    access::lend_some(skeleton, out_count, |object: &SkeletonObject| {
        Some(&object.surfaces.get(bone)?.mesh.triangles[..])
    })
}

/// The points of all bones, one bone after the other, as previews have them: `3 * *out_count`
/// coordinates, borrowed until the skeleton is freed. NULL for a handle that is not valid.
/// `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_points(
    skeleton: *const MlgSkeleton,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(skeleton, out_count, |object: &SkeletonObject| &object.skeleton.points)
}

/// Tells all about a joint, its frames included. `out_joint`: its `struct_size` must be set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_joint(
    skeleton: *const MlgSkeleton,
    joint: usize,
    out_joint: *mut MlgJoint,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill(
        (skeleton, "skeleton"),
        (out_joint, "out_joint"),
        error,
        |object: &SkeletonObject| {
            let Some(found) = object.skeleton.joints.get(joint) else {
                return Err(Failure::invalid(format!(
                    "joint {joint} does not exist: there are {} (numbered from 0)",
                    object.skeleton.joints.len()
                )));
            };
            Ok(MlgJoint {
                struct_size: size_of::<MlgJoint>(),
                name: object.joint_names[joint].as_ptr(),
                parent: found.parent as u32,
                child: found.child as u32,
                in_tree: u32::from(found.in_tree),
                has_frames: 1,
                world_from_parent_frame: matrix_of(&found.parent_frame),
                world_from_child_frame: matrix_of(&found.child_frame),
                negative_limits: array(&found.limits.negative),
                positive_limits: array(&found.limits.positive),
                shift_limit: found.limits.shift,
            })
        },
    )
}

/// The named angles of the joints in the skeleton's pose: `*out_count` numbers, radians, borrowed
/// until the skeleton is freed. NULL without such angles or for a handle that is not valid.
/// `out_count`: may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_angles(
    skeleton: *const MlgSkeleton,
    out_count: *mut usize,
) -> *const f64 {
    access::lend(skeleton, out_count, |object: &SkeletonObject| &object.angles)
}

/// The name of an angle: UTF-8, borrowed until the skeleton is freed. NULL if `angle` is not below
/// the count or the handle is not valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_skeleton_angle_name(
    skeleton: *const MlgSkeleton,
    angle: usize,
) -> *const c_char {
    access::read_or(ptr::null(), skeleton, |object: &SkeletonObject| {
        object.angle_names.get(angle).map_or(ptr::null(), |n| n.as_ptr())
    })
}

fn array(v: &Vec3) -> [f64; 3] {
    (*v).into()
}
