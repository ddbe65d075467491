//! Reshaping again, from an earlier result: after a landmark was moved, markers came or went.
//!
//! Numbering, symbolic factor and smoothness are those of the earlier run, and so are its shape and
//! strain to begin with. A few steps at the full weight of the data are enough.

use super::objective::Objective;
use super::options::Options;
use super::problem::Problem;
use super::schedule::Schedule;
use super::solver::{Reshaped, Solver};
use super::summary::Stop;
use crate::error::{Error, Result};
use crate::run::Run;

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
    let (objective, state) = Objective::again(problem, earlier)?;
    let schedule = Schedule::again();
    let mut solver = Solver::new(objective, run);
    let start = solver.start(state, schedule.weighting)?;
    let mut ended = solver.minimize(start, schedule)?;
    if ended.stop == Stop::NoStep {
        // The earlier shape had settled: that there is no better step is no failure.
        ended.stop = Stop::Settled;
    }
    Ok(solver.finish(ended, problem))
}
