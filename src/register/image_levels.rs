//! Levels in an image: no level ends less like the image than it began, and how far to search is found by
//! trying.

use super::attempts::Attempt;
use super::correspond::Correspond;
use super::image::ImageTarget;
use super::level::Level;
use super::registration::{Registration, State};
use super::summary::LevelTrace;
use crate::math::Vec3;
use crate::mesh::normals::{area_vectors, vertex_normals};
use crate::run::Run;

impl Registration {
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
        let mut liked = self.likeness(image, &begin.points);
        let mut kept = LevelTrace { radius: level.radius, ..LevelTrace::default() };
        loop {
            let mut other = begin.clone();
            let attempt = attempt.searching(reach);
            let trace = self.run_level(level, attempt, search, &mut other, run, most);
            let likeness = self.likeness(image, &other.points);
            if self.is_better(&likeness, &liked) {
                (liked, kept, *state) = (likeness, trace, other);
            }
            if run.is_cancelled() || reach <= shortest {
                return kept;
            }
            reach = (0.5 * reach).max(shortest);
        }
    }

    fn likeness(&self, image: &ImageTarget, points: &[Vec3]) -> Vec<Option<f64>> {
        let faces = area_vectors(points, &self.template.triangles);
        image.likeness(points, &vertex_normals(points.len(), &self.template.triangles, &faces))
    }

    /// Whether a shape is more like the image than another, over the vertices of which both can say it.
    fn is_better(&self, likeness: &[Option<f64>], before: &[Option<f64>]) -> bool {
        let gain = |i: usize| Some(self.areas[i] * (likeness[i]? - before[i]?));
        (0..self.areas.len()).filter_map(gain).sum::<f64>() > 0.0
    }
}
