//! Levels in an image: no level ends less like the image than it began, how far to search is found by trying,
//! and the search begins again from where it ended.

use super::attempts::Attempt;
use super::correspond::Correspond;
use super::elastic::whole_motion;
use super::image::ImageTarget;
use super::level::Level;
use super::registration::{Registration, State};
use super::skeleton::Skeleton;
use super::summary::LevelTrace;
use super::target::Target;
use crate::math::Vec3;
use crate::run::Run;

/// How often a run begins again at most.
const AGAIN: usize = 10;
impl Registration {
    /// Goes over the levels on which bones are rigid, again and again with the beginning laid as a whole on
    /// what was found, as long as that ends elsewhere and more like the image; then over the finer ones.
    /// What lay too far off at first comes nearer each time.
    pub(super) fn find_in_image(
        &self,
        image: &ImageTarget,
        mut state: State,
        target: &Target,
        run: &Run,
    ) -> (State, Vec<LevelTrace>) {
        // What is noise and what is shape between bones and an image, nothing tells.
        let levels = &self.levels[..self.levels.partition_point(|level| !level.for_detail)];
        let (rigid, finer) =
            levels.split_at(levels.partition_point(|level| level.radius.is_infinite()));
        let begin = state.reference.clone();
        let likeness = |state: &State| image.likeness(&state.points, &begin.triangles);
        let mut trace = self.go_over(rigid, Attempt::IN_IMAGE, target, &mut state, run);
        let mut liked = likeness(&state);
        let mut attempt = Attempt::IN_IMAGE_AGAIN;
        for _ in 0..AGAIN {
            if run.is_cancelled() {
                break;
            }
            let mut other = State::at(self.laid_on(&state.points, &liked, &begin));
            let other_trace = self.go_over(rigid, attempt, target, &mut other, run);
            let likeness = likeness(&other);
            if !self.is_better(&likeness, &liked) {
                break;
            }
            let apart = self.largest_bone_move(&state.points, &other.points);
            (state, trace, liked) = (other, other_trace, likeness);
            if apart < self.options.image_reach[1] * self.diagonal {
                break;
            }
            attempt = attempt.followed();
        }
        trace.extend(self.go_over(finer, Attempt::FINER_IN_IMAGE, target, &mut state, run));
        (state, trace)
    }

    fn go_over(
        &self,
        levels: &[Level],
        attempt: Attempt,
        target: &Target,
        state: &mut State,
        run: &Run,
    ) -> Vec<LevelTrace> {
        let mut trace = Vec::new();
        for (k, level) in levels.iter().enumerate() {
            if run.is_cancelled() {
                break;
            }
            attempt.enter(run, &level.name(), k as f64 / levels.len() as f64);
            let mut search = self.search(target, level.spacing);
            trace.push(self.go_through(level, attempt, &mut search, state, run));
        }
        trace
    }

    /// `begin` as one body where `points` are; what is most like the image weighs most.
    fn laid_on(&self, points: &[Vec3], likeness: &[Option<f64>], begin: &Skeleton) -> Skeleton {
        let weight = |(like, area): (&Option<f64>, &f64)| area * like.unwrap_or(0.0).max(0.0);
        let weights: Vec<f64> = likeness.iter().zip(&self.areas).map(weight).collect();
        let motion = whole_motion(&begin.points, points, &weights);
        let mut skeleton = begin.clone();
        skeleton.move_bones(&vec![motion; skeleton.bones.len()]);
        skeleton
    }

    /// Goes through a level. In an image it is gone through with each reach from the longest to the
    /// shortest, each half of the one before; what is most like the image is kept, the state before the level
    /// included.
    pub(super) fn go_through(
        &self,
        level: &Level,
        attempt: Attempt,
        search: &mut Correspond,
        state: &mut State,
        run: &Run,
    ) -> LevelTrace {
        let most = level.most_updates;
        let Some(image) = search.image() else {
            return self.run_level(level, attempt, search, state, run, most);
        };
        let [mut reach, shortest] = self.options.image_reach.map(|share| share * self.diagonal);
        let begin = state.clone();
        let triangles = &self.template.triangles;
        let mut liked = image.likeness(&begin.points, triangles);
        let mut kept = LevelTrace { radius: level.radius, ..LevelTrace::default() };
        loop {
            let mut other = begin.clone();
            let attempt = attempt.searching(reach);
            let trace = self.run_level(level, attempt, search, &mut other, run, most);
            let likeness = image.likeness(&other.points, triangles);
            if self.is_better(&likeness, &liked) {
                (liked, kept, *state) = (likeness, trace, other);
            }
            if run.is_cancelled() || reach <= shortest {
                return kept;
            }
            reach = (0.5 * reach).max(shortest);
        }
    }

    /// Whether a shape is more like the image than another, over the vertices of which both can say it.
    fn is_better(&self, likeness: &[Option<f64>], before: &[Option<f64>]) -> bool {
        let gain = |i: usize| Some(self.areas[i] * (likeness[i]? - before[i]?));
        (0..self.areas.len()).filter_map(gain).sum::<f64>() > 0.0
    }
}
