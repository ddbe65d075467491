//! The main loop: closest points, elastic filter, plausible shapes, joint poses; coarse to fine.
//!
//! [G] Fig. 2. Departures, with their reasons in `docs/register.md`: shape and pose are updated in
//! every iteration, pairs that face away from each other are dropped, the levels are chosen from
//! the template's size, and a last level works bone by bone.

use std::time::Instant;

use super::attempts::Attempt;
use super::correspond::{Correspond, Correspondences};
use super::detail;
use super::level::Level;
use super::options::{Options, Schedule};
use super::owners::{Owned, Pieces};
use super::pairs::{FOLLOWING, PairRules, UNSEEN_WEIGHT};
use super::piece_match::PieceMatch;
use super::pieces::without_far_parts;
use super::registration::{Registration, State};
use super::skeleton::Skeleton;
use super::springs::joint_turns;
use super::start::START_SPACING;
use super::summary::{LevelTrace, Registered};
use super::target::Target;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::adjacency::edges;
use crate::run::Run;

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
    /// Registers to one target. A cancelled run returns what it has, marked as such. A target that is in
    /// another unit or a mirror image is refused, unless the options say that it is meant.
    pub fn register(&self, target: &Target, run: &Run) -> Result<Registered> {
        if target.is_labelled() && target.surfaces.len() != self.template.bones.len() {
            return Err(Error::invalid("the target was labelled for another skeleton"));
        }
        let refuses = !self.options.as_is && target.image.is_none();
        if refuses {
            self.refuse_other_unit(target)?;
        }
        let attempt = Attempt::first(target);
        attempt.enter(run, "rigid start", 0.0);
        let starts = self.starts(target);
        let found = self
            .find(target, &starts, attempt, run)
            .ok_or_else(|| Error::invalid("the template cannot be laid on the target"))?;
        if found.cancelled || target.image.is_some() {
            return Ok(found);
        }
        if refuses {
            self.refuse_mirrored(&found, target, run)?;
        }
        Ok(self.best_of_attempts(found, target, &starts, run))
    }

    /// The loop, from one of `starts`; none where there is no such start.
    pub(super) fn find(
        &self,
        target: &Target,
        starts: &[Vec<Skeleton>],
        attempt: Attempt,
        run: &Run,
    ) -> Option<Registered> {
        let mut search_coarse = self.coarse_search(target);
        let state = self.start(starts, attempt, &mut search_coarse, run)?;
        let near =
            without_far_parts(target, &state.points, &self.template.triangles, self.diagonal);
        let target = near.as_ref().unwrap_or(target);
        if let Some(image) = &target.image {
            let (state, trace) = self.find_in_image(image, state, target, run);
            run.enter("joints and residuals", 0.95);
            return Some(self.finish(state, target, trace, run.is_cancelled()));
        }
        if near.is_some() {
            search_coarse = self.coarse_search(target);
        }
        Some(self.find_from(state, None, search_coarse, target, attempt, run))
    }

    /// The levels, from a state on. `in_pieces`: pieces of the target that each bone begins with, and how they are
    /// given out again after each level; there are no springs then, and no repair.
    pub(super) fn find_from(
        &self,
        mut state: State,
        in_pieces: Option<(Owned, &PieceMatch)>,
        mut search_coarse: Correspond,
        target: &Target,
        attempt: Attempt,
        run: &Run,
    ) -> Registered {
        let pieces = self.pieces(target);
        let (mut owned, matches) = in_pieces.unzip();
        let told_apart = target.is_labelled() || matches.is_some();
        let usable = |level: &&Level| level.springs.is_none() || !told_apart;
        let levels: Vec<&Level> = self.levels.iter().filter(usable).collect();
        let mut trace = Vec::new();
        let (template, areas) = (&self.template, &self.areas);
        let mut whole = search_coarse.clone();
        for (k, level) in levels.iter().enumerate() {
            if run.is_cancelled() {
                break;
            }
            attempt.enter(run, &level.name(), 0.15 + 0.8 * k as f64 / levels.len() as f64);
            if whole.spacing().total_cmp(&level.spacing).is_ne() {
                whole = search_coarse.resampled(&template.points, areas, level.spacing);
            }
            let mut search = match &owned {
                Some(owned) => {
                    Correspond::of_parts(template, areas, target, owned.parts(), level.spacing)
                }
                None => whole.clone(),
            };
            if level.for_detail && !self.has_detail_left(&mut search, &state.points, level) {
                break;
            }
            let most = level.most_updates;
            trace.push(self.run_level(level, attempt, &mut search, &mut state, run, most));
            if level.repaired && matches.is_none() {
                self.repair(level, attempt, &mut search_coarse, &mut state, run);
            }
            if let Some(pieces) = pieces.as_ref().filter(|_| level.springs.is_none()) {
                let points = &state.points;
                owned = Some(match matches {
                    Some(matches) => pieces.owned_by(matches.at(points).owners),
                    None => pieces.shared_out(&mut whole, points, &level.rules, owned.take()),
                });
            }
        }
        attempt.enter(run, "joints and residuals", 0.95);
        self.finish(state, target, trace, run.is_cancelled())
    }

    /// The search for the start and for repairs.
    pub(super) fn coarse_search<'a>(&'a self, target: &'a Target) -> Correspond<'a> {
        self.search(target, START_SPACING * self.diagonal)
    }

    pub(super) fn search<'a>(&'a self, target: &'a Target, spacing: f64) -> Correspond<'a> {
        Correspond::new(&self.template, &self.areas, target, spacing)
    }

    /// The pieces of a target that does not tell bones apart.
    pub(super) fn pieces<'a>(&self, target: &'a Target) -> Option<Pieces<'a>> {
        self.options.own_pieces.then(|| Pieces::new(target, self.template.bones.len())).flatten()
    }

    /// Whether a finer level would follow the target's shape, not its noise.
    fn has_detail_left(&self, search: &mut Correspond, points: &[Vec3], level: &Level) -> bool {
        let pairs = search.at(points, &level.rules);
        let edges = edges(&self.template.triangles);
        detail::is_left(&pairs, points, &edges, self.options.tolerance * self.diagonal)
    }

    pub(super) fn run_level(
        &self,
        level: &Level,
        attempt: Attempt,
        search: &mut Correspond,
        state: &mut State,
        run: &Run,
        most_updates: usize,
    ) -> LevelTrace {
        let mut trace = LevelTrace { radius: level.radius, ..LevelTrace::default() };
        let rules = PairRules {
            robust: level.rules.robust.or(attempt.robust),
            reach: attempt.reach.unwrap_or(level.rules.reach),
            ..level.rules
        };
        let started = Instant::now();
        let mut at_last_update = state.points.clone();
        let mut before_last = state.points.clone();
        let mut elastic_left = self.options.max_iterations;
        self.limit_joints(level, state);
        state.rest = joint_turns(&state.reference);
        while trace.updates < most_updates && !run.is_cancelled() {
            let mut pairs = search.at(&state.points, &rules);
            if search.image().is_none() {
                let drift = state.points.iter().zip(&before_last).map(|(now, before)| now - before);
                pairs.slide_on(drift, self.options.momentum);
            }
            let mut masses = self.masses(&pairs);
            let update = match self.options.schedule {
                Schedule::EveryIteration => true,
                Schedule::AfterElastic => elastic_left == 0,
                Schedule::Never => false,
            };
            if update {
                self.update_reference(level, state, &pairs, &masses);
                // What an image does not show may only be out of reach yet.
                let hold = if search.image().is_some() { 0.0 } else { FOLLOWING };
                pairs.rest_on(&state.reference.points, hold, &mut masses);
                trace.updates += 1;
                elastic_left = self.options.max_iterations;
            }
            let next = level.elastic.apply(&state.reference.points, &pairs.wanted, &masses);
            let before = if update { &at_last_update } else { &state.points };
            let still = self.largest_bone_move(before, &next)
                < level.tolerance_factor * self.options.tolerance * self.diagonal;
            if update {
                at_last_update.clone_from(&next);
            }
            before_last = std::mem::replace(&mut state.points, next);
            trace.iterations += 1;
            trace.mean_distance = pairs.mean_distance;
            trace.rms_distance = pairs.rms_distance;
            run.update(|p| {
                p.iteration += 1;
                p.mean_error = trace.mean_distance;
            });
            run.publish_preview(&state.points);
            match (still, update) {
                (true, true) => break,
                (true, false) => elastic_left = 0,
                (false, _) => elastic_left = elastic_left.saturating_sub(1),
            }
            if self.options.schedule == Schedule::Never && elastic_left == 0 {
                break;
            }
        }
        trace.seconds = started.elapsed().as_secs_f64();
        trace
    }

    fn masses(&self, pairs: &Correspondences) -> Vec<f64> {
        pairs.weight.iter().zip(&self.areas).map(|(w, area)| w + UNSEEN_WEIGHT * area).collect()
    }

    pub(super) fn largest_bone_move(&self, before: &[Vec3], after: &[Vec3]) -> f64 {
        let mean = |range: std::ops::Range<usize>| {
            let count = range.len().max(1) as f64;
            range.map(|i| (after[i] - before[i]).norm()).sum::<f64>() / count
        };
        self.template.bones.iter().map(|b| mean(b.vertices.clone())).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;
    use crate::register::joint_limits::{JointLimits, Limits};
    use crate::register::skeleton::tests::{block, joint_at};

    fn two_bones() -> Skeleton {
        let sides = Vec3::new(0.3, 0.1, 1.2);
        let limits = JointLimits::new(Vec3::new(0.3, 0.1, 0.2), sides, 0.5).unwrap();
        let a = block(Vec3::zeros(), Vec3::new(10.0, 2.0, 3.0), 10);
        let b = block(Vec3::new(18.0, 0.0, 0.0), Vec3::new(7.0, 1.5, 2.5), 10);
        let joint = joint_at("ab", [0, 1], Vec3::new(10.5, 0.0, 0.0), limits);
        Skeleton::new(vec![("a".into(), a), ("b".into(), b)], vec![joint]).unwrap()
    }

    fn union(skeleton: &Skeleton) -> crate::mesh::TriMesh {
        crate::mesh::TriMesh::new(skeleton.points.clone(), skeleton.triangles.clone()).unwrap()
    }

    #[test]
    fn the_template_itself_as_target_changes_nothing() {
        let template = two_bones();
        let target = Target::whole(union(&template)).unwrap();
        let found = register(&template, &target, &Options::default(), &Run::new()).unwrap();
        let moves = found.skeleton.points.iter().zip(&template.points).map(|(a, b)| (a - b).norm());
        assert!(moves.fold(0.0, f64::max) < 1e-6);
        let frame = found.skeleton.joints[0].child_frame.translation.vector;
        assert!((frame - Vec3::new(10.5, 0.0, 0.0)).norm() < 1e-6);
        assert!(!found.cancelled && found.levels.iter().all(|l| l.iterations <= 2));
    }

    #[test]
    fn a_bent_and_moved_skeleton_is_found_with_and_without_labels() {
        let template = two_bones();
        let mut bent = template.clone();
        let turn = nalgebra::UnitQuaternion::from_scaled_axis(Vec3::new(0.0, 0.0, 0.7));
        let joint_point = Vec3::new(10.5, 0.0, 0.0);
        let bend =
            crate::register::rotation::turned_about(&Isometry3::identity(), &joint_point, turn);
        bent.move_bones(&[Isometry3::identity(), bend]);
        let away = Isometry3::new(Vec3::new(40.0, -20.0, 5.0), Vec3::new(0.5, 1.0, 1.5));
        bent.move_bones(&[away, away]);
        let labelled = (0..2)
            .map(|b| (bent.bones[b].name.clone(), bent.bone_surface(b, &bent.points)))
            .collect();
        for target in
            [Target::whole(union(&bent)).unwrap(), Target::per_bone(&template, labelled).unwrap()]
        {
            let found = register(&template, &target, &Options::default(), &Run::new()).unwrap();
            // Blocks look the same from several sides: compare surfaces, and the joint's angle.
            assert!(found.bones.iter().all(|b| b.mean_residual < 0.05), "{:?}", found.bones);
            assert!((found.joints[0].rotation.norm() - 0.7).abs() < 0.05, "{:?}", found.joints);
            assert!(found.joints[0].excess_degrees < 1e-6 && found.joints[0].excess_shift < 1e-9);
        }
    }

    #[test]
    fn limits_are_soft_or_walls_or_nothing_and_a_joint_may_have_a_rule_of_its_own() {
        let template = two_bones();
        let found = |angle: f64, limits: Limits, rule: Option<Limits>| {
            let mut bent = template.clone();
            let turn = nalgebra::UnitQuaternion::from_scaled_axis(Vec3::new(0.0, 0.0, -angle));
            let at = Vec3::new(10.5, 0.0, 0.0);
            let bend = crate::register::rotation::turned_about(&Isometry3::identity(), &at, turn);
            bent.move_bones(&[Isometry3::identity(), bend]);
            let mut template = template.clone();
            template.joints[0].limits.rule = rule;
            let options = Options { align: false, limits, ..Options::default() };
            let target = Target::whole(union(&bent)).unwrap();
            let found = register(&template, &target, &options, &Run::new()).unwrap();
            assert_eq!(found.skeleton.joints[0].limits, template.joints[0].limits);
            (found.joints[0].rotation.norm(), found.joints[0].excess_degrees)
        };
        // The range ends at 0.2 radians, the slack at 0.375.
        let (angle, beyond) = found(0.3, Limits::Soft, None);
        assert!((angle - 0.3).abs() < 0.01 && (beyond - 5.7).abs() < 0.6, "{angle} {beyond}");
        let walls = [found(0.3, Limits::Hard, None), found(0.3, Limits::Soft, Some(Limits::Hard))];
        assert!(walls.iter().all(|(angle, beyond)| *angle < 0.21 && *beyond < 1e-6), "{walls:?}");
        let [soft, free] = [Limits::Soft, Limits::None].map(|limits| found(0.45, limits, None).0);
        assert!(soft < 0.38 && (free - 0.45).abs() < 0.01, "{soft} {free}");
    }

    #[test]
    fn a_cancelled_run_returns_the_template_where_it_lies() {
        let template = two_bones();
        let target = Target::whole(union(&template)).unwrap();
        let run = Run::new();
        run.cancel();
        let found = register(&template, &target, &Options::default(), &run).unwrap();
        assert!(found.cancelled && found.levels.is_empty());
    }
}
