#![no_main]
//! Skeletons and registrations from any arrays through the C functions: no panic.

use std::ptr;

use libfuzzer_sys::arbitrary::{self, Arbitrary};
use libfuzzer_sys::fuzz_target;
use moulage::capi::*;

#[derive(Arbitrary, Debug)]
struct Bones {
    /// Small numbers make bones that hold together.
    bones: Vec<(Vec<[i8; 3]>, Vec<[u8; 3]>)>,
    joints: Vec<JointArrays>,
    target: (Vec<[i8; 3]>, Vec<[u8; 3]>),
    options: (bool, bool, u8, Vec<f32>),
}

#[derive(Arbitrary, Debug)]
struct JointArrays {
    ends: (u8, u8),
    switches: (bool, bool),
    centre: [i8; 3],
    /// One number of the frame that is put where it does not belong.
    special: Option<(u8, f64)>,
    limits: [f32; 6],
    shift: f32,
}

fn no_panic(status: MlgStatus) -> bool {
    assert_ne!(status, MlgStatus::Panic);
    status == MlgStatus::Ok
}

fn mesh(points: &[[i8; 3]], triangles: &[[u8; 3]]) -> *mut MlgTriMesh {
    let points: Vec<f64> = points.iter().flatten().map(|&c| f64::from(c) / 8.0).collect();
    let triangles: Vec<u32> = triangles.iter().flatten().map(|&v| v.into()).collect();
    let mut mesh = ptr::null_mut();
    // SAFETY: every pointer comes with the length of its own list.
    let made = unsafe {
        mlg_tri_mesh_new(
            points.as_ptr(),
            points.len() / 3,
            triangles.as_ptr(),
            triangles.len() / 3,
            &raw mut mesh,
            ptr::null_mut(),
        )
    };
    no_panic(made);
    mesh
}

const NAMES: [&std::ffi::CStr; 4] = [c"a", c"b", c"c", c"d"];

fuzz_target!(|given: Bones| {
    let meshes: Vec<_> =
        given.bones.iter().take(NAMES.len()).map(|(points, faces)| mesh(points, faces)).collect();
    let bones: Vec<MlgBone> = meshes
        .iter()
        .zip(NAMES)
        .map(|(&surface, name)| MlgBone {
            struct_size: size_of::<MlgBone>(),
            name: name.as_ptr(),
            surface,
        })
        .collect();
    let joints: Vec<MlgJoint> = given.joints.iter().zip(NAMES).map(joint).collect();
    let mut skeleton = ptr::null_mut();
    // SAFETY: as above; all names are static.
    unsafe {
        let made = mlg_skeleton_new(
            bones.as_ptr(),
            bones.len(),
            joints.as_ptr(),
            joints.len(),
            &raw mut skeleton,
            ptr::null_mut(),
        );
        if no_panic(made) {
            register(skeleton, &given);
        }
        mlg_skeleton_free(skeleton);
        meshes.into_iter().for_each(|mesh| mlg_tri_mesh_free(mesh));
    }
});

fn joint((given, name): (&JointArrays, &std::ffi::CStr)) -> MlgJoint {
    // SAFETY: plain numbers and pointers, for which zeros are good.
    let mut joint = unsafe { std::mem::zeroed::<MlgJoint>() };
    // SAFETY: the size is that of the struct.
    no_panic(unsafe { mlg_joint_init(&raw mut joint, size_of::<MlgJoint>()) });
    joint.name = name.as_ptr();
    (joint.parent, joint.child) = (given.ends.0.into(), given.ends.1.into());
    (joint.in_tree, joint.has_frames) = (given.switches.0.into(), given.switches.1.into());
    for (k, &c) in given.centre.iter().enumerate() {
        joint.world_from_parent_frame[4 * k + 3] = f64::from(c) / 8.0;
        joint.world_from_child_frame[4 * k + 3] = f64::from(c) / 8.0;
    }
    if let Some((place, value)) = given.special {
        joint.world_from_child_frame[place as usize % 16] = value;
    }
    joint.negative_limits.copy_from_slice(&[0, 1, 2].map(|k| given.limits[k].into()));
    joint.positive_limits.copy_from_slice(&[3, 4, 5].map(|k| given.limits[k].into()));
    joint.shift_limit = given.shift.into();
    joint
}

/// Each call either works or says why not; none may panic.
unsafe fn register(skeleton: *mut MlgSkeleton, given: &Bones) {
    let target = mesh(&given.target.0, &given.target.1);
    let (mut problem, mut result, mut person) = (ptr::null_mut(), ptr::null_mut(), ptr::null_mut());
    let none = ptr::null_mut();
    // SAFETY: as in the target.
    unsafe {
        no_panic(mlg_registration_new(skeleton, &raw mut problem, none));
        no_panic(mlg_registration_set_target(problem, target, none));
        let mut options = std::mem::zeroed::<MlgRegistrationOptions>();
        no_panic(mlg_registration_options_init(&raw mut options, size_of_val(&options)));
        (options.align, options.paper) = (given.options.0.into(), given.options.1.into());
        options.max_iterations = u32::from(given.options.2 % 3) + 1;
        options.thread_count = 1;
        let radii: Vec<f64> = given.options.3.iter().take(3).map(|&r| r.into()).collect();
        (options.radii, options.radius_count) = (radii.as_ptr(), radii.len());
        if no_panic(mlg_registration_run(problem, &raw const options, &raw mut result, none)) {
            no_panic(mlg_registration_result_skeleton(result, &raw mut person, none));
            for joint in 0..mlg_skeleton_joint_count(person) {
                let mut pose = std::mem::zeroed::<MlgJointPose>();
                pose.struct_size = size_of_val(&pose);
                no_panic(mlg_registration_result_joint_pose(result, joint, &raw mut pose, none));
            }
        }
        mlg_skeleton_free(person);
        mlg_registration_result_free(result);
        mlg_registration_free(problem);
        mlg_tri_mesh_free(target);
    }
}
