//! Small motions of bones (twists), and the limits of one joint linearised in those of its two bones.

use nalgebra::{Isometry3, Matrix3x6, UnitQuaternion, Vector6};

use super::pose::moved;
use super::rotation::{rotation_vector, turned_about};
use super::skeleton::Joint;
use crate::math::{Mat3, Vec3};

/// A turn of a bone in one step is held below this, radians.
pub(super) const LONGEST_TURN: f64 = 0.5;

/// Shift of a bone, and its turn about its centre of mass.
pub(super) type Twist = Vector6<f64>;

/// `parts[0] . twist of the parent + parts[1] . twist of the child <= room`, or `=` for an axis
/// without freedom.
pub(super) struct Row {
    pub(super) bones: [usize; 2],
    pub(super) parts: [Twist; 2],
    pub(super) room: f64,
    pub(super) equality: bool,
    /// How the twists move the point that is limited, and the limit's second derivative there.
    pub(super) curve: Option<([Matrix3x6<f64>; 2], Mat3)>,
}

/// A shift and a turn as one vector.
pub(super) fn twist(shift: Vec3, turn: Vec3) -> Twist {
    Twist::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
}

/// All limits of a joint. Their number and order do not depend on the pose.
pub(super) fn rows(joint: &Joint, pose: &[Isometry3<f64>], centres: &[Vec3]) -> Vec<Row> {
    let mut rows = Vec::new();
    shift_rows(joint, pose, centres, &mut rows);
    turn_rows(joint, pose, &mut rows);
    rows
}

/// A limit `direction . point <= ...` on a point that the twists move by `motion`.
fn row(
    joint: &Joint,
    motion: &[Matrix3x6<f64>; 2],
    (direction, room): (Vec3, f64),
    curvature: Option<Mat3>,
) -> Row {
    Row {
        bones: [joint.parent, joint.child],
        parts: [motion[0].tr_mul(&direction), motion[1].tr_mul(&direction)],
        room,
        equality: false,
        curve: curvature.map(|c| (*motion, c)),
    }
}

/// The distance of the two joint points stays below the joint's shift.
fn shift_rows(joint: &Joint, pose: &[Isometry3<f64>], centres: &[Vec3], rows: &mut Vec<Row>) {
    let limit = joint.limits.shift;
    let at = [
        moved(&pose[joint.parent], &joint.parent_frame.translation.vector),
        moved(&pose[joint.child], &joint.child_frame.translation.vector),
    ];
    let gap = at[0] - at[1];
    let motion = [carried(&at[0], &centres[joint.parent]), -carried(&at[1], &centres[joint.child])];
    if limit <= 0.0 {
        for k in 0..3 {
            let equal = row(joint, &motion, (Vec3::ith(k, 1.0), -gap[k]), None);
            rows.push(Row { equality: true, ..equal });
        }
    } else if limit.is_finite() {
        let distance = gap.norm();
        let normal = if distance > 0.0 { gap / distance } else { Vec3::x() };
        let across = Mat3::identity() - normal * normal.transpose();
        let curvature = (distance > 0.0).then(|| across / distance.max(limit));
        rows.push(row(joint, &motion, (normal, limit - distance), curvature));
    }
}

/// The rotation vector of the child seen from the parent stays inside the ellipsoid.
fn turn_rows(joint: &Joint, pose: &[Isometry3<f64>], rows: &mut Vec<Row>) {
    let parent = pose[joint.parent].rotation * joint.parent_frame.rotation;
    let child = pose[joint.child].rotation * joint.child_frame.rotation;
    let r = joint.limits.nearer_vector(&rotation_vector(&(parent.inverse() * child)));
    let motion = bent(&r, &parent);
    let (negative, positive) = (joint.limits.negative, joint.limits.positive);
    for k in 0..3 {
        let axis = Vec3::ith(k, 1.0);
        match (negative[k] > 0.0, positive[k] > 0.0) {
            (false, false) => {
                let equal = row(joint, &motion, (axis, -r[k]), None);
                rows.push(Row { equality: true, ..equal });
            }
            (true, false) => rows.push(row(joint, &motion, (axis, -r[k]), None)),
            (false, true) => rows.push(row(joint, &motion, (-axis, r[k]), None)),
            (true, true) => {}
        }
    }
    // Squares of 1 / half axis; 0 for an axis that is free, or closed and kept by a row of its own.
    let axes = joint.limits.half_axes(&r);
    let weights = axes.map(|e| if e > 0.0 && e.is_finite() { 1.0 / (e * e) } else { 0.0 });
    let scaled = weights.component_mul(&r);
    let usage = r.dot(&scaled).sqrt();
    if usage > 0.0 {
        let (gradient, size) = (scaled / usage, scaled.norm() / usage);
        let second =
            (Mat3::from_diagonal(&weights) - gradient * gradient.transpose()) / usage.max(1.0);
        let limit = (gradient / size, (1.0 - usage) / size);
        rows.push(row(joint, &motion, limit, Some(second / size)));
    } else {
        rows.push(row(joint, &motion, (Vec3::zeros(), 1.0), None));
    }
}

/// A bone after a twist about its centre, which lies at `centre` before all motions.
pub(super) fn twisted(motion: &Isometry3<f64>, centre: &Vec3, twist: &Twist) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_scaled_axis(twist.fixed_rows::<3>(3).into_owned());
    let mut twisted = turned_about(motion, &moved(motion, centre), turn);
    twisted.translation.vector += twist.fixed_rows::<3>(0);
    twisted
}

/// How a bone's twist about `centre` moves the point `at`.
pub(super) fn carried(at: &Vec3, centre: &Vec3) -> Matrix3x6<f64> {
    let mut motion = Matrix3x6::zeros();
    motion.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
    motion.fixed_view_mut::<3, 3>(0, 3).copy_from(&-(at - centre).cross_matrix());
    motion
}

/// How the twists of parent and child change a joint's rotation vector `r`; `parent` turns its frame on
/// the parent into the world.
pub(super) fn bent(r: &Vec3, parent: &UnitQuaternion<f64>) -> [Matrix3x6<f64>; 2] {
    let mut motion = Matrix3x6::zeros();
    let change = left_jacobian_inverse(r) * parent.inverse().to_rotation_matrix();
    motion.fixed_view_mut::<3, 3>(0, 3).copy_from(&change);
    [-motion, motion]
}

/// d r / d w for exp(r') = exp(w) exp(r).
fn left_jacobian_inverse(r: &Vec3) -> Mat3 {
    let angle = r.norm();
    let cross = r.cross_matrix();
    let second = if angle < 1e-4 {
        1.0 / 12.0
    } else {
        (1.0 - 0.5 * angle / libm::tan(0.5 * angle)) / (angle * angle)
    };
    Mat3::identity() - 0.5 * cross + second * cross * cross
}
