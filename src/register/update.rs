//! The plastic update: the shape that is plausible and the pose that the joints allow, from where the
//! vertices want to go.
//!
//! [G] sections 3.3 and 3.4. What the target does not show takes part through the bones it hangs on.

use nalgebra::Isometry3;

use super::bone_scales::ScaleFreedom;
use super::correspond::Correspondences;
use super::elastic::whole_motion;
use super::joint_frames::{Fit, take_shape};
use super::level::Level;
use super::pairs::FOLLOWING;
use super::pose::{BoneMoments, heaviest, moments, moved, rigid_targets, settle_tree};
use super::pose_at_once::nearest_pose;
use super::registration::{Registration, State};
use super::riders::{ride, riders};
use super::rotation::PairSums;
use super::skeleton::Skeleton;
use crate::math::Vec3;

impl Registration {
    /// The plastic update: plausible shape, frames, joint pose.
    pub(super) fn update_reference(
        &self,
        level: &Level,
        state: &mut State,
        pairs: &Correspondences,
        masses: &[f64],
    ) {
        let wanted = &pairs.wanted;
        let shape = match &self.model {
            Some(model) => {
                state.coefficients = model.project(&self.template, wanted, masses);
                Some(model.synthesize(&state.coefficients))
            }
            None if level.freedom == ScaleFreedom::Fixed => None,
            None => {
                let fit = (level.freedom, level.scale_pull);
                state.scales = self.scales.fit(&self.template, wanted, masses, &state.scales, fit);
                Some(self.scales.shape(&state.scales))
            }
        };
        if let Some(shape) = shape {
            take_shape(&mut state.reference, &self.template, &shape, &self.areas, Fit::Rigid);
        }
        if let Some(softness) = level.springs
            && let Ok(posed) =
                self.pose_on_springs(softness, state, wanted, [masses, &pairs.unseen])
        {
            posed.carry(&mut state.reference);
            for scale in &mut state.scales {
                *scale *= posed.size;
            }
            return;
        }
        let motions = self.pose(&state.reference, wanted, [masses, &pairs.unseen], 0);
        state.reference.move_bones(&motions);
    }

    /// The motions that carry the reference bones to `wanted` under the joints' limits: sweeps, then
    /// `steps` for all joints at once, after which what is left outside is put inside. Bones beyond the last
    /// one with data ride on it.
    pub(super) fn pose(
        &self,
        reference: &Skeleton,
        wanted: &[Vec3],
        [masses, unseen]: [&[f64]; 2],
        steps: usize,
    ) -> Vec<Isometry3<f64>> {
        let moments = moments(reference, masses);
        let targets = goals(reference, &moments, wanted, [masses, unseen]);
        let whole = whole_motion(&reference.points, wanted, masses);
        let targets: Vec<Isometry3<f64>> =
            targets.into_iter().map(|t| t.unwrap_or(whole)).collect();
        if !self.options.use_joints {
            return targets;
        }
        let sweeps = self.options.joint_sweeps;
        let mut motions = nearest_pose(reference, &moments, &targets, sweeps, steps).transforms;
        if steps > 0 {
            settle_tree(reference, heaviest(&moments), &mut motions);
        }
        ride(reference, &riders(reference, &moments, &self.areas), &mut motions);
        motions
    }
}

/// Where each bone is to go by itself; none where it has no data and hangs on nothing that has.
pub(super) fn goals(
    reference: &Skeleton,
    moments: &[BoneMoments],
    wanted: &[Vec3],
    [masses, unseen]: [&[f64]; 2],
) -> Vec<Option<Isometry3<f64>>> {
    let mut goals = rigid_targets(reference, &reference.points, wanted, masses);
    let_unseen_follow(&mut goals, reference, heaviest(moments), wanted, [masses, unseen]);
    goals
}

/// What the target does not show of a bone goes, lightly, with the bone it hangs on, from the bone
/// `root` outwards.
fn let_unseen_follow(
    targets: &mut [Option<Isometry3<f64>>],
    reference: &Skeleton,
    root: usize,
    wanted: &[Vec3],
    [masses, unseen]: [&[f64]; 2],
) {
    for (j, to_child) in reference.spanning_forest(root) {
        let joint = &reference.joints[j];
        let (near, far) = joint.ends(to_child);
        let range = reference.bones[far].vertices.clone();
        let Some(motion) = targets[near] else { continue };
        if unseen[range.clone()].iter().all(|area| *area <= 0.0) {
            continue;
        }
        let mut sums = PairSums::new(reference.points[range.start]);
        for i in range {
            let p = &reference.points[i];
            sums.add(p, &wanted[i], masses[i]);
            sums.add(p, &moved(&motion, p), FOLLOWING * unseen[i]);
        }
        targets[far] = sums.best_rigid();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::joint_limits::JointLimits;
    use crate::register::options::Options;
    use crate::register::register;
    use crate::register::skeleton::tests::{block, joint_at};
    use crate::register::target::Target;
    use crate::run::Run;

    #[test]
    fn bones_that_the_target_does_not_show_go_with_those_they_hang_on() {
        let limits = JointLimits::new(Vec3::repeat(0.8), Vec3::repeat(0.8), 0.5).unwrap();
        let half = Vec3::new(5.0, 2.0, 1.0);
        let bone = |k: usize| block(Vec3::new(11.0 * k as f64, 0.0, 0.0), half, 6);
        let joint = |k: usize| {
            let at = Vec3::new(11.0 * k as f64 + 5.5, 0.0, 0.0);
            joint_at(&format!("joint {k}"), [k, k + 1], at, limits)
        };
        let bones = (0..3).map(|k| (format!("bone {k}"), bone(k))).collect();
        let chain = Skeleton::new(bones, (0..2).map(joint).collect()).unwrap();
        let motion = Isometry3::new(Vec3::new(0.4, -0.2, 0.5), Vec3::new(0.05, 0.1, 0.15));
        let mut seen = bone(0);
        for point in &mut seen.points {
            *point = moved(&motion, point);
        }
        let target = Target::per_bone(&chain, vec![("bone 0".into(), seen)]).unwrap();
        // A block lies on itself in many ways; this is the one meant.
        let options = Options { align: false, ..Options::default() };
        let found = register(&chain, &target, &options, &Run::new()).unwrap();
        for (found, before) in found.skeleton.points.iter().zip(&chain.points) {
            let wanted = moved(&motion, before);
            assert!((found - wanted).norm() < 0.1, "{found} {wanted}");
        }
    }
}
