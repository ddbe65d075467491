//! One level of the loop.

use super::bone_scales::ScaleFreedom;
use super::elastic::Elastic;
use super::pairs::PairRules;

/// One cluster size with its rules.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub(super) radius: f64,
    pub(super) elastic: Elastic,
    /// Only where what is left to the target is shape, not noise.
    pub(super) for_detail: bool,
    /// No cluster spans bones: each has found its place.
    pub(super) bones_apart: bool,
    pub(super) rules: PairRules,
    pub(super) freedom: ScaleFreedom,
    /// Strength of the pull of bone scales towards each other against the final one.
    pub(super) scale_pull: f64,
    pub(super) spacing: f64,
    /// What counts as rest, against the options' tolerance.
    pub(super) tolerance_factor: f64,
    /// Updates at most.
    pub(super) most_updates: usize,
    /// The joints are springs, not walls, see [`Options::springs`](super::options::Options::springs).
    pub(super) springs: Option<f64>,
    /// Bones that lie on their neighbours are looked for after it; on finer levels the elastic shape hides
    /// them.
    pub(super) repaired: bool,
}

impl Level {
    pub(super) fn name(&self) -> String {
        if let Some(softness) = self.springs {
            format!("bones on springs, {:.1} % soft", 100.0 * softness)
        } else if self.radius.is_infinite() {
            "bones as rigid bodies".into()
        } else {
            format!("clusters of radius {:.3}", self.radius)
        }
    }
}
