//! Where the loop starts: the best of some poses, and other poses for branches that went wrong.

use nalgebra::Isometry3;

use super::attempts::Attempt;
use super::correspond::Correspond;
use super::landmarks::{PlacedLandmark, rigid_motion, rms_after};
use super::level::Level;
use super::pose_starts::{branches, towards_mid_range};
use super::prealign::rigid_starts;
use super::registration::{Registration, State};
use super::skeleton::Skeleton;
use super::spring_pose::SpringPose;
use super::springs::{Pull, joint_turns};
use super::target::Target;
use crate::math::median;
use crate::run::Run;

/// Distance of a landmark that counts as much as a joint turned by its whole range, as a share of the
/// template's diagonal.
const LANDMARK_DISTANCE: f64 = 0.005;
/// Updates that tell a good starting pose from a bad one.
const START_UPDATES: usize = 10;
/// A pose replaces another only when the pairs' distance falls to this share,
const CLEARLY_BETTER: f64 = 0.95;
/// or that of the bones that were moved to this one, and the whole is not worse.
const BONES_BETTER: f64 = 0.75;
/// Rounds of repair.
const REPAIR_ROUNDS: usize = 3;
/// A bone is tried in other poses when it fits this many times worse than the middle bone.
const BAD_FIT: f64 = 2.5;
/// And this far from its surface, as a share of the template's diagonal.
const BAD_DISTANCE: f64 = 0.005;
/// Poses tried, as shares of the way to the middle of the range.
const REPAIR_SHARES: [f64; 5] = [0.0, 0.4, 0.8, 1.2, 1.6];
/// Spacing of the pairs meanwhile, as a share of the template's diagonal.
pub(super) const START_SPACING: f64 = 0.03;

/// Distances of the pairs, dropped ones too.
struct Misfit {
    rms: f64,
    of_bone: Vec<f64>,
}

impl Misfit {
    /// Whether the bones marked in `moved` are worth their new pose.
    fn clearly_better(&self, before: &Self, moved: &[bool]) -> bool {
        let worst = |misfit: &Self| {
            let own = misfit.of_bone.iter().zip(moved).filter(|(_, moved)| **moved);
            own.fold(0.0_f64, |worst, (r, _)| worst.max(*r))
        };
        self.rms < CLEARLY_BETTER * before.rms
            || self.rms < before.rms && worst(self) < BONES_BETTER * worst(before)
    }
}

impl Registration {
    /// The template in each starting pose, laid on the target in some ways, best first.
    pub(super) fn starts(&self, target: &Target) -> Vec<Vec<Skeleton>> {
        let mut poses = self.options.pose_starts.clone();
        if poses.is_empty() || !self.options.use_joints {
            poses = vec![0.0];
        }
        poses.iter().map(|&share| self.placed(target, share)).collect()
    }

    /// The template in one pose, laid on the target.
    fn placed(&self, target: &Target, share: f64) -> Vec<Skeleton> {
        let mut posed = self.template.clone();
        let all = vec![true; posed.bones.len()];
        let motions = towards_mid_range(&self.template, &posed, self.root, &all, share);
        posed.move_bones(&motions);
        if !self.options.align || target.image.is_some() {
            return vec![self.posed_by_landmarks(posed, target)];
        }
        let moved = |motion| {
            let mut placed = posed.clone();
            placed.move_bones(&vec![motion; posed.bones.len()]);
            self.posed_by_landmarks(placed, target)
        };
        self.rigid_motions(&posed, target).into_iter().map(moved).collect()
    }

    /// The skeleton bent so that it comes near the landmarks.
    fn posed_by_landmarks(&self, mut skeleton: Skeleton, target: &Target) -> Skeleton {
        let landmarks = target.landmarks.as_slice();
        if landmarks.is_empty() || !self.options.use_joints {
            return skeleton;
        }
        let pull = |landmark: &PlacedLandmark| Pull {
            bone: landmark.bone,
            place: landmark.place(&skeleton.points),
            goal: landmark.target,
            weight: landmark.weight / (LANDMARK_DISTANCE * self.diagonal).powi(2),
        };
        let (rest, pulls) = (joint_turns(&skeleton), landmarks.iter().map(pull).collect());
        let found = SpringPose::new(&skeleton, self.diagonal, &rest, pulls, false).solve();
        if let Ok(posed) = found {
            posed.carry(&mut skeleton);
        }
        skeleton
    }

