//! How sure a result is: plausible shapes beside the best one, and how far they differ.

use rayon::prelude::*;

use super::linearization::Linearization;
use super::objective::Objective;
use super::posterior::Posterior;
use super::reshaped::Reshaped;
use super::rows::Rows;
use super::term::Weighting;
use crate::error::{Error, Result};
use crate::locate::Embedding;
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::run::Run;

/// Samples that are computed together.
const BLOCK: usize = 16;

/// What is known of the scale of prior and noise before the data are seen: a variance factor, and the
/// number of data that it is worth. Both from the bank (docs/uncertainty.md), as the next.
const USUAL_VARIANCE: f64 = 0.08;
const USUAL_WORTH: f64 = 10.0;

/// The deviations of shapes that the model does not know are larger by this.
const MODEL_ERROR: f64 = 1.43;

/// Share of a displacement over which slopes are taken.
const SLOPE_STEP: f64 = 1e-3;

/// How sure a result is. Lengths in the template's unit.
#[derive(Clone, Debug)]
pub struct Uncertainty {
    /// Standard deviation of each vertex: the root of the mean squared distance.
    pub sd: Vec<f64>,
    /// The same across the surface.
    pub sd_normal: Vec<f64>,
    /// The result.
    best: TriMesh,
    /// Its vertices in the tets.
    embedding: Embedding,
    /// How the tets' vertices are displaced in each plausible shape.
    displacements: Vec<Vec<Vec3>>,
}

/// So many plausible shapes beside the result. What they do not know: whether a marker belongs to another
/// sheet of the surface, whether the template is of the right kind.
pub fn uncertainty(reshaped: &Reshaped, samples: usize, run: &Run) -> Result<Uncertainty> {
    Uncertainty::check(samples)?;
    run.enter("sampling plausible shapes", run.progress().fraction);
    let (objective, state) = Objective::again(&reshaped.problem, &reshaped.earlier)?;
    let at = objective.evaluate(objective.shape(state), Weighting::ROBUST);
    let (scene, state) = (&objective.scene, &at.shape.state);
    let (stiffness, sensitivity) = objective.derivatives(state)?;
    let linearized = Linearization::new(&scene.body, &stiffness, &sensitivity, &state.x);

    let few = scene.data.representatives(&state.x, &at.shape.correspondences, &at.data.weights);
    let (all, few) = (at.data.rows.evidence(), few.as_ref().map(Rows::evidence));
    let rows = few.as_ref().unwrap_or(&all);
    let posterior = Posterior::new(&linearized, rows, &objective.smoothness)?;
    let deviation = scene.length * scale(reshaped.strain_energy(), &all);
    let block = |first: usize| {
        if run.is_cancelled() {
            return Err(Error::Cancelled);
        }
        let mut fields = posterior.samples(first..samples.min(first + BLOCK));
        fields.iter_mut().flatten().for_each(|displacement| *displacement *= deviation);
        Ok(fields)
    };
    let firsts: Vec<usize> = (0..samples).step_by(BLOCK).collect();
    let blocks: Vec<_> = firsts.into_par_iter().map(block).collect::<Result<_>>()?;
    let triangles = reshaped.problem.surface.triangles.clone();
    let best = TriMesh { points: reshaped.surface_points.clone(), triangles };
    Ok(Uncertainty::new(best, scene.data.surface.embedding.clone(), blocks.concat()))
}

/// The deviation of unit weight: the objective over the number of data, as in the adjustment of
/// observations. A prior or a tolerance that is too wide, or too narrow, shows in it.
fn scale(strain_energy: f64, rows: &Rows) -> f64 {
    let count = rows.rows.len() as f64;
    let squares = 2.0 * (strain_energy + rows.energy());
    MODEL_ERROR * ((squares + USUAL_WORTH * USUAL_VARIANCE) / (count + USUAL_WORTH)).sqrt()
}

impl Uncertainty {
    /// As many as most callers want: a deviation is then known to a tenth of itself.
    pub const SAMPLES: usize = 64;

    /// Fails for a number of shapes that have no deviation.
    pub fn check(samples: usize) -> Result<()> {
        if samples < 2 {
            return Err(Error::invalid(format!(
                "{samples} plausible shapes do not tell how far shapes differ; ask for 2 or more"
            )));
        }
        Ok(())
    }

    fn new(best: TriMesh, embedding: Embedding, displacements: Vec<Vec<Vec3>>) -> Self {
        let normals = best.vertex_normals();
        let (mut sd, mut sd_normal) = (vec![0.0; normals.len()], vec![0.0; normals.len()]);
        for field in &displacements {
            for (v, moved) in embedding.apply(field).iter().enumerate() {
                sd[v] += moved.norm_squared();
                sd_normal[v] += moved.dot(&normals[v]).powi(2);
            }
        }
        for squares in sd.iter_mut().chain(&mut sd_normal) {
            *squares = (*squares / displacements.len() as f64).sqrt();
        }
        Self { sd, sd_normal, best, embedding, displacements }
    }

