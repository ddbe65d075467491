//! Motions by joint angles: forward kinematics, and the angles of a pose.
//!
//! [G] section 4: loops are broken (joints that only close loops are left out), and the frames of
//! the registered skeleton carry the angles, so that they mean the same for every person.

use nalgebra::{DMatrix, DVector, Isometry3, Translation3, Unit, UnitQuaternion};

use super::joint_path::JointPath;
use super::rotation::rotation_vector;
use super::skeleton::{Coordinate, Joint, Skeleton};
use crate::error::{Error, Result};
use crate::math::Vec3;

/// Newton steps at most for the angles of a joint with two or three axes, or with a path.
const MAX_STEPS: usize = 50;
/// Angles are found to this many radians.
const PRECISION: f64 = 1e-14;

/// Joint angles over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// Names of the angles.
    pub names: Vec<String>,
    /// Seconds, one per frame.
    pub times: Vec<f64>,
    /// Radians, frame by frame, in the order of the names.
    pub frames: Vec<Vec<f64>>,
}

/// The angles of a motion that the skeleton does not have, in a sentence.
pub fn unknown_angles(skeleton: &Skeleton, motion: &Motion) -> Option<String> {
    let unknown = |name: &&String| {
        !skeleton.joints.iter().flat_map(|j| &j.coordinates).any(|c| c.name == **name)
    };
    let left: Vec<&str> = motion.names.iter().filter(unknown).map(String::as_str).collect();
    (!left.is_empty()).then(|| format!("the skeleton has no angle {}; left out", left.join(", ")))
}

/// The rotation of a joint at given angles, one per coordinate.
pub fn joint_rotation(joint: &Joint, angles: &[f64]) -> UnitQuaternion<f64> {
    joint
        .coordinates
        .iter()
        .zip(angles)
        .map(|(c, &a)| UnitQuaternion::from_axis_angle(&Unit::new_unchecked(c.axis), a))
        .fold(UnitQuaternion::identity(), |product, turn| product * turn)
}

/// The angles of a joint, one per coordinate, whose rotation comes nearest to `rotation`.
pub fn joint_angles(joint: &Joint, rotation: &UnitQuaternion<f64>) -> Vec<f64> {
    match (joint.coordinates.as_slice(), &joint.path) {
        ([], _) => Vec::new(),
        ([own], Some(path)) if own.name == path.leader() => {
            vec![angle_on_path(path, own, rotation)]
        }
        _ => angles_of_axes(joint, rotation),
    }
}

/// The angle at which no turn about the coordinate's axis leads from the path's rotation to this one.
fn angle_on_path(path: &JointPath, own: &Coordinate, rotation: &UnitQuaternion<f64>) -> f64 {
    let mut angle = twist(rotation, &own.axis);
    for _ in 0..MAX_STEPS {
        let step = twist(&(rotation * path.at(angle).rotation.inverse()), &own.axis);
        angle += step;
        if step.abs() < PRECISION {
            break;
        }
    }
    angle
}

/// The turn about an axis that is in a rotation, within half a turn.
fn twist(rotation: &UnitQuaternion<f64>, axis: &Vec3) -> f64 {
    let turn = 2.0 * libm::atan2(rotation.imag().dot(axis), rotation.w);
    turn - std::f64::consts::TAU * (turn / std::f64::consts::TAU).round()
}

fn angles_of_axes(joint: &Joint, rotation: &UnitQuaternion<f64>) -> Vec<f64> {
    let count = joint.coordinates.len();
    let r = rotation_vector(rotation);
    let mut angles: Vec<f64> = joint.coordinates.iter().map(|c| c.axis.dot(&r)).collect();
    if count == 1 {
        return vec![twist(rotation, &joint.coordinates[0].axis)];
    }
    for _ in 0..MAX_STEPS {
        let error = rotation_vector(&(rotation * joint_rotation(joint, &angles).inverse()));
        let mut turned = UnitQuaternion::identity();
        let mut jacobian = DMatrix::zeros(3, count);
        for (k, (c, &a)) in joint.coordinates.iter().zip(&angles).enumerate() {
            jacobian.set_column(k, &(turned * c.axis));
            turned *= UnitQuaternion::from_axis_angle(&Unit::new_unchecked(c.axis), a);
        }
        let right = jacobian.transpose() * DVector::from_column_slice(error.as_slice());
        let normal = jacobian.transpose() * &jacobian + DMatrix::identity(count, count) * 1e-12;
        let Some(step) = normal.lu().solve(&right) else { break };
        for (angle, d) in angles.iter_mut().zip(step.iter()) {
            *angle += d.clamp(-1.0, 1.0);
        }
        if step.norm() < PRECISION {
            break;
        }
    }
    angles
}

/// All named angles of the skeleton as it lies.
pub fn present_angles(skeleton: &Skeleton) -> Vec<(String, f64)> {
    let names = |joint: &Joint| -> Vec<String> {
        joint.coordinates.iter().map(|c| c.name.clone()).collect()
    };
    skeleton.joints.iter().flat_map(|j| names(j).into_iter().zip(angles_now(j))).collect()
}

fn angles_now(joint: &Joint) -> Vec<f64> {
    let still = Isometry3::identity();
    joint_angles(joint, &joint.transform(&still, &still).rotation)
}

/// One named angle as the skeleton lies; none if no joint has it.
pub fn present_angle(skeleton: &Skeleton, name: &str) -> Option<f64> {
    skeleton.joints.iter().find_map(|joint| {
        let k = joint.coordinates.iter().position(|c| c.name == name)?;
        angles_now(joint).get(k).copied()
    })
}

