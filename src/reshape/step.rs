//! One step of the outer loop: linearise, try directions in pairs, take the best.

use rayon::prelude::*;

use super::damping::Damping;
use super::formulation::Steps;
use super::gauss_newton::{Direction, NormalEquations};
use super::linearization::Linearization;
use super::objective::{Evaluation, Objective, Shape};
use super::rows::Rows;
use super::trial::{Candidate, Origin, Trial};
use crate::error::Result;
use crate::material::{InversionBarrier, StableNeoHookean};
use crate::run::Run;

/// Pairs of trials before the search for a step is given up.
const MAX_ROUNDS: i32 = 3;

/// How exact directions are. Less would do for the trials, which judge them; but what is missing depends on
/// rounding, and steps towards wrong matches multiply it.
const DIRECTION_REDUCTION: f64 = 1e-8;

/// The same for very many markers, where each digit costs steps of conjugate gradients.
const ITERATED_REDUCTION: f64 = 0.03;

/// Share of the present objective, times the step's length, that a step must take away.
const ARMIJO: f64 = 1e-4;

/// Where the trials of one step come from.
enum Search<'a> {
    /// One published direction, halved.
    Halving(Direction),
    /// Damped directions.
    Damping(NormalEquations<'a, InversionBarrier<StableNeoHookean>>),
}

/// One Gauss-Newton step.
pub struct Step {
    /// Where it led; `None` when no step lowers the objective.
    pub reached: Option<Shape>,
    /// The share of the objective that it took away.
    pub gain: Option<f64>,
    /// Of the next step.
    pub damping: Damping,
    /// Newton steps of all trials.
    pub newton_steps: usize,
}

impl Objective<'_> {
    /// One Gauss-Newton step.
    pub fn step(&self, at: &Evaluation, damping: Damping, run: &Run) -> Result<Step> {
        let (body, state) = (&self.scene.body, &at.shape.state);
        let (stiffness, sensitivity) = self.derivatives(state)?;
        let linearized = Linearization::new(body, &stiffness, &sensitivity, &state.x);
        let few =
            self.scene.data.representatives(&state.x, &at.shape.correspondences, &at.data.weights);
        let search = self.search(at, &linearized, few.as_ref());
        let origin = Origin { at, linearized: &linearized };
        let mut step = Step { reached: None, gain: None, damping, newton_steps: 0 };
        let mut least = f64::INFINITY;
        for round in 0..MAX_ROUNDS {
            if step.reached.is_some() || run.is_cancelled() {
                break;
            }
            let attempt = |k| self.attempt(&origin, &search, damping, round, k);
            let pair: Vec<_> = [0, 1].into_par_iter().map(attempt).collect::<Result<_>>()?;
            for (Trial { candidate, newton_steps }, next_damping) in pair {
                step.newton_steps += newton_steps;
                if let Some(best) = candidate.filter(|candidate| candidate.majorizer < least) {
                    least = best.majorizer;
                    step.gain = Some(1.0 - best.majorizer / at.majorizer);
                    step.reached = Some(best.shape);
                    step.damping = next_damping;
                }
            }
        }
        Ok(step)
    }

    fn search<'a>(
        &'a self,
        at: &'a Evaluation,
        linearized: &'a Linearization<'a, InversionBarrier<StableNeoHookean>>,
        few: Option<&'a Rows>,
    ) -> Search<'a> {
        let (rows, smoothness) = (&at.data.rows, &self.smoothness);
        if !self.scene.body.is_free() && self.formulation.held_steps == Steps::Halved {
            let s = &at.shape.state.s;
            Search::Halving(linearized.woodbury_direction(rows, smoothness, s, DIRECTION_REDUCTION))
        } else {
            Search::Damping(NormalEquations::new(linearized, rows, few, smoothness))
        }
    }

    /// Trial `k` of a round, without a candidate where it does not lower the objective, and the damping
    /// to go on with.
    fn attempt(
        &self,
        origin: &Origin,
        search: &Search,
        damping: Damping,
        round: i32,
        k: usize,
    ) -> Result<(Trial, Damping)> {
        let s = &origin.at.shape.state.s;
        let (direction, share, used) = match search {
            Search::Halving(direction) => {
                (direction.clone(), 0.5_f64.powi(2 * round + k as i32), 0.0)
            }
            Search::Damping(equations) => {
                let used = damping.pair(round)[k];
                let reduction =
                    if equations.is_iterated() { ITERATED_REDUCTION } else { DIRECTION_REDUCTION };
                (equations.direction(s, used, reduction)?, 1.0, used)
            }
        };
        let eta = share * self.largest_step(s, &direction);
        let mut trial = self.trial(origin, &direction, eta)?;
        let before = origin.at.majorizer;
        let is_lower = |c: &Candidate| c.majorizer <= before * (1.0 - ARMIJO * eta);
        trial.candidate = trial.candidate.filter(is_lower);
        let next_damping = match (search, &trial.candidate) {
            (Search::Damping(equations), Some(candidate)) => {
                let promise = equations.promise(s, &direction);
                let promised = (before - promise) * eta;
                Damping::after(used, (before - candidate.majorizer) / promised)
            }
            _ => damping,
        };
        Ok((trial, next_damping))
    }
}
