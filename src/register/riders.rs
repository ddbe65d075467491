//! Bones beyond the last one with data: nothing holds them but their joint, so they ride on it as they are.
//!
//! A solver for the pose cannot place them: what their neighbour would like to do and its joints forbid would
//! turn them a little further in each update.

use nalgebra::{Isometry3, Translation3};

use super::pairs::UNSEEN_WEIGHT;
use super::pose::{BoneMoments, heaviest};
use super::skeleton::Skeleton;

/// The joints that lead to such bones as steps of a spanning forest, from the inside outwards. `moments` are
/// those of the seen vertices.
pub(super) fn riders(
    skeleton: &Skeleton,
    moments: &[BoneMoments],
    areas: &[f64],
) -> Vec<(usize, bool)> {
    let bones = skeleton.bones.iter().zip(moments);
    let mut empty: Vec<bool> = bones
        .map(|(bone, own)| {
            own.mass <= 2.0 * UNSEEN_WEIGHT * areas[bone.vertices.clone()].iter().sum::<f64>()
        })
        .collect();
    // Where a part of the skeleton has no data at all, nothing leads.
    let mut led: Vec<bool> = empty.iter().map(|empty| !empty).collect();
    let mut steps = skeleton.spanning_forest(heaviest(moments));
    // A bone between two with data is held from both sides.
    for &(j, to_child) in steps.iter().rev() {
        let (near, far) = skeleton.joints[j].ends(to_child);
        empty[near] &= empty[far];
    }
    steps.retain(|&(j, to_child)| {
        let (near, far) = skeleton.joints[j].ends(to_child);
        led[far] |= led[near];
        empty[far] && led[near]
    });
    steps
}

/// Lets bones go with those they hang on, their joints' points together: one for each of these steps of a
/// spanning forest.
pub(super) fn ride(skeleton: &Skeleton, steps: &[(usize, bool)], motions: &mut [Isometry3<f64>]) {
    for &(j, to_child) in steps {
        let joint = &skeleton.joints[j];
        let (near, far) = joint.ends(to_child);
        let gap = joint.parent_frame.translation.vector - joint.child_frame.translation.vector;
        let gap = if to_child { gap } else { -gap };
        let motion = motions[near];
        motions[far] = Translation3::from(motion.rotation * gap) * motion;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::register::areas::vertex_areas;
    use crate::register::joint_limits::JointLimits;
    use crate::register::options::Options;
    use crate::register::pose::moments;
    use crate::register::register;
    use crate::register::rotation::turned_about;
    use crate::register::skeleton::tests::{block, joint_at};
    use crate::register::target::Target;
    use crate::run::Run;
    use nalgebra::UnitQuaternion;

    /// Four bones in a row.
    fn chain() -> Skeleton {
        let limits = JointLimits::new(Vec3::repeat(0.2), Vec3::repeat(0.2), 0.5).unwrap();
        let half = Vec3::new(5.0, 2.0, 1.0);
        let bone = |k: u32| {
            let centre = Vec3::new(11.0 * f64::from(k), 0.0, 0.0);
            (format!("b{k}"), block(centre, half, 6))
        };
        let joint = |k: u32| {
            let place = Vec3::new(11.0 * f64::from(k) + 5.5, 0.0, 0.0);
            joint_at(&format!("j{k}"), [k as usize, k as usize + 1], place, limits)
        };
        Skeleton::new((0..4).map(bone).collect(), (0..3).map(joint).collect()).unwrap()
    }

    #[test]
    fn only_bones_beyond_the_last_one_with_data_ride() {
        let skeleton = chain();
        let areas = vertex_areas(&skeleton.points, &skeleton.triangles);
        let found = |with_data: [bool; 4]| {
            let of = skeleton.bone_of_vertex();
            let weight = |b: u32| if with_data[b as usize] { 1.0 } else { UNSEEN_WEIGHT };
            let masses: Vec<f64> = areas.iter().zip(of).map(|(a, b)| a * weight(b)).collect();
            riders(&skeleton, &moments(&skeleton, &masses), &areas)
        };
        assert_eq!(found([true, false, true, false]), [(2, true)]);
        assert_eq!(found([false, false, true, true]), [(1, false), (0, false)]);
        assert!(found([true; 4]).is_empty() && found([false; 4]).is_empty());
    }

    #[test]
    fn a_joint_that_holds_its_bone_back_does_not_turn_what_hangs_on_it() {
        let skeleton = chain();
        // The second bone's data are three times as far around as its joint lets it go.
        let mut turned = skeleton.clone();
        let centre = skeleton.joints[0].child_frame.translation.vector;
        let turn = UnitQuaternion::from_scaled_axis(Vec3::z() * 0.6);
        let still = Isometry3::identity();
        turned.move_bones(&[still, turned_about(&still, &centre, turn), still, still]);
        let surface = |b: usize| (format!("b{b}"), turned.bone_surface(b, &turned.points));
        let target = Target::per_bone(&skeleton, vec![surface(0), surface(1)]).unwrap();
        let options = Options { align: false, ..Options::default() };
        let found = register(&skeleton, &target, &options, &Run::new()).unwrap();
        for joint in &found.skeleton.joints[1..] {
            let across = joint.transform(&still, &still);
            assert!(across.rotation.angle() < 1e-6, "{} {}", joint.name, across.rotation.angle());
            assert!(across.translation.vector.norm() < 1e-6, "{}", joint.name);
        }
    }
}
