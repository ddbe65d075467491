//! The joints' limits in the search: knowledge, and not walls.
//!
//! As long as bones may be mistaken for their neighbours, the limits are what keeps them apart. Once each
//! has found its place, a joint whose data lie beyond its limits is given a slack: another person's knee
//! may be some degrees straighter than the template's range begins, and a leg's fibula longer. Bones that
//! the target does not show ask for nothing, so their joints stay as they are.

use super::joint_limits::Limits;
use super::levels::Level;
use super::pose::{limit_state, rigid_targets};
use super::registration::{Registration, State};

/// How much further a joint may go where its data insist: degrees, and a share of the smaller bone's size.
const SLACK: [f64; 2] = [10.0, 0.04];
/// They insist from so much beyond a limit on.
const INSISTENCE: [f64; 2] = [3.0, 0.01];

impl Registration {
    /// Sets the limits that hold at a level.
    pub(super) fn limit_joints(&self, level: &Level, state: &mut State) {
        let State { reference, points, .. } = state;
        let motions = rigid_targets(reference, &reference.points, points, &self.areas);
        let motions: Vec<_> = motions.into_iter().map(Option::unwrap_or_default).collect();
        let size = |b: usize| self.template.bone_surface(b, &self.template.points).diagonal();
        let sizes: Vec<f64> = (0..motions.len()).map(size).collect();
        for (joint, given) in reference.joints.iter_mut().zip(&self.template.joints) {
            let size = sizes[joint.parent].min(sizes[joint.child]);
            let wanted = joint.transform(&motions[joint.parent], &motions[joint.child]);
            let beyond = limit_state(&given.limits, &wanted);
            let insist = beyond.rotation_excess.to_degrees() > INSISTENCE[0]
                || beyond.shift_excess > INSISTENCE[1] * size;
            let slack = SLACK[1] * size;
            joint.limits = match given.limits.rule.unwrap_or(self.options.limits) {
                Limits::Soft if level.bones_apart && insist => {
                    given.limits.widened(SLACK[0].to_radians(), slack)
                }
                Limits::Soft | Limits::Hard => given.limits,
                Limits::None => given.limits.widened(f64::INFINITY, slack),
            };
        }
    }
}