    /// Ways to lay a pose on the target, best first: as the landmarks say, or those that fit the
    /// surface, the ones nearer to the landmarks first.
    fn rigid_motions(&self, posed: &Skeleton, target: &Target) -> Vec<Isometry3<f64>> {
        let landmarks = target.landmarks.as_slice();
        if let Some(motion) = rigid_motion(landmarks, &posed.points, self.diagonal) {
            return vec![motion];
        }
        let mut motions = rigid_starts(posed, &self.areas, target);
        if !landmarks.is_empty() {
            let far = |motion: &Isometry3<f64>| rms_after(landmarks, &posed.points, motion);
            motions.sort_by(|a, b| far(a).total_cmp(&far(b)));
        }
        motions
    }

    /// Tries the starting poses with rigid bones, keeps the one that comes nearest. None where there is
    /// no such start.
    pub(super) fn start(
        &self,
        starts: &[Vec<Skeleton>],
        attempt: Attempt,
        search: &mut Correspond,
        run: &Run,
    ) -> Option<State> {
        attempt.enter(run, "rigid start", 0.0);
        let mut best: Option<(f64, State)> = None;
        for placed in starts {
            let mut state = State::at(placed.get(attempt.start)?.clone());
            let mut distance = 0.0;
            if starts.len() > 1 {
                distance = self
                    .run_level(self.first_rigid(), attempt, search, &mut state, run, START_UPDATES)
                    .rms_distance;
            }
            if best.as_ref().is_none_or(|(least, _)| distance < *least) {
                best = Some((distance, state));
            }
        }
        best.map(|(_, state)| state)
    }

    /// Finds bones that fit much worse than the others and tries other poses for the branches that
    /// hang on them: two fingers that have exchanged their tips do not come apart by themselves.
    pub(super) fn repair(
        &self,
        level: &Level,
        attempt: Attempt,
        search: &mut Correspond,
        state: &mut State,
        run: &Run,
    ) {
        let Some(mut best) = self.misfit(search, state) else { return };
        for _ in 0..REPAIR_ROUNDS {
            let heads = self.badly_fitted(&best);
            let branches = branches(&self.template, self.root, &heads);
            if branches.is_empty() || run.is_cancelled() {
                return;
            }
            let all = (0..heads.len()).map(|b| branches.iter().any(|marks| marks[b])).collect();
            let before = best.rms;
            for marks in std::iter::once(all).chain(branches) {
                if !self.badly_fitted(&best).contains(&true) {
                    return;
                }
                for share in REPAIR_SHARES {
                    let mut other = state.clone();
                    let motions = towards_mid_range(
                        &self.template,
                        &other.reference,
                        self.root,
                        &marks,
                        share,
                    );
                    other.reference.move_bones(&motions);
                    other.points.clone_from(&other.reference.points);
                    self.run_level(level, attempt, search, &mut other, run, START_UPDATES);
                    if let Some(misfit) = self.misfit(search, &other)
                        && misfit.clearly_better(&best, &marks)
                    {
                        best = misfit;
                        *state = other;
                    }
                }
            }
            if best.rms > CLEARLY_BETTER * before {
                return;
            }
        }
    }

    /// Bones whose pairs are much farther than those of the middle bone, and far in themselves.
    fn badly_fitted(&self, misfit: &Misfit) -> Vec<bool> {
        let known = misfit.of_bone.iter().copied().filter(|r| r.is_finite());
        let middle = median(known).unwrap_or(f64::INFINITY);
        let far = (BAD_FIT * middle).max(BAD_DISTANCE * self.diagonal);
        misfit.of_bone.iter().map(|&r| r > far).collect()
    }

    /// The first level after those with springs.
    fn first_rigid(&self) -> &Level {
        let rigid = self.levels.iter().find(|level| level.springs.is_none());
        rigid.unwrap_or(&self.levels[0])
    }

    /// Root mean square pair distances of the deformed shape; `None` without pairs.
    fn misfit(&self, search: &mut Correspond, state: &State) -> Option<Misfit> {
        let pairs = search.at(&state.points, &self.first_rigid().rules);
        let of_bone =
            self.template.bones.iter().map(|b| pairs.rms_over(b.vertices.clone())).collect();
        let rms = pairs.rms_distance;
        rms.is_finite().then_some(Misfit { rms, of_bone })
    }
}
