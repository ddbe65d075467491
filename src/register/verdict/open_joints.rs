//! Bones that lie away from where the joints have them: a toe on the next toe's place.
//!
//! Such a bone fits what it lies on, and so do the bones beyond it, which came along. What tells is the joint at
//! which they part from the skeleton: the data leave it open.

use super::Finding;
use super::evidence::Evidence;
use crate::math::Vec3;
use crate::register::skeleton::Skeleton;

/// How far a bone lies off its place, as a share of its radius, or of the smaller one of the two bones at the open
/// joint: doubtful, failed. From a gap of the first beyond the allowed one on a joint is open.
const OPEN: [f64; 2] = [0.6, 2.0];

/// Where a bone lies off its place.
#[derive(Clone, Copy, Debug)]
struct Off {
    /// The open joint nearest to it on the way from the root.
    joint: usize,
    distance: f64,
    /// What the distance is a share of.
    size: f64,
}

/// What speaks against bones that lie off their places on the heaviest bone that is shown. `shares`: how much the
/// target shows of each.
pub(super) fn beyond_open_joints(
    evidence: &Evidence,
    radii: &[f64],
    shares: &[f64],
) -> Vec<Option<Finding>> {
    let joints = evidence.result.joints.iter().zip(evidence.joints);
    let gaps: Vec<Vec3> =
        joints.map(|(joint, summary)| joint.parent_frame.rotation * summary.wanted_shift).collect();
    let template = evidence.template;
    let finding = |off: Off| {
        let reason = format!(
            "it lies {:.3} from its place at {}, which its data leave open; look whether it lies on another bone",
            off.distance, template.joints[off.joint].name
        );
        Finding::new(off.distance / off.size, OPEN, reason)
    };
    let off = off_their_places(template, heaviest_shown(evidence, shares), radii, &gaps);
    off.into_iter().map(|off| off.map(finding)).collect()
}

/// For each bone the sum of the gaps of the open joints between it and the bone `root`; none where none is open.
/// Behind a bone that alone lies off its place they cancel out. `gaps`: from the joint point of each joint's
/// parent to that of its child.
fn off_their_places(
    template: &Skeleton,
    root: usize,
    radii: &[f64],
    gaps: &[Vec3],
) -> Vec<Option<Off>> {
    let mut found: Vec<Option<Off>> = vec![None; radii.len()];
    let mut by = vec![Vec3::zeros(); radii.len()];
    for (j, to_child) in template.spanning_forest(root) {
        let (near, far) = template.joints[j].ends(to_child);
        let smaller = radii[near].min(radii[far]);
        let is_open = gaps[j].norm() - template.joints[j].limits.shift > OPEN[0] * smaller;
        by[far] = match (is_open, to_child) {
            (false, _) => by[near],
            (true, true) => by[near] + gaps[j],
            (true, false) => by[near] - gaps[j],
        };
        let distance = by[far].norm();
        found[far] = if is_open {
            Some(Off { joint: j, distance, size: smaller })
        } else {
            found[near].map(|off| Off { distance, size: radii[far], ..off })
        };
    }
    found
}

/// The bone of which the target shows the largest area.
fn heaviest_shown(evidence: &Evidence, shares: &[f64]) -> usize {
    let bones = evidence.template.bones.iter().zip(shares);
    let shown = bones
        .map(|(bone, share)| share * evidence.areas[bone.vertices.clone()].iter().sum::<f64>());
    shown.enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b)).map_or(0, |(b, _)| b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::joint_limits::JointLimits;
    use crate::register::skeleton::tests::{block, joint_at};

    #[test]
    fn a_toe_on_the_next_toes_place_is_off_and_what_lies_behind_a_lost_bone_is_not() {
        let bone = |k: usize| {
            let at = Vec3::new(4.0 * k as f64, 0.0, 0.0);
            (format!("bone {k}"), block(at, Vec3::repeat(1.0), 1))
        };
        let limits = JointLimits::new(Vec3::zeros(), Vec3::zeros(), 0.5).unwrap();
        // From bone 2 both ways: 2-1-0 and 2-3-4-5; the joints' parents are the lower ones.
        let joint = |k: usize| joint_at(&format!("joint {k}"), [k, k + 1], Vec3::zeros(), limits);
        let chain = Skeleton::new((0..6).map(bone).collect(), (0..5).map(joint).collect()).unwrap();
        let shares = |gaps: [f64; 5]| {
            let gaps = gaps.map(|gap| Vec3::new(0.0, gap, 0.0));
            let off = off_their_places(&chain, 2, &[2.0, 2.0, 9.0, 2.0, 2.0, 4.0], &gaps);
            off.iter().map(|off| off.map_or(0.0, |off| off.distance / off.size)).collect::<Vec<_>>()
        };
        // Within the allowed gap and 0.6 radii.
        assert_eq!(shares([0.0, 1.7, 1.7, 0.0, 0.0]), [0.0; 6]);
        assert_eq!(shares([0.0, 4.0, 0.0, 0.0, 0.0]), [2.0, 2.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(shares([0.0, 0.0, 6.0, 0.0, 0.0]), [0.0, 0.0, 0.0, 3.0, 3.0, 1.5]);
        // Bone 3 alone lies elsewhere.
        assert_eq!(shares([0.0, 0.0, 6.0, -6.0, 0.0]), [0.0, 0.0, 0.0, 3.0, 0.0, 0.0]);
    }
}
