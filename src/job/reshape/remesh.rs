//! Reshaping in legs. Where tets have become so flat that the solver makes no progress, the shape it
//! reached is filled with new tets, and that is the rest shape of the next leg. \[W\] leaves this to
//! future work.
//!
//! Surface vertices keep their order, so that points of the template given by vertex stay what they
//! are; positions are carried along. What speaks of the whole change (strain, stretch, carried
//! meshes) goes through all legs.

use serde::Serialize;

use super::fill::fill_anew;
use super::spec::ReshapeJob;
use crate::error::Result;
use crate::fem::deformation_gradients;
use crate::locate::Embedding;
use crate::math::{Mat3, Vec3};
use crate::mesh::TetMesh;
use crate::mesh::quality::radius_ratio;
use crate::reshape::{Options, Problem, Reshaped, Stop, TemplatePoint, reshape};
use crate::run::Run;
use crate::tetrahedralize::Tetrahedralization;

/// Re-meshes at most, where the job names no other number.
const MOST: usize = 3;

/// Radius ratios of a mesh's tets: 1 for a regular tet, 0 for a flat one.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Shapeliness {
    /// Of the worst tet.
    pub worst: f64,
    /// 95 % of the tets have more.
    pub p5: f64,
}

/// One re-mesh.
#[derive(Clone, Debug, Serialize)]
pub struct Remesh {
    /// The iteration after which it came.
    pub iteration: usize,
    /// Shapes of the old tets.
    pub before: Shapeliness,
    /// Shapes of the new ones.
    pub after: Shapeliness,
    /// How many there are now.
    pub tets: usize,
    /// What made them.
    pub made_by: String,
}

impl Remesh {
    /// It in words.
    pub fn sentence(&self) -> String {
        format!(
            "after iteration {}: {} by {}; their radius ratios are from {:.3} (5 % below {:.3}) instead of {:.3} ({:.3})",
            self.iteration,
            self.tets,
            self.made_by,
            self.after.worst,
            self.after.p5,
            self.before.worst,
            self.before.p5
        )
    }
}

/// Tets and where they went, of a leg that is over.
#[derive(Clone, Debug)]
struct Leg {
    rest: TetMesh,
    now: Vec<Vec3>,
}

/// A reshaping with all its legs.
#[derive(Clone, Debug)]
pub struct Course {
    /// Template, tets, points and markers of the last leg.
    pub problem: Problem,
    /// What made the tets.
    pub made_by: String,
    /// What the user should know, one sentence each.
    pub warnings: Vec<String>,
    /// Its result; the iterations are those of all legs.
    pub reshaped: Reshaped,
    /// Each re-mesh.
    pub remeshes: Vec<Remesh>,
    legs: Vec<Leg>,
    /// Deformation before the last leg, of each of its tets.
    before: Vec<Mat3>,
}

impl Course {
    /// Reshapes, and where the solver makes no further progress, on new tets.
    pub fn run(
        job: &ReshapeJob,
        problem: Problem,
        made_by: String,
        options: &Options,
        run: &Run,
    ) -> Result<Self> {
        let before = vec![Mat3::identity(); problem.tets.tets.len()];
        let reshaped = reshape(&problem, options, run)?;
        let (legs, remeshes, warnings) = (Vec::new(), Vec::new(), Vec::new());
        let mut course = Self { problem, made_by, warnings, reshaped, remeshes, legs, before };
        let most = job.remesh.unwrap_or(MOST);
        while course.remeshes.len() < most && course.is_stuck(options) {
            // Whatever becomes of the next leg, the shape reached is not lost.
            let note = match course.fill_anew(job, run).and_then(|next| next.go_on(options, run)) {
                Ok(next) if next.marker_distance() <= course.marker_distance() => {
                    course = next;
                    continue;
                }
                _ if run.is_cancelled() => {
                    course.reshaped.summary.stop = Stop::Cancelled;
                    break;
                }
                Ok(_) => "remeshing did not improve the fit".to_owned(),
                Err(failure) => format!("remeshing failed: {failure}"),
            };
            course.warnings.push(note);
            break;
        }
        Ok(course)
    }

    /// Whether no step is found, and the markers are not explained yet.
    fn is_stuck(&self, options: &Options) -> bool {
        let summary = &self.reshaped.summary;
        let far = options.tolerance.is_some_and(|tolerance| self.marker_distance() > tolerance);
        summary.stop == Stop::NoStep || summary.stop == Stop::Settled && summary.stuck && far
    }

