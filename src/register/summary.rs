//! What a registration found, and how well it fits.

use nalgebra::Isometry3;
use serde::Serialize;

use super::correspond::Correspondences;
use super::penetration::penetrations;
use super::pose::{LimitState, limit_state};
use super::skeleton::Skeleton;
use super::target::Target;
use super::verdict::{Evidence, Judgement, Verdict, judge_bones, judge_whole};
use crate::math::Vec3;

/// A registered skeleton.
#[derive(Clone, Debug)]
pub struct Registered {
    /// The person's bones (template vertex order) and joint frames, inside all joint limits.
    pub skeleton: Skeleton,
    /// The elastic shape before its joints were put inside their limits.
    pub elastic_points: Vec<Vec3>,
    /// Scales of every bone along its principal axes, where no shape model was used.
    pub scales: Vec<Vec3>,
    /// Coefficients of the shape model, in standard deviations, where one was used.
    pub coefficients: Vec<f64>,
    /// How each bone fits.
    pub bones: Vec<BoneSummary>,
    /// How each joint stands to its limits.
    pub joints: Vec<JointSummary>,
    /// The levels of the loop.
    pub levels: Vec<LevelTrace>,
    /// Stopped on request before the end.
    pub cancelled: bool,
    /// How far the whole can be trusted.
    pub judgement: Judgement,
    /// How far each of the target's landmarks ends from its place, template unit.
    pub landmarks: Vec<f64>,
    /// What was done to the target before it was used, in sentences.
    pub notes: Vec<String>,
}

/// The shapes and frames found.
pub(super) struct Found {
    pub(super) skeleton: Skeleton,
    pub(super) elastic_points: Vec<Vec3>,
    pub(super) scales: Vec<Vec3>,
    pub(super) coefficients: Vec<f64>,
    pub(super) seams: Vec<f64>,
    /// Where each joint's data would take it: the child frame seen from the parent frame.
    pub(super) wanted: Vec<Isometry3<f64>>,
}

/// The fit of one bone; lengths in the template's unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BoneSummary {
    /// Name.
    pub name: String,
    /// Mean distance of the wanted positions, both ways, weighted by area.
    pub mean_residual: f64,
    /// Largest such distance.
    pub max_residual: f64,
    /// How far it can be trusted.
    pub verdict: Verdict,
    /// Why it is not good, in sentences, each with what can be done about it.
    pub reasons: Vec<String>,
    /// Share of the bone's area that lies on the target, 0 to 1; in an image, that finds something like
    /// it.
    pub seen: f64,
    /// Depth of its deepest vertex inside another bone; 0 = inside none.
    pub penetration: f64,
    /// That other bone.
    pub penetrates: Option<String>,
}

/// One joint of the result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointSummary {
    /// Name.
    pub name: String,
    /// Joint centre (mean of the two joint points), template unit.
    pub centre: Vec3,
    /// Rotation vector of the child frame seen from the parent frame, radians.
    pub rotation: Vec3,
    /// Share of the rotation ellipsoid used; 1 = on the limit.
    pub usage: f64,
    /// Rotation beyond the limit, degrees.
    pub excess_degrees: f64,
    /// Distance of the two joint points, template unit.
    pub shift: f64,
    /// Shift beyond the limit, template unit.
    pub excess_shift: f64,
    /// Distance of the two estimates of the joint's centre before they were joined, template unit.
    pub seam: f64,
    /// Rotation vector that the data alone would give it, radians.
    pub wanted_rotation: Vec3,
    /// Rotation beyond the limit that the data alone would give it, degrees.
    pub wanted_excess_degrees: f64,
}

/// One level of the loop.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LevelTrace {
    /// Cluster radius, template unit.
    pub radius: f64,
    /// Closest-point iterations.
    pub iterations: usize,
    /// Seconds for them.
    pub seconds: f64,
    /// Updates of reference shape and pose among them.
    pub updates: usize,
    /// Mean distance of the pairs in the last iteration.
    pub mean_distance: f64,
    /// Root mean square distance of all pairs, those dropped too, in the last iteration.
    pub rms_distance: f64,
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
        let Found { skeleton, elastic_points, scales, coefficients, seams, wanted } = found;
        let joints = joint_summaries(&skeleton, &seams, &wanted);
        let (judgements, explained) = judge_bones(&Evidence {
            template,
            areas,
            result: &skeleton,
            elastic: &elastic_points,
            target,
            pairs,
            joints: &joints,
        });
        let mut bones: Vec<BoneSummary> = judgements
            .into_iter()
            .enumerate()
            .map(|(b, judgement)| bone_summary(&skeleton, b, pairs, judgement))
            .collect();
        for (bone, found) in bones.iter_mut().zip(penetrations(&skeleton)) {
            bone.penetration = found.as_ref().map_or(0.0, |p| p.depth);
            bone.penetrates = found.map(|p| skeleton.bones[p.into].name.clone());
        }
        let judgement = judge_whole(&bones, explained, target.left_out);
        let notes = target.notes();
        let landmarks = target.landmarks.iter().map(|l| l.distance(&skeleton.points)).collect();
        let cancelled = false;
        Self {
            skeleton,
            elastic_points,
            scales,
            coefficients,
            bones,
            joints,
            levels,
            cancelled,
            judgement,
            landmarks,
            notes,
        }
    }

    /// Bones whose verdict is not good.
    pub fn named_bones(&self) -> usize {
        self.bones.iter().filter(|b| b.verdict > Verdict::Good).count()
    }

    /// Closest-point iterations of all levels.
    pub fn iterations(&self) -> usize {
        self.levels.iter().map(|l| l.iterations).sum()
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

fn joint_summaries(
    skeleton: &Skeleton,
    seams: &[f64],
    wanted: &[Isometry3<f64>],
) -> Vec<JointSummary> {
    let still = Isometry3::identity();
    skeleton
        .joints
        .iter()
        .zip(seams)
        .zip(wanted)
        .map(|((joint, &seam), wanted)| {
            let transform = joint.transform(&still, &still);
            let LimitState { rotation_usage, rotation_excess, shift, shift_excess } =
                limit_state(&joint.limits, &transform);
            let (a, b) =
                (joint.parent_frame.translation.vector, joint.child_frame.translation.vector);
            JointSummary {
                name: joint.name.clone(),
                centre: (a + b) / 2.0,
                rotation: super::rotation::rotation_vector(&transform.rotation),
                usage: rotation_usage,
                excess_degrees: rotation_excess.to_degrees(),
                shift,
                excess_shift: shift_excess,
                seam,
                wanted_rotation: super::rotation::rotation_vector(&wanted.rotation),
                wanted_excess_degrees: limit_state(&joint.limits, wanted)
                    .rotation_excess
                    .to_degrees(),
            }
        })
        .collect()
}
