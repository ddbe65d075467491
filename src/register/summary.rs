//! What a registration found, and how well it fits.

use serde::Serialize;

use super::skeleton::Skeleton;
use super::verdict::{Judgement, Verdict};
use crate::math::Vec3;

/// A registered skeleton.
#[derive(Clone, Debug)]
pub struct Registered {
    /// The person's bones (template vertex order) and joint frames, inside their limits or as far
    /// beyond as these give way.
    pub skeleton: Skeleton,
    /// The elastic shape before its joints were put inside their limits.
    pub elastic_points: Vec<Vec3>,
    /// Scales of every bone along its principal axes, where no shape model was used.
    pub scales: Vec<Vec3>,
    /// Coefficients of the shape model, in standard deviations, where one was used.
    pub coefficients: Vec<f64>,
    /// How each bone fits.
    pub bones: Vec<BoneSummary>,
    /// For each vertex whether it lies on the target, 1 or 0; in an image, how far it finds something like
    /// it, 0 to 1. Where the target shows nothing the shape is a guess.
    pub seen: Vec<f64>,
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

/// The fit of one bone; lengths in the template's unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
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
    /// Distance at which the data alone would leave the two joint points, template unit.
    pub seam: f64,
    /// Rotation vector that the data alone would give it, radians.
    pub wanted_rotation: Vec3,
    /// Rotation beyond the limit that the data alone would give it, degrees.
    pub wanted_excess_degrees: f64,
    /// Where the data alone would leave the child's joint point, seen from the parent's frame, template unit.
    pub wanted_shift: Vec3,
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
    /// Bones whose verdict is not good.
    pub fn named_bones(&self) -> usize {
        self.bones.iter().filter(|b| b.verdict > Verdict::Good).count()
    }

    /// Closest-point iterations of all levels.
    pub fn iterations(&self) -> usize {
        self.levels.iter().map(|l| l.iterations).sum()
    }
}
