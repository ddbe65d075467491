//! The joints' limits in the search: knowledge, and not walls.
//!
//! As long as bones may be mistaken for their neighbours, the limits are what keeps them apart. Once each
//! has found its place, a joint whose data lie beyond its limits is given a slack: another person's knee
//! may be some degrees straighter than the template's range begins, and a leg's fibula longer. Bones that
//! the target does not show ask for nothing, so their joints stay as they are.

use super::joint_limits::Limits;
use super::level::Level;
use super::pose::{limit_state, rigid_targets};
use super::registration::{Registration, State};
use super::skeleton::Joint;
use crate::mesh::diagonal;

/// How much further a joint may go where its data insist: degrees, and a share of the smaller bone's size.
const SLACK: [f64; 2] = [10.0, 0.04];
/// They insist from so much beyond a limit on. Finger bones come out up to 3.6 degrees beyond limits that
/// their person keeps.
const INSISTENCE: [f64; 2] = [4.0, 0.01];

impl Registration {
    /// Sets the limits that hold at a level.
    pub(super) fn limit_joints(&self, level: &Level, state: &mut State) {
        let rule = |given: &Joint| given.limits.rule.unwrap_or(self.options.limits);
        let walls = |limits| limits == Limits::Hard || limits == Limits::Soft && !level.bones_apart;
        let State { reference, points, .. } = state;
        for (joint, given) in reference.joints.iter_mut().zip(&self.template.joints) {
            joint.limits = given.limits;
        }
        if self.template.joints.iter().all(|given| walls(rule(given))) {
            return;
        }
        let motions = rigid_targets(reference, &reference.points, points, &self.areas);
        let motions: Vec<_> = motions.into_iter().map(Option::unwrap_or_default).collect();
        for (joint, given) in reference.joints.iter_mut().zip(&self.template.joints) {
            let size = self.smaller_size(given);
            let wanted = joint.transform(&motions[joint.parent], &motions[joint.child]);
            let beyond = limit_state(&given.limits, &wanted);
            let slack = |excess, k: usize| if excess > INSISTENCE[k] { SLACK[k] } else { 0.0 };
            let [turn, shift] = match rule(given) {
                limits if walls(limits) => continue,
                Limits::None => [f64::INFINITY, SLACK[1]],
                _ => [
                    slack(beyond.rotation_excess.to_degrees(), 0),
                    slack(beyond.shift_excess / size, 1),
                ],
            };
            joint.limits = given.limits.widened(turn.to_radians(), shift * size);
        }
    }

    /// The template's size of the smaller bone at a joint.
    fn smaller_size(&self, joint: &Joint) -> f64 {
        let size =
            |b: usize| diagonal(&self.template.points[self.template.bones[b].vertices.clone()]);
        size(joint.parent).min(size(joint.child))
    }
}
