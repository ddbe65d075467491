//! From what the loop found to figures and verdicts.

use nalgebra::Isometry3;

use super::correspond::Correspondences;
use super::penetration::penetrations;
use super::pose::{LimitState, limit_state};
use super::rotation::rotation_vector;
use super::skeleton::Skeleton;
use super::summary::{BoneSummary, JointSummary, LevelTrace, Registered};
use super::target::Target;
use super::verdict::{Evidence, Judged, Judgement, judge_bones, judge_whole};
use crate::math::Vec3;

/// The shapes and frames found.
pub(super) struct Found {
    pub(super) skeleton: Skeleton,
    pub(super) elastic_points: Vec<Vec3>,
    pub(super) scales: Vec<Vec3>,
    pub(super) coefficients: Vec<f64>,
    /// Where each joint's data would take it: the child frame seen from the parent frame.
    pub(super) wanted: Vec<Isometry3<f64>>,
}

impl Registered {
    pub(super) fn new(
        found: Found,
        template: &Skeleton,
        areas: &[f64],
        target: &Target,
        pairs: &Correspondences,
        levels: Vec<LevelTrace>,
    ) -> Self {
        let Found { skeleton, elastic_points, scales, coefficients, wanted } = found;
        let joints = joint_summaries(&skeleton, &wanted);
        let Judged { bones, seen, explained } = judge_bones(&Evidence {
            template,
            areas,
            result: &skeleton,
            elastic: &elastic_points,
            target,
            pairs,
            joints: &joints,
        });
        let mut bones: Vec<BoneSummary> = bones
            .into_iter()
            .enumerate()
            .map(|(b, judgement)| bone_summary(&skeleton, b, pairs, judgement))
            .collect();
        for (bone, found) in bones.iter_mut().zip(penetrations(&skeleton)) {
            bone.penetration = found.as_ref().map_or(0.0, |p| p.depth);
            bone.penetrates = found.map(|p| skeleton.bones[p.into].name.clone());
        }
        let without: Vec<bool> = (0..bones.len()).map(|b| !target.has_surface_of(b)).collect();
        let judgement = judge_whole(&bones, &without, explained, target.left_out);
        let notes = target.notes();
        let landmarks = target.landmarks.iter().map(|l| l.distance(&skeleton.points)).collect();
        let cancelled = false;
        Self {
            skeleton,
            elastic_points,
            scales,
            coefficients,
            bones,
            seen,
            joints,
            levels,
            cancelled,
            judgement,
            landmarks,
            notes,
        }
    }
}

fn bone_summary(
    skeleton: &Skeleton,
    b: usize,
    pairs: &Correspondences,
    (judgement, seen): (Judgement, f64),
) -> BoneSummary {
    let bone = &skeleton.bones[b];
    let (mut sum, mut weight, mut most) = (0.0, 0.0, 0.0_f64);
    for i in bone.vertices.clone() {
        let distance = (pairs.wanted[i] - skeleton.points[i]).norm();
        sum += pairs.weight[i] * distance;
        weight += pairs.weight[i];
        most = most.max(distance);
    }
    BoneSummary {
        name: bone.name.clone(),
        mean_residual: if weight > 0.0 { sum / weight } else { 0.0 },
        max_residual: most,
        verdict: judgement.verdict,
        reasons: judgement.reasons,
        seen,
        penetration: 0.0,
        penetrates: None,
    }
}

fn joint_summaries(skeleton: &Skeleton, wanted: &[Isometry3<f64>]) -> Vec<JointSummary> {
    let still = Isometry3::identity();
    skeleton
        .joints
        .iter()
        .zip(wanted)
        .map(|(joint, wanted)| {
            let transform = joint.transform(&still, &still);
            let LimitState { rotation_usage, rotation_excess, shift, shift_excess } =
                limit_state(&joint.limits, &transform);
            let (a, b) =
                (joint.parent_frame.translation.vector, joint.child_frame.translation.vector);
            JointSummary {
                name: joint.name.clone(),
                centre: (a + b) / 2.0,
                rotation: rotation_vector(&transform.rotation),
                usage: rotation_usage,
                excess_degrees: rotation_excess.to_degrees(),
                shift,
                excess_shift: shift_excess,
                seam: wanted.translation.vector.norm(),
                wanted_rotation: rotation_vector(&wanted.rotation),
                wanted_excess_degrees: limit_state(&joint.limits, wanted)
                    .rotation_excess
                    .to_degrees(),
                wanted_shift: wanted.translation.vector,
            }
        })
        .collect()
}