    /// Mean distance of the markers at the end.
    fn marker_distance(&self) -> f64 {
        self.reshaped.summary.iterations.last().map_or(0.0, |record| record.mean_marker_distance)
    }

    /// Reshapes on the tets of the last leg.
    fn go_on(mut self, options: &Options, run: &Run) -> Result<Self> {
        let mut earlier = self.reshaped.summary;
        let left = options.max_iterations.saturating_sub(earlier.iteration_count());
        let options = Options { max_iterations: left, ..options.clone() };
        self.reshaped = reshape(&self.problem, &options, run)?;
        let summary = &mut self.reshaped.summary;
        for record in &mut summary.iterations {
            record.newton_steps += earlier.newton_steps;
        }
        summary.newton_steps += earlier.newton_steps;
        // The end of one leg is the start of the next.
        earlier.iterations.pop();
        earlier.iterations.append(&mut summary.iterations);
        summary.iterations = earlier.iterations;
        Ok(self)
    }

    /// Begins another leg: the present shape at rest in new tets.
    fn fill_anew(&self, job: &ReshapeJob, run: &Run) -> Result<Self> {
        run.enter("filling with new tets", run.progress().fraction);
        let mut problem = self.problem.clone();
        problem.surface.points.clone_from(&self.reshaped.surface_points);
        let filling = fill_anew(job, &problem.surface, run)?;
        for pair in problem.landmarks.iter_mut().chain(&mut problem.attachments) {
            if let TemplatePoint::Position(p) = &mut pair.template {
                *p = carry(&self.problem.tets, &self.reshaped.tet_points, &[*p])?[0];
            }
        }
        let Tetrahedralization { mesh, embedding, inside_fraction, used, warnings, .. } = filling;
        let centres: Vec<Vec3> =
            (0..mesh.tets.len()).map(|t| mesh.corners(t).iter().sum::<Vec3>() / 4.0).collect();
        let so_far = self.gradients();
        let holders = Embedding::new(&self.now(), &centres)?.tets;
        let mut course = self.clone();
        course.before = holders.iter().map(|&t| so_far[t as usize]).collect();
        course
            .legs
            .push(Leg { rest: self.problem.tets.clone(), now: self.reshaped.tet_points.clone() });
        course.remeshes.push(Remesh {
            iteration: self.reshaped.summary.iteration_count(),
            before: Shapeliness::of(&self.now()),
            after: Shapeliness::of(&mesh),
            tets: mesh.tets.len(),
            made_by: used.to_string(),
        });
        (problem.tets, problem.embedding, problem.inside_fraction) =
            (mesh, embedding, inside_fraction);
        Ok(Self { problem, made_by: used.to_string(), warnings, ..course })
    }

    /// The last leg's tets in the person's shape.
    fn now(&self) -> TetMesh {
        TetMesh { points: self.reshaped.tet_points.clone(), tets: self.problem.tets.tets.clone() }
    }

    /// Where points of the template went.
    pub fn carry(&self, points: &[Vec3]) -> Result<Vec<Vec3>> {
        let mut points = points.to_vec();
        for leg in &self.legs {
            points = carry(&leg.rest, &leg.now, &points)?;
        }
        carry(&self.problem.tets, &self.reshaped.tet_points, &points)
    }

    /// Where the last leg's tet vertices are in the template.
    pub fn rest_positions(&self) -> Result<Vec<Vec3>> {
        let mut points = self.problem.tets.points.clone();
        for leg in self.legs.iter().rev() {
            let now = TetMesh { points: leg.now.clone(), tets: leg.rest.tets.clone() };
            points = carry(&now, &leg.rest.points, &points)?;
        }
        Ok(points)
    }

    /// Deformation gradient of each of the last leg's tets, from the template to the person.
    pub fn gradients(&self) -> Vec<Mat3> {
        let last = deformation_gradients(&self.problem.tets, &self.reshaped.tet_points);
        last.iter().zip(&self.before).map(|(f, before)| f * before).collect()
    }

    /// Plastic strain of each of the last leg's tets, from the template to the person. A shape that
    /// was taken for a rest shape is free of stress: its whole deformation has become plastic.
    /// Symmetric: without the rotation.
    pub fn plastic_strain(&self) -> Vec<Mat3> {
        if self.legs.is_empty() {
            return self.reshaped.plastic_strain.clone();
        }
        let last = &self.reshaped.plastic_strain;
        last.iter().zip(&self.before).map(|(fp, before)| stretch(&(fp * before))).collect()
    }
}

