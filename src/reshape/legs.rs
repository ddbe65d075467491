//! Reshaping in legs. Where tets have become so flat that the solver makes no progress, the shape it
//! reached is filled with new tets, and that is the rest shape of the next leg. \[W\] leaves this to
//! future work.
//!
//! Surface vertices keep their order, so that points of the template given by vertex stay what they
//! are; positions are carried along. A shape that was taken for a rest shape is free of stress: its
//! whole deformation has become plastic.

use super::formulation::Formulation;
use super::options::Options;
use super::problem::{Problem, TemplatePoint};
use super::reshaped::{Leg, Reshaped, carry_through};
use super::solver::{solve, solve_again};
use super::summary::{Remesh, Shapeliness, Stop};
use crate::error::{Error, Result};
use crate::locate::Embedding;
use crate::math::{Mat3, Vec3};
use crate::mesh::TriMesh;
use crate::run::Run;
use crate::tetrahedralize::tetrahedralize;

/// Tets are too flat to go on where one in twenty has a smaller radius ratio: 1 is a regular one's.
const FLAT: f64 = 0.1;

/// Reshapes the template, and where the solver makes no further progress, on new tets. A cancelled run
/// returns its best shape so far.
pub fn reshape(problem: &Problem, options: &Options, run: &Run) -> Result<Reshaped> {
    problem.check()?;
    options.check()?;
    let options = options.settled(&problem.surface);
    let mut best = solve(problem, &options, options.max_iterations, run)?;
    let most = if Formulation::of(&options).second_chances { options.max_remeshes } else { 0 };
    while best.summary.remeshes.len() < most && is_stuck(&best, &options) {
        // Whatever becomes of the next leg, the shape reached is not lost.
        let note = match next_leg(problem, &best, &options, run) {
            Ok(next) if next.summary.marker_distance() <= best.summary.marker_distance() => {
                best = next;
                continue;
            }
            _ if run.is_cancelled() => {
                best.summary.stop = Stop::Cancelled;
                break;
            }
            Ok(_) => "remeshing did not improve the fit".to_owned(),
            Err(failure) => format!("remeshing failed: {failure}"),
        };
        best.summary.warnings.push(note);
        break;
    }
    Ok(best)
}

/// Reshapes the template of `earlier` for a problem that differs in its markers, landmarks,
/// attachments or fixed points: numbering, symbolic factor and smoothness are those of the earlier run,
/// shape and strain start from it, and a few steps at the full weight of the data are enough. Fails for
/// another template or other options, and as [`reshape`] does.
pub fn reshape_again(
    earlier: &Reshaped,
    problem: &Problem,
    options: &Options,
    run: &Run,
) -> Result<Reshaped> {
    problem.check()?;
    let (surface, tets) = earlier.template();
    if problem.tets != *tets || problem.surface.points != surface {
        return Err(Error::invalid(
            "the earlier result belongs to another template or other tets; reshape from the start",
        ));
    }
    if options.settled(&problem.surface) != earlier.earlier.options {
        return Err(Error::invalid("the earlier result had other options; reshape from the start"));
    }
    let last = on_leg(problem, &earlier.problem, &earlier.legs)?;
    let next = solve_again(&earlier.earlier, &last, run)?;
    Ok(after(next, earlier.legs.clone(), earlier.before.clone()))
}

/// Whether nothing more is gained although the markers are not explained yet, for flat tets.
fn is_stuck(reshaped: &Reshaped, options: &Options) -> bool {
    let summary = &reshaped.summary;
    let far = options.tolerance.is_some_and(|tolerance| summary.marker_distance() > tolerance);
    let flat = || Shapeliness::of(&reshaped.deformed_tets()).p5 < FLAT;
    summary.stop == Stop::NoStep || summary.stop == Stop::Settled && far && flat()
}

/// Another leg: the shape reached so far at rest in new tets.
fn next_leg(
    problem: &Problem,
    so_far: &Reshaped,
    options: &Options,
    run: &Run,
) -> Result<Reshaped> {
    run.enter("filling with new tets", run.progress().fraction);
    let surface = TriMesh {
        points: so_far.surface_points.clone(),
        triangles: problem.surface.triangles.clone(),
    };
    let filled = tetrahedralize(&surface, &problem.new_tets, run)?;
    let (old, new) = (so_far.deformed_tets(), &filled.mesh);
    let remesh = Remesh {
        iteration: so_far.summary.iteration_count(),
        before: Shapeliness::of(&old),
        after: Shapeliness::of(new),
        tets: new.tets.len(),
        made_by: filled.used.to_string(),
    };
    let centres: Vec<Vec3> =
        (0..new.tets.len()).map(|t| new.corners(t).iter().sum::<Vec3>() / 4.0).collect();
    let gradients = so_far.gradients();
    let holders = Embedding::new(&old, &centres)?.tets;
    let before = holders.iter().map(|&t| gradients[t as usize]).collect();
    let over = Leg {
        surface: so_far.problem.surface.points.clone(),
        rest: so_far.problem.tets.clone(),
        now: so_far.tet_points.clone(),
        strain_energy: so_far.earlier.strain_energy(),
    };
    let legs = [so_far.legs.clone(), vec![over]].concat();
    let warnings = filled.warnings.clone();
    let next = on_leg(problem, &Problem::new(surface, filled), &legs)?;
    let left = options.max_iterations.saturating_sub(so_far.summary.iteration_count());
    let mut next = after(solve(&next, options, left, run)?, legs, before);
    next.summary = so_far.summary.clone().followed_by(remesh, next.summary);
    next.summary.warnings.extend(warnings);
    Ok(next)
}

