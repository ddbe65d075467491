//! Starting poses: the template's own, and others on the way to the middle of the joints' ranges.
//!
//! An open hand and a half-closed one are too far apart for closest points: a finger falls on its
//! neighbour. So a few poses are tried with rigid bones and the best one goes on.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use super::skeleton::Skeleton;
use crate::math::Vec3;

/// Motions of the bones marked in `affected` that turn their joints to `share` of the way from the
/// template's neutral rotation to the middle of the range, seen from `root`; the other bones stay.
/// `now` holds the present frames of the same skeleton. Axes without limits go to neutral.
pub(super) fn towards_mid_range(
    template: &Skeleton,
    now: &Skeleton,
    root: usize,
    affected: &[bool],
    share: f64,
) -> Vec<Isometry3<f64>> {
    let mut motions = vec![Isometry3::identity(); now.bones.len()];
    for (j, to_child) in template.spanning_forest(root) {
        let (neutral, joint) = (&template.joints[j], &now.joints[j]);
        let (near, far) = joint.ends(to_child);
        if !affected[far] {
            continue;
        }
        let limits = &joint.limits;
        let middle = Vec3::from_fn(|k, _| {
            let middle = (limits.positive[k] - limits.negative[k]) / 2.0;
            if middle.is_finite() { middle * share } else { 0.0 }
        });
        let turn = UnitQuaternion::from_scaled_axis(middle);
        let wanted = Isometry3::from_parts(Translation3::identity(), turn)
            * neutral.parent_frame.inv_mul(&neutral.child_frame);
        motions[far] = if to_child {
            motions[near] * joint.parent_frame * wanted * joint.child_frame.inverse()
        } else {
            motions[near] * joint.child_frame * wanted.inverse() * joint.parent_frame.inverse()
        };
    }
    motions
}

/// The parts of the skeleton that hang on `heads`, seen from `root`, one list of marks for each
/// head that does not itself hang on another one.
pub(super) fn branches(skeleton: &Skeleton, root: usize, heads: &[bool]) -> Vec<Vec<bool>> {
    let mut branch_of: Vec<Option<usize>> = vec![None; skeleton.bones.len()];
    let mut count = 0;
    for (j, to_child) in skeleton.spanning_forest(root) {
        let joint = &skeleton.joints[j];
        let (near, far) = joint.ends(to_child);
        branch_of[far] = branch_of[near].or_else(|| {
            heads[far].then(|| {
                count += 1;
                count - 1
            })
        });
    }
    (0..count).map(|k| branch_of.iter().map(|b| *b == Some(k)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::joint_limits::JointLimits;
    use crate::register::rotation::rotation_vector;
    use crate::register::skeleton::tests::{block, joint_at};

    #[test]
    fn joints_turn_by_the_share_asked_for() {
        let limits =
            JointLimits::new(Vec3::new(0.2, 0.1, 0.0), Vec3::new(1.4, 0.1, f64::INFINITY), 1.0)
                .unwrap();
        let a = block(Vec3::zeros(), Vec3::repeat(1.0), 2);
        let b = block(Vec3::new(3.0, 0.0, 0.0), Vec3::repeat(1.0), 2);
        let joint = joint_at("ab", [0, 1], Vec3::new(1.5, 0.0, 0.0), limits);
        let skeleton = Skeleton::new(vec![("a".into(), a), ("b".into(), b)], vec![joint]).unwrap();
        for root in [0, 1] {
            let motions = towards_mid_range(&skeleton, &skeleton, root, &[true; 2], 0.5);
            let transform = skeleton.joints[0].transform(&motions[0], &motions[1]);
            let r = rotation_vector(&transform.rotation);
            assert!((r - Vec3::new(0.3, 0.0, 0.0)).norm() < 1e-12);
            assert!(motions[root] == Isometry3::identity());
            let marks = branches(&skeleton, root, &[true; 2]);
            assert_eq!(marks, vec![vec![root == 1, root == 0]]);
        }
    }
}