/// The factor U of F = R U.
fn stretch(f: &Mat3) -> Mat3 {
    let squares = (f.transpose() * f).symmetric_eigen();
    let roots = Mat3::from_diagonal(&squares.eigenvalues.map(|v| v.max(0.0).sqrt()));
    squares.eigenvectors * roots * squares.eigenvectors.transpose()
}

fn carry(from: &TetMesh, to: &[Vec3], points: &[Vec3]) -> Result<Vec<Vec3>> {
    Ok(Embedding::new(from, points)?.apply(to))
}

impl Shapeliness {
    fn of(mesh: &TetMesh) -> Self {
        let mut ratios: Vec<f64> =
            (0..mesh.tets.len()).map(|t| radius_ratio(&mesh.corners(t))).collect();
        ratios.sort_by(f64::total_cmp);
        let at = |share: f64| ratios.get((share * ratios.len() as f64) as usize).copied();
        Self { worst: at(0.0).unwrap_or(0.0), p5: at(0.05).unwrap_or(0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::sphere;
    use crate::mesh::TriMesh;
    use crate::reshape::Marker;

    /// Half axes of the person's ellipsoid.
    const AXES: Vec3 = Vec3::new(1.5, 1.0, 0.8);

    fn ball_to_ellipsoid() -> (ReshapeJob, Problem) {
        let (points, triangles) = sphere(10, 16);
        let surface = TriMesh::new(points, triangles).unwrap();
        let job = ReshapeJob {
            tets: Some("lattice".into()),
            tet_count: Some(800),
            ..ReshapeJob::default()
        };
        let filling = crate::job::reshape::fill::fill(&job, &surface, &Run::new()).unwrap();
        let markers = surface.points.iter().map(|p| p.component_mul(&AXES));
        let markers = markers.map(Marker::at).collect();
        let problem = Problem {
            markers,
            ..Problem::new(surface, filling.mesh, filling.embedding, filling.inside_fraction)
        };
        (job, problem)
    }

    fn largest(a: &[Vec3], b: &[Vec3]) -> f64 {
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    }

    #[test]
    fn strain_and_points_survive_new_tets() {
        let (job, problem) = ball_to_ellipsoid();
        let (options, run) = (Options::default(), Run::new());
        let template = problem.surface.points.clone();
        // Half way in the first leg: two iterations, then new tets.
        let short = Options { max_iterations: 2, ..options.clone() };
        let first = Course::run(&job, problem, String::new(), &short, &run).unwrap();
        let half_way = first.reshaped.summary.iterations.len();
        let second = first.fill_anew(&job, &run).unwrap().go_on(&options, &run).unwrap();

        let [remesh] = &second.remeshes[..] else { panic!("{:?}", second.remeshes) };
        assert_eq!(remesh.iteration, half_way - 1);
        assert!(remesh.after.p5 > remesh.before.p5, "{remesh:?}");
        let summary = &second.reshaped.summary;
        assert!(summary.iterations.len() > half_way);
        assert!(summary.iterations.last().unwrap().max_marker_distance < 0.01);
        assert!(summary.iterations.is_sorted_by(|a, b| a.newton_steps <= b.newton_steps));

        // Points on the template go where its surface goes.
        let carried = second.carry(&template).unwrap();
        assert!(largest(&carried, &second.reshaped.surface_points) < 1e-9);
        let back = second.problem.embedding.apply(&second.rest_positions().unwrap());
        assert!(largest(&back, &template) < 0.05, "{}", largest(&back, &template));

        // The whole change is told, not the last leg's.
        let truth = Mat3::from_diagonal(&AXES);
        let mean = |list: &[Mat3]| list.iter().sum::<Mat3>() / list.len() as f64;
        let gradients = mean(&second.gradients());
        assert!((gradients.transpose() * gradients - truth * truth).norm() < 0.15, "{gradients}");
        let strains = second.plastic_strain();
        assert!(strains.iter().all(|fp| (fp - fp.transpose()).norm() < 1e-12));
        assert!((mean(&strains) - truth).norm() < 0.15, "{}", mean(&strains));
    }

    #[test]
    fn a_stretch_has_no_rotation() {
        let turn = nalgebra::Rotation3::new(Vec3::new(0.3, -1.0, 2.0)).into_inner();
        let u = Mat3::new(2.0, 0.3, 0.0, 0.3, 1.0, 0.1, 0.0, 0.1, 0.5);
        assert!((stretch(&(turn * u)) - u).norm() < 1e-12);
    }
}
