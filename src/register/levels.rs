//! The levels of the loop, coarse to fine: cluster sizes with their rules.

use super::areas::mean_edge;
use super::bone_scales::ScaleFreedom;
use super::elastic::Elastic;
use super::fast_sums::FastSums;
use super::level::Level;
use super::options::Clustering;
use super::pairs::PairRules;
use super::registration::Registration;
use super::sampled_clusters::SampledClusters;
use crate::error::{Error, Result};

/// Factor of the pull between bone scales from each level to the next coarser one: as long as bones
/// may lie on their neighbours, they must not change their length for it.
const EARLY_PULL: f64 = 3.0;

/// Tolerance of the levels before the last one that spans bones, against the final one: what they leave
/// open the next level closes. 3 saves a quarter of the iterations; with 6 one hand in fifteen went wrong.
const EARLY_TOLERANCE: f64 = 3.0;

/// Smallest radius of the levels for detail, against that of the levels before them: half an edge.
const FINEST_DETAIL: f64 = 0.4;

/// Tolerance of those levels, against the final one: small clusters go on slowly. Another person's leg ends
/// .27 mm off with 1, .23 with .1.
const DETAIL_TOLERANCE: f64 = 0.1;

/// Updates on each level on which the joints are springs: the next one goes on from there.
const SPRING_UPDATES: usize = 10;

/// Level after which bones that lie on their neighbours are looked for: the first on which each has its own size, so
/// that a bad fit is not one of size.
const REPAIRED_LEVEL: usize = 1;

/// Pairs shorter than this share of the template's diagonal do no harm, whosever they are.
const NEAR: f64 = 0.0003;

impl Registration {
    pub(super) fn make_levels(&self) -> Result<Vec<Level>> {
        let edge = mean_edge(&self.template.points, &self.template.triangles);
        let radii = self.options.radii(self.diagonal, edge);
        if radii.is_empty() || radii.iter().any(|r| r.is_nan() || *r <= 0.0) {
            return Err(Error::invalid("cluster radii must be above 0; give at least one"));
        }
        let mut levels = Vec::new();
        for (k, &radius) in radii.iter().enumerate() {
            let freedom = match k {
                0 => ScaleFreedom::Whole,
                1 => ScaleFreedom::PerBone,
                _ => ScaleFreedom::PerAxis,
            };
            let rules = self.rules(self.options.min_cosine, None);
            levels.push(self.level(radius, freedom, rules, self.options.separate_bones)?);
            levels[k].scale_pull = EARLY_PULL.powi((radii.len() - 1 - k).min(3) as i32);
        }
        let coarser = levels.len() - 1;
        for level in &mut levels[..coarser] {
            level.tolerance_factor = EARLY_TOLERANCE;
        }
        let coarsest = radii[radii.len() - 1];
        let finest = self.options.finest_in_edges * edge;
        let smallest = coarsest.min(finest * FINEST_DETAIL);
        let mut radius = coarsest;
        while self.options.refine_bones && radius.is_finite() && radius >= smallest {
            let rules = self.rules(self.options.last_min_cosine, Some(self.options.robust_factor));
            let mut level = self.level(radius, ScaleFreedom::PerAxis, rules, true)?;
            level.for_detail = radius < finest.min(coarsest);
            if level.for_detail {
                level.tolerance_factor = DETAIL_TOLERANCE;
            }
            levels.push(level);
            radius /= 2.0;
        }
        for (k, level) in levels.iter_mut().enumerate() {
            if k == 0 {
                level.rules.taken = 0.0;
            }
            level.rules.landmark_radius = if level.bones_apart { 0.0 } else { level.radius };
            level.repaired = k == REPAIRED_LEVEL && self.options.use_joints;
        }
        Ok(self.spring_levels(&levels[0]).chain(levels.iter().cloned()).collect())
    }

    /// The levels on which the joints are springs, otherwise like the first one.
    fn spring_levels<'a>(&'a self, first: &'a Level) -> impl Iterator<Item = Level> + 'a {
        let springs = self.options.springs.iter().filter(|_| self.options.use_joints);
        springs.map(|&softness| Level {
            most_updates: SPRING_UPDATES.min(first.most_updates),
            springs: Some(softness),
            freedom: ScaleFreedom::Fixed,
            repaired: false,
            ..first.clone()
        })
    }

    pub(super) fn rules(&self, min_cosine: f64, robust: Option<f64>) -> PairRules {
        PairRules {
            min_cosine,
            robust,
            robust_floor: 0.005 * self.diagonal,
            both_ways: self.options.both_ways,
            taken: self.options.taken_factor,
            near: NEAR * self.diagonal,
            reach: self.options.image_reach[1] * self.diagonal,
            landmark_radius: 0.0,
        }
    }

    fn level(
        &self,
        radius: f64,
        freedom: ScaleFreedom,
        rules: PairRules,
        bones_apart: bool,
    ) -> Result<Level> {
        let (points, triangles) = (&self.template.points, &self.template.triangles);
        let bone_of = bones_apart.then_some(self.bone_of.as_slice());
        let elastic = match self.options.clustering {
            _ if radius.is_infinite() && !bones_apart => Elastic::Rigid,
            Clustering::Exact if !bones_apart => {
                Elastic::Exact(FastSums::new(points, triangles, radius)?)
            }
            Clustering::Exact => Elastic::Sampled(SampledClusters::new(
                points,
                radius.min(self.diagonal),
                0.25,
                bone_of,
            )),
            Clustering::Sampled { spacing } => Elastic::Sampled(SampledClusters::new(
                points,
                radius.min(self.diagonal),
                spacing,
                bone_of,
            )),
        };
        let freedom = freedom.min(self.options.scale_freedom);
        let spacing =
            (self.options.pair_spacing * radius).min(self.options.coarsest_pairs * self.diagonal);
        Ok(Level {
            radius,
            elastic,
            rules,
            freedom,
            scale_pull: 1.0,
            for_detail: false,
            bones_apart,
            spacing,
            tolerance_factor: 1.0,
            most_updates: self.options.max_iterations,
            springs: None,
            repaired: false,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::register::options::{Levels, Options};
    use crate::register::skeleton::Skeleton;
    use crate::register::skeleton::tests::block;

    #[test]
    fn bones_are_taken_apart_at_the_last_given_radius_however_small() {
        let bone = block(Vec3::zeros(), Vec3::new(5.0, 2.0, 2.0), 4);
        let skeleton = Skeleton::new(vec![("a".into(), bone)], vec![]).unwrap();
        for radius in [0.01, 3.0, 100.0] {
            let levels = Levels::Radii(vec![f64::INFINITY, radius]);
            let options = Options { levels, ..Options::default() };
            let registration = Registration::new(skeleton.clone(), options).unwrap();
            let apart = registration.levels.iter().find(|level| level.bones_apart).unwrap();
            assert!((apart.radius - radius).abs() < 1e-12 && !apart.for_detail, "{}", apart.radius);
        }
    }
}
