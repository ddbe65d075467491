//! Reshaping again, from an earlier result: after a landmark was moved, markers came or went.
//!
//! Numbering, symbolic factor and smoothness are those of the earlier run, and so are its shape and
//! strain to begin with. A few steps at the full weight of the data are enough.

use super::options::Options;
use super::problem::Problem;
use super::solver::{Reshaped, Solver};
use crate::error::{Error, Result};
use crate::run::Run;

/// A step that lowers the objective by less than this share is the last.
const SETTLED: f64 = 0.15;

/// Reshapes the template of `earlier` for a problem that differs in its markers, landmarks,
/// attachments or fixed points. Fails for another template or other options, and as
/// [`super::reshape`] does.
pub fn reshape_again(
    earlier: &Reshaped,
    problem: &Problem,
    options: &Options,
    run: &Run,
) -> Result<Reshaped> {
    problem.check()?;
    let earlier = &earlier.earlier;
    if problem.tets != earlier.rest_tets || problem.surface.points != earlier.rest_surface {
        return Err(Error::invalid(
            "the earlier result belongs to another template or other tets; reshape from the start",
        ));
    }
    if *options != earlier.options {
        return Err(Error::invalid("the earlier result had other options; reshape from the start"));
    }
    run.enter("preparing", 0.0);
    let (mut solver, state) = Solver::again(problem, earlier, run)?;
    let state = solver.settle(state, SETTLED)?;
    Ok(solver.finish(state, problem))
}