/// Motions of all bones from where they lie to the pose with the given angles, `root` held still.
/// `angle` gives the angle of a coordinate, or `None` to keep it; joints that no angle moves or leads keep
/// their pose.
pub fn posed(
    skeleton: &Skeleton,
    root: usize,
    angle: impl Fn(&str) -> Option<f64>,
) -> Vec<Isometry3<f64>> {
    let still = Isometry3::identity();
    let mut motions = vec![still; skeleton.bones.len()];
    for (j, to_child) in skeleton.spanning_forest(root) {
        let joint = &skeleton.joints[j];
        let present = joint.transform(&still, &still);
        let wanted = wanted_transform(skeleton, joint, &present, &angle);
        if to_child {
            let parent = motions[joint.parent] * joint.parent_frame;
            motions[joint.child] = parent * wanted * joint.child_frame.inverse();
        } else {
            let child = motions[joint.child] * joint.child_frame;
            motions[joint.parent] = child * wanted.inverse() * joint.parent_frame.inverse();
        }
    }
    motions
}

fn wanted_transform(
    skeleton: &Skeleton,
    joint: &Joint,
    present: &Isometry3<f64>,
    angle: &impl Fn(&str) -> Option<f64>,
) -> Isometry3<f64> {
    if let Some(path) = &joint.path {
        let ends = present_angle(skeleton, path.leader()).zip(angle(path.leader()));
        return ends.map_or(*present, |(now, next)| path.led(present, now, next));
    }
    let given: Vec<Option<f64>> = joint.coordinates.iter().map(|c| angle(&c.name)).collect();
    if given.iter().all(Option::is_none) {
        return *present;
    }
    let now = joint_angles(joint, &present.rotation);
    let angles: Vec<f64> = given.iter().zip(now).map(|(given, now)| given.unwrap_or(now)).collect();
    let shift: Vec3 = present.translation.vector;
    Isometry3::from_parts(Translation3::from(shift), joint_rotation(joint, &angles))
}

/// The motions of all bones in every frame. Names that the skeleton does not have are passed over;
/// a motion without any known name is an error.
pub fn animate(
    skeleton: &Skeleton,
    root: usize,
    motion: &Motion,
) -> Result<Vec<Vec<Isometry3<f64>>>> {
    let known = |name: &String| {
        skeleton.joints.iter().flat_map(|j| &j.coordinates).any(|c| c.name == *name)
    };
    if !motion.names.iter().any(known) {
        return Err(Error::invalid(format!(
            "the motion moves none of the skeleton's angles; its names start with {}",
            motion.names.first().map_or("nothing", String::as_str)
        )));
    }
    let frames = motion.frames.iter().map(|row| {
        posed(skeleton, root, |name| {
            motion.names.iter().position(|n| n == name).and_then(|k| row.get(k).copied())
        })
    });
    Ok(frames.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::joint_limits::JointLimits;
    use crate::register::skeleton::Coordinate;
    use crate::register::skeleton::tests::{block, joint_at};

    fn chain() -> Skeleton {
        let free = Vec3::repeat(f64::INFINITY);
        let limits = JointLimits::new(free, free, 1.0).unwrap();
        let at = |x: f64| Vec3::new(x, 0.0, 0.0);
        let surfaces = (0..3)
            .map(|k| (format!("b{k}"), block(at(f64::from(k) * 4.0), Vec3::repeat(1.0), 2)))
            .collect();
        let coordinate = |name: &str, axis: [f64; 3]| Coordinate {
            name: name.into(),
            axis: Vec3::from(axis).normalize(),
            range: [-3.0, 3.0],
        };
        let mut hip = joint_at("hip", [0, 1], at(2.0), limits);
        hip.coordinates = vec![
            coordinate("flexion", [1.0, 0.1, 0.0]),
            coordinate("adduction", [0.0, 1.0, 0.2]),
            coordinate("rotation", [0.0, 0.0, 1.0]),
        ];
        let mut knee = joint_at("knee", [1, 2], at(6.0), limits);
        knee.coordinates = vec![coordinate("knee", [0.0, 1.0, 1.0])];
        Skeleton::new(surfaces, vec![hip, knee]).unwrap()
    }

    #[test]
    fn angles_extracted_are_the_angles_applied() {
        let skeleton = chain();
        let motion = Motion {
            names: ["flexion", "adduction", "rotation", "knee", "other"].map(String::from).to_vec(),
            times: vec![0.0, 1.0],
            frames: vec![vec![0.4, -0.3, 0.2, 1.9, 7.0], vec![-0.9, 0.1, -0.7, -2.5, 7.0]],
        };
        for root in 0..3 {
            for (frame, motions) in
                motion.frames.iter().zip(animate(&skeleton, root, &motion).unwrap())
            {
                let mut moved = skeleton.clone();
                moved.move_bones(&motions);
                let found = present_angles(&moved);
                for ((name, angle), wanted) in found.iter().zip(frame) {
                    assert!((angle - wanted).to_degrees().abs() < 1e-6, "{name}");
                }
            }
        }
        let foreign = Motion { names: vec!["x".into()], ..motion };
        assert!(animate(&skeleton, 0, &foreign).is_err());
    }

    #[test]
    fn joints_that_the_motion_does_not_name_keep_their_pose() {
        let skeleton = chain();
        let motions = posed(&skeleton, 0, |name| (name == "knee").then_some(0.5));
        assert!(motions[1].rotation.angle() < 1e-12);
        assert!((motions[2].rotation.angle() - 0.5).abs() < 1e-12);
    }
}
