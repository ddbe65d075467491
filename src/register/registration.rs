//! The main loop: closest points, elastic filter, plausible shapes, joint poses; coarse to fine.
//!
//! [G] Fig. 2. Departures, with their reasons in `docs/register.md`: shape and pose are updated in
//! every iteration, pairs that face away from each other are dropped, the levels are chosen from
//! the template's size, and a last level works bone by bone.

use nalgebra::Isometry3;

use super::areas::{mean_edge, vertex_areas};
use super::bone_scales::{BoneScales, ScaleFreedom, put_in_place};
use super::correspond::{Correspond, Correspondences, PairRules};
use super::elastic::{Elastic, whole_motion};
use super::fast_sums::FastSums;
use super::joint_frames::take_shape;
use super::options::{Clustering, Options, Schedule};
use super::pose::{BoneMoments, project_pose, rigid_targets, settle_tree};
use super::prealign::rigid_start;
use super::sampled_clusters::SampledClusters;
use super::skeleton::Skeleton;
use super::summary::{LevelTrace, Registered};
use super::target::Target;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::run::Run;

/// Weight of a vertex without a pair against one with a pair of the same area: it holds its place
/// only where nothing else does.
const UNSEEN_WEIGHT: f64 = 1e-6;
/// Sweeps over the joints at the end, so that loops close as well.
const FINAL_SWEEPS: usize = 100;

/// A template prepared for registration to many targets.
#[derive(Clone, Debug)]
pub struct Registration {
    template: Skeleton,
    areas: Vec<f64>,
    bone_of: Vec<u32>,
    diagonal: f64,
    options: Options,
    levels: Vec<Level>,
    scales: BoneScales,
}

/// One cluster size with its rules.
#[derive(Clone, Debug)]
struct Level {
    radius: f64,
    elastic: Elastic,
    rules: PairRules,
    freedom: ScaleFreedom,
    spacing: f64,
}

/// What the loop changes.
struct State {
    /// Reference points and joint frames.
    reference: Skeleton,
    /// The deformed points.
    points: Vec<Vec3>,
    scales: Vec<Vec3>,
}

/// Registers `template` to `target` in one call.
pub fn register(
    template: &Skeleton,
    target: &Target,
    options: &Options,
    run: &Run,
) -> Result<Registered> {
    Registration::new(template.clone(), options.clone())?.register(target, run)
}

impl Registration {
    /// Prepares clusters and shape model of the template.
    pub fn new(template: Skeleton, options: Options) -> Result<Self> {
        let areas = vertex_areas(&template.points, &template.triangles);
        let (low, high) = crate::mesh::bounding_box(&template.points)
            .ok_or_else(|| Error::invalid("the skeleton has no vertices"))?;
        let diagonal = (high - low).norm();
        if diagonal <= 0.0 || areas.iter().sum::<f64>() <= 0.0 {
            return Err(Error::invalid("the skeleton's surface has no area"));
        }
        let bone_of = template.bone_of_vertex();
        let scales = BoneScales::new(&template, &areas, options.scales);
        let mut registration =
            Self { template, areas, bone_of, diagonal, options, levels: Vec::new(), scales };
        registration.levels = registration.make_levels()?;
        Ok(registration)
    }