/// The data of `problem` on surface and tets of a leg that follows others.
fn on_leg(problem: &Problem, leg: &Problem, others: &[Leg]) -> Result<Problem> {
    let mut moved = Problem {
        markers: problem.markers.clone(),
        landmarks: problem.landmarks.clone(),
        attachments: problem.attachments.clone(),
        fixed: problem.fixed.clone(),
        ..leg.clone()
    };
    for pair in moved.landmarks.iter_mut().chain(&mut moved.attachments) {
        if let TemplatePoint::Position(p) = &mut pair.template {
            *p = carry_through(others, &[*p])?[0];
        }
    }
    Ok(moved)
}

/// The result of a leg with those before it, before which its tets were deformed by `before`.
fn after(mut last: Reshaped, legs: Vec<Leg>, before: Vec<Mat3>) -> Reshaped {
    (last.legs, last.before) = (legs, before);
    if !last.legs.is_empty() {
        let whole = last.with_earlier_deformation(last.plastic_strain.clone());
        last.plastic_strain = whole.iter().map(stretch).collect();
    }
    last
}

/// The factor U of F = R U.
fn stretch(f: &Mat3) -> Mat3 {
    let squares = (f.transpose() * f).symmetric_eigen();
    let roots = Mat3::from_diagonal(&squares.eigenvalues.map(|v| v.max(0.0).sqrt()));
    squares.eigenvectors * roots * squares.eigenvectors.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reshape::test_problems::{AXES, ball_to_ellipsoid};

    fn largest(a: &[Vec3], b: &[Vec3]) -> f64 {
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    }

    #[test]
    fn strain_and_points_survive_new_tets() {
        let problem = ball_to_ellipsoid();
        let run = Run::new();
        let options = Options::default().settled(&problem.surface);
        let template = problem.surface.points.clone();
        // Half way in the first leg: two iterations, then new tets.
        let first = solve(&problem, &options, 2, &run).unwrap();
        let half_way = first.summary.iterations.len();
        let second = next_leg(&problem, &first, &options, &run).unwrap();

        let [remesh] = &second.summary.remeshes[..] else {
            panic!("{:?}", second.summary.remeshes)
        };
        assert_eq!(remesh.iteration, half_way - 1);
        assert!(remesh.after.p5 > remesh.before.p5, "{remesh:?}");
        let summary = &second.summary;
        assert!(summary.iterations.len() > half_way);
        assert!(summary.iterations.last().unwrap().max_marker_distance < 0.01);
        assert!(summary.iterations.is_sorted_by(|a, b| a.newton_steps <= b.newton_steps));

        // Points on the template go where its surface goes.
        let carried = second.carry(&template).unwrap();
        assert!(largest(&carried, &second.surface_points) < 1e-9);
        let back = second.problem.embedding.apply(&second.rest_positions().unwrap());
        assert!(largest(&back, &template) < 0.05, "{}", largest(&back, &template));

        // An earlier result on new tets serves the same template.
        let again = reshape_again(&second, &problem, &Options::default(), &run).unwrap();
        assert!(largest(&again.surface_points, &second.surface_points) < 0.01);
        assert!((again.gradients()[0] - second.gradients()[0]).norm() < 0.1);

        // The whole change is told, not the last leg's.
        let truth = Mat3::from_diagonal(&AXES);
        let mean = |list: &[Mat3]| list.iter().sum::<Mat3>() / list.len() as f64;
        let gradients = mean(&second.gradients());
        assert!((gradients.transpose() * gradients - truth * truth).norm() < 0.15, "{gradients}");
        let strains = &second.plastic_strain;
        assert!(strains.iter().all(|fp| (fp - fp.transpose()).norm() < 1e-12));
        assert!((mean(strains) - truth).norm() < 0.15, "{}", mean(strains));
    }

    #[test]
    fn a_stretch_has_no_rotation() {
        let turn = nalgebra::Rotation3::new(Vec3::new(0.3, -1.0, 2.0)).into_inner();
        let u = Mat3::new(2.0, 0.3, 0.0, 0.3, 1.0, 0.1, 0.0, 0.1, 0.5);
        assert!((stretch(&(turn * u)) - u).norm() < 1e-12);
    }
}