    /// The result's surface.
    pub fn surface(&self) -> &TriMesh {
        &self.best
    }

    /// Number of plausible shapes.
    pub fn count(&self) -> usize {
        self.displacements.len()
    }

    /// The surface's vertices in one of them, in the template's order; `None` for a number too high.
    pub fn shape(&self, number: usize) -> Option<Vec<Vec3>> {
        let moved = self.embedding.apply(self.displacements.get(number)?);
        Some(self.along(&moved, 1.0).collect())
    }

    /// Standard deviation of a number that a shape has, to first order: what lies along a curved surface
    /// moves away from it when it goes straight on, and a body that turns would swell.
    pub fn deviation_of(&self, measure: impl Fn(&TriMesh) -> f64) -> f64 {
        let mut surface = self.best.clone();
        let mut at = |moved: &[Vec3], share: f64| {
            surface.points.clear();
            surface.points.extend(self.along(moved, share));
            measure(&surface)
        };
        let slopes = self.displacements.iter().map(|field| {
            let moved = self.embedding.apply(field);
            (at(&moved, SLOPE_STEP) - at(&moved, -SLOPE_STEP)) / (2.0 * SLOPE_STEP)
        });
        let squares: f64 = slopes.map(|slope| slope * slope).sum();
        (squares / self.count() as f64).sqrt()
    }

    /// The surface's vertices a share of the way to where they were moved.
    fn along(&self, moved: &[Vec3], share: f64) -> impl Iterator<Item = Vec3> {
        self.best.points.iter().zip(moved).map(move |(p, change)| p + change * share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reshape::test_problems::ball_to_ellipsoid;
    use crate::reshape::{Options, reshape};
    use crate::threads::on_threads;

    /// Of a ball of which the part with x above 0 was seen.
    fn half_seen(samples: usize) -> (Reshaped, Uncertainty) {
        let mut problem = ball_to_ellipsoid();
        problem.markers.retain(|marker| marker.position.x > 0.0);
        let run = Run::new();
        let reshaped = reshape(&problem, &Options::default(), &run).unwrap();
        let found = uncertainty(&reshaped, samples, &run).unwrap();
        (reshaped, found)
    }

    #[test]
    fn what_was_not_seen_is_less_sure() {
        let (reshaped, found) = half_seen(64);
        let mean_of = |sides: f64| {
            let points = reshaped.problem.surface.points.iter().zip(&found.sd_normal);
            let side: Vec<f64> =
                points.filter(|(p, _)| p.x * sides > 0.4).map(|(_, sd)| *sd).collect();
            side.iter().sum::<f64>() / side.len() as f64
        };
        assert!(mean_of(-1.0) > 5.0 * mean_of(1.0), "{} {}", mean_of(-1.0), mean_of(1.0));
        assert!(found.sd.iter().zip(&found.sd_normal).all(|(sd, across)| sd >= across));
    }

    #[test]
    fn a_volume_that_was_seen_all_around_is_sure() {
        let (problem, run) = (ball_to_ellipsoid(), Run::new());
        let reshaped = reshape(&problem, &Options::default(), &run).unwrap();
        // How a ball is turned the markers do not say.
        let found = uncertainty(&reshaped, 64, &run).unwrap();
        let share = found.deviation_of(TriMesh::volume) / found.best.volume();
        assert!((1e-5..0.005).contains(&share), "{share}");
    }

    #[test]
    fn samples_do_not_depend_on_threads_nor_on_their_number() {
        let (_, few) = on_threads(Some(1), || Ok(half_seen(16))).unwrap();
        let (_, more) = on_threads(Some(3), || Ok(half_seen(40))).unwrap();
        assert_eq!((few.count(), more.count()), (16, 40));
        for number in 0..16 {
            assert_eq!(few.shape(number), more.shape(number));
        }
        assert_eq!(few.shape(16), None);
    }

    #[test]
    fn a_deviation_is_that_of_the_shapes() {
        let (reshaped, found) = half_seen(3);
        let best = &reshaped.surface_points;
        let changes: Vec<f64> =
            (0..3).map(|number| found.shape(number).unwrap()[5].x - best[5].x).collect();
        let square = changes.iter().map(|change| change * change).sum::<f64>() / 3.0;
        let deviation = found.deviation_of(|surface| surface.points[5].x);
        assert!((deviation / square.sqrt() - 1.0).abs() < 1e-9);
    }
}