    fn make_levels(&self) -> Result<Vec<Level>> {
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
        }
        let finest = radii[radii.len() - 1];
        if self.options.refine_bones && finest.is_finite() {
            let rules =
                self.rules(self.options.last_min_cosine, Some(self.options.robust_factor));
            levels.push(self.level(finest, ScaleFreedom::PerAxis, rules, true)?);
        }
        Ok(levels)
    }

    fn rules(&self, min_cosine: f64, robust: Option<f64>) -> PairRules {
        PairRules {
            min_cosine,
            robust,
            robust_floor: 0.005 * self.diagonal,
            both_ways: self.options.both_ways,
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
            Clustering::Exact => {
                Elastic::Sampled(SampledClusters::new(points, radius.min(self.diagonal), 0.25, bone_of))
            }
            Clustering::Sampled { spacing } => {
                Elastic::Sampled(SampledClusters::new(points, radius.min(self.diagonal), spacing, bone_of))
            }
        };
        let freedom = freedom.min(self.options.scale_freedom);
        let reach = radius.min(self.diagonal / 3.0);
        Ok(Level { radius, elastic, rules, freedom, spacing: self.options.pair_spacing * reach })
    }

    /// Registers to one target. A cancelled run returns what it has, marked as such.
    pub fn register(&self, target: &Target, run: &Run) -> Result<Registered> {
        if target.is_labelled() && target.surfaces.len() != self.template.bones.len() {
            return Err(Error::invalid("the target was labelled for another skeleton"));
        }
        let mut state = self.start(target, run);
        let mut trace = Vec::new();
        for (k, level) in self.levels.iter().enumerate() {
            if run.is_cancelled() {
                break;
            }
            let share = |k: usize| 0.05 + 0.9 * k as f64 / self.levels.len() as f64;
            run.enter(&level.name(), share(k));
            trace.push(self.run_level(level, &mut state, target, run, [share(k), share(k + 1)]));
        }
        run.enter("joints and residuals", 0.95);
        self.finish(state, target, trace, run.is_cancelled())
    }

    fn start(&self, target: &Target, run: &Run) -> State {
        run.enter("rigid start", 0.0);
        let mut reference = self.template.clone();
        if self.options.align {
            let motion = rigid_start(&self.template, &self.areas, target);
            reference.move_bones(&vec![motion; reference.bones.len()]);
        }
        let scales = vec![Vec3::repeat(1.0); reference.bones.len()];
        State { points: reference.points.clone(), reference, scales }
    }

    fn run_level(
        &self,
        level: &Level,
        state: &mut State,
        target: &Target,
        run: &Run,
        shares: [f64; 2],
    ) -> LevelTrace {
        let triangles = &self.template.triangles;
        let mut search =
            Correspond::new(&state.reference, triangles, &self.areas, target, level.spacing);
        let mut trace = LevelTrace { radius: level.radius, ..LevelTrace::default() };
        let mut at_last_update = state.points.clone();
        let mut elastic_left = self.options.max_iterations;
        while trace.updates < self.options.max_iterations && !run.is_cancelled() {
            let pairs = search.at(&state.points, &level.rules);
            let masses = self.masses(&pairs);
            let update = self.options.schedule == Schedule::EveryIteration || elastic_left == 0;
            if update {
                self.update_reference(level, state, &pairs.wanted, &masses);
                trace.updates += 1;
                elastic_left = self.options.max_iterations;
            }
            let next = level.elastic.apply(&state.reference.points, &pairs.wanted, &masses);
            let before = if update { &at_last_update } else { &state.points };
            let still = self.largest_bone_move(before, &next) < self.options.tolerance * self.diagonal;
            if update {
                at_last_update.clone_from(&next);
            }
            state.points = next;
            trace.iterations += 1;
            trace.mean_distance = pairs.mean_distance;
            report(run, state, &trace, shares, self.options.max_iterations);
            match (still, update) {
                (true, true) => break,
                (true, false) => elastic_left = 0,
                (false, _) => elastic_left = elastic_left.saturating_sub(1),
            }
        }
        trace
    }

    fn masses(&self, pairs: &Correspondences) -> Vec<f64> {
        pairs.weight.iter().zip(&self.areas).map(|(w, area)| w + UNSEEN_WEIGHT * area).collect()
    }

    /// The plastic update: plausible shape, frames, joint pose.
    fn update_reference(&self, level: &Level, state: &mut State, wanted: &[Vec3], masses: &[f64]) {
        if level.freedom != ScaleFreedom::Fixed {
            state.scales = self.scales.fit(&self.template, wanted, masses, level.freedom);
            let shape = self.scales.shape(&self.template, &state.scales);
            let placed = put_in_place(&state.reference, &shape, &state.reference.points, &self.areas);
            take_shape(&mut state.reference, placed, &self.areas);
        }
        let motions = self.pose(&state.reference, wanted, masses, self.options.joint_sweeps);
        state.reference.move_bones(&motions);
    }

    /// The motions that carry the reference bones to `wanted` under the joints' limits.
    fn pose(
        &self,
        reference: &Skeleton,
        wanted: &[Vec3],
        masses: &[f64],
        sweeps: usize,
    ) -> Vec<Isometry3<f64>> {
        let whole = whole_motion(&reference.points, wanted, masses);
        let targets: Vec<Isometry3<f64>> = rigid_targets(reference, &reference.points, wanted, masses)
            .into_iter()
            .map(|t| t.unwrap_or(whole))
            .collect();
        if !self.options.use_joints {
            return targets;
        }
        project_pose(reference, &moments(reference, masses), &targets, sweeps).transforms
    }

    fn largest_bone_move(&self, before: &[Vec3], after: &[Vec3]) -> f64 {
        let mean = |range: std::ops::Range<usize>| {
            let count = range.len().max(1) as f64;
            range.map(|i| (after[i] - before[i]).norm()).sum::<f64>() / count
        };
        self.template.bones.iter().map(|b| mean(b.vertices.clone())).fold(0.0, f64::max)
    }

    /// The elastic shape becomes the reference, its frames follow, and the pose is put inside all
    /// limits; then the result is measured.
    fn finish(
        &self,
        state: State,
        target: &Target,
        levels: Vec<LevelTrace>,
        cancelled: bool,
    ) -> Result<Registered> {
        let State { mut reference, points, scales } = state;
        let placed = put_in_place(&reference, &points, &reference.points, &self.areas);
        take_shape(&mut reference, placed, &self.areas);
        let mut motions = self.pose(&reference, &points, &self.areas, FINAL_SWEEPS);
        if self.options.use_joints {
            let masses = moments(&reference, &self.areas);
            let heaviest = (0..masses.len()).max_by(|&a, &b| masses[a].mass.total_cmp(&masses[b].mass));
            settle_tree(&reference, heaviest.unwrap_or(0), &mut motions);
        }
        reference.move_bones(&motions);
        let rules = self.rules(0.0, None);
        let spacing = 0.0;
        let triangles = &self.template.triangles;
        let pairs = Correspond::new(&reference, triangles, &self.areas, target, spacing)
            .at(&reference.points, &rules);
        Ok(Registered::new(&self.template, reference, points, scales, &pairs, levels, cancelled))
    }
}

impl Level {
    fn name(&self) -> String {
        if self.radius.is_infinite() {
            "bones as rigid bodies".into()
        } else {
            format!("clusters of radius {:.3}", self.radius)
        }
    }
}

fn moments(reference: &Skeleton, masses: &[f64]) -> Vec<BoneMoments> {
    reference
        .bones
        .iter()
        .map(|b| {
            let range = b.vertices.clone();
            BoneMoments::new(&reference.points[range.clone()], &masses[range])
        })
        .collect()
}

fn report(run: &Run, state: &State, trace: &LevelTrace, shares: [f64; 2], most: usize) {
    let done = (trace.iterations as f64 / most as f64).min(1.0);
    run.update(|p| {
        p.fraction = shares[0] + (shares[1] - shares[0]) * done;
        p.iteration += 1;
        p.mean_error = trace.mean_distance;
    });
    run.publish_preview(&state.points);
}
