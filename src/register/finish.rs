//! The end of a run: the joints are put inside their limits, and the result is measured.

use super::correspond::Correspondences;
use super::joint_frames::{Fit, take_shape};
use super::pairs::UNSEEN_WEIGHT;
use super::pose::{moments, moved, rigid_targets};
use super::registration::{Registration, State};
use super::riders::riders;
use super::skeleton::Joint;
use super::summarize::Found;
use super::summary::{LevelTrace, Registered};
use super::target::Target;

/// Steps for all joints at once at the end, so that loops close as well.
const FINAL_STEPS: usize = 30;

impl Registration {
    /// The elastic shape becomes the reference, its frames follow, and the pose is put inside
    /// the limits of the last level; then the result is measured.
    pub(super) fn finish(
        &self,
        state: State,
        target: &Target,
        levels: Vec<LevelTrace>,
        cancelled: bool,
    ) -> Registered {
        let State { mut reference, mut points, scales, coefficients, .. } = state;
        take_shape(&mut reference, &self.template, &points, &self.areas, Fit::Affine);
        // The joint points of both bones are estimates; where they disagree a little, the bones
        // stay where the data puts them and the joint is seated again in the middle.
        let factor = self.options.seat_factor.max(1.0);
        for (joint, given) in reference.joints.iter_mut().zip(&self.template.joints) {
            joint.limits.shift = joint.limits.shift.max(factor * given.limits.shift);
        }
        let (mut search, rules) = (self.search(target, 0.0), self.rules(0.0, None));
        let masses = self.masses_of_seen_bones(&search.at(&points, &rules));
        let none = vec![0.0; points.len()];
        let motions = self.pose(&reference, &points, [&masses, &none], FINAL_STEPS);
        // What has no data wants to be nowhere else.
        for (j, to_child) in riders(&reference, &moments(&reference, &masses), &self.areas) {
            let (_, bone) = reference.joints[j].ends(to_child);
            for i in reference.bones[bone].vertices.clone() {
                points[i] = moved(&motions[bone], &reference.points[i]);
            }
        }
        let free = rigid_targets(&reference, &reference.points, &points, &self.areas);
        let free: Vec<_> = free.into_iter().map(Option::unwrap_or_default).collect();
        let wanted =
            reference.joints.iter().map(|j| j.transform(&free[j.parent], &free[j.child])).collect();
        reference.move_bones(&motions);
        for (joint, given) in reference.joints.iter_mut().zip(&self.template.joints) {
            seat(joint);
            joint.limits = given.limits;
        }
        let pairs = search.at(&reference.points, &rules);
        let found =
            Found { skeleton: reference, elastic_points: points, scales, coefficients, wanted };
        let found = Registered::new(found, &self.template, &self.areas, target, &pairs, levels);
        Registered { cancelled, ..found }
    }

    /// The areas of the vertices, each bone's times the share of it that the target shows.
    fn masses_of_seen_bones(&self, pairs: &Correspondences) -> Vec<f64> {
        let mut masses = self.areas.clone();
        for bone in &self.template.bones {
            let range = bone.vertices.clone();
            let [area, unseen] =
                [&self.areas, &pairs.unseen].map(|of| of[range.clone()].iter().sum::<f64>());
            let share = (1.0 - unseen / area).max(UNSEEN_WEIGHT);
            masses[range].iter_mut().for_each(|mass| *mass *= share);
        }
        masses
    }
}

/// Puts both joint points in their middle, unless they are further apart than the (widened) limit.
fn seat(joint: &mut Joint) {
    let (a, b) = (joint.parent_frame.translation.vector, joint.child_frame.translation.vector);
    if (a - b).norm() <= joint.limits.shift * (1.0 + 1e-9) {
        joint.parent_frame.translation.vector = (a + b) / 2.0;
        joint.child_frame.translation.vector = (a + b) / 2.0;
    }
}
