//! One step of the outer loop: linearise, try directions in pairs, take the best.

use rayon::prelude::*;

use super::damping::Damping;
use super::earlier::State;
use super::evidence::{Belief, Contact, Weights, representatives, rows};
use super::gauss_newton::{Direction, NormalEquations};
use super::linearization::Linearization;
use super::solver::Solver;
use super::trial::Origin;
use crate::error::Result;
use crate::fem::Sensitivity;
use crate::material::{InversionBarrier, StableNeoHookean};

/// Pairs of trials before the search for a step is given up.
const MAX_ROUNDS: i32 = 3;

/// How exact directions are; the trials judge them.
const DIRECTION_REDUCTION: f64 = 1e-4;

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

/// One trial, judged.
struct Attempt {
    /// The state, where it lowers the objective.
    state: Option<State>,
    /// Its objective.
    value: f64,
    /// How to go on from it.
    next_damping: Damping,
    newton_steps: usize,
}

impl Solver<'_> {
    /// One Gauss-Newton step; `None` when no step lowers the objective. With it the relative
    /// decrease.
    pub(super) fn step(&mut self, state: &State, belief: Belief) -> Result<Option<(State, f64)>> {
        let contact = Contact::new(&self.scene, &state.x);
        let weights =
            Weights::new(&self.scene, &contact, &state.x, belief, self.options.hard_attachments);
        let rows = rows(&self.scene, &contact, &weights, &state.x);
        let representatives = representatives(&self.scene, &contact, &weights, &state.x);
        let plastic = self.plastic(&state.s);
        let (body, x) = (&self.scene.body, &state.x);
        let (stiffness, sensitivity) = rayon::join(
            || body.factor_stiffness(x, &plastic),
            || Sensitivity::new(body, &self.space, x, &plastic),
        );
        let stiffness = stiffness?;
        let at = Linearization::new(body, &stiffness, &sensitivity, x);
        let objective = rows.energy() + self.prior(&state.s);
        let origin = Origin { state, at: &at, weights: &weights, objective };
        let search = if self.options.paper && !self.scene.body.is_free() {
            let direction = at.woodbury_direction(
                &rows,
                &self.smoothness,
                &state.s,
                &self.anchor,
                DIRECTION_REDUCTION,
            );
            Search::Halving(direction)
        } else {
            let few = representatives.as_ref();
            Search::Damping(NormalEquations::new(&at, &rows, few, &self.smoothness))
        };
        let mut newton_steps = 0;
        let mut found = None;
        for round in 0..MAX_ROUNDS {
            if found.is_some() || self.run.is_cancelled() {
                break;
            }
            let pair = [0, 1].into_par_iter().map(|k| self.attempt(&origin, &search, round, k));
            for attempt in pair.collect::<Result<Vec<Attempt>>>()? {
                newton_steps += attempt.newton_steps;
                if attempt.value < found.as_ref().map_or(f64::INFINITY, |f: &Attempt| f.value) {
                    found = Some(attempt);
                }
            }
        }
        self.summary.newton_steps += newton_steps;
        Ok(found.and_then(|best| {
            self.damping = best.next_damping;
            best.state.map(|state| (state, 1.0 - best.value / objective))
        }))
    }

    /// Trial `k` of a round; its value is infinite where it does not lower the objective.
    fn attempt(&self, origin: &Origin, search: &Search, round: i32, k: usize) -> Result<Attempt> {
        let state = origin.state;
        let (direction, share, damping) = match search {
            Search::Halving(direction) => {
                (direction.clone(), 0.5_f64.powi(2 * round + k as i32), 0.0)
            }
            Search::Damping(equations) => {
                let damping = self.damping.pair(round)[k];
                let reduction =
                    if equations.is_iterated() { ITERATED_REDUCTION } else { DIRECTION_REDUCTION };
                (equations.direction(&state.s, &self.anchor, damping, reduction)?, 1.0, damping)
            }
        };
        let eta = share * self.largest_step(&state.s, &direction);
        let trial = self.trial(origin, &direction, eta)?;
        let needed = origin.objective * (1.0 - ARMIJO * eta);
        let (state, value) = match trial.reached.filter(|(_, value)| *value <= needed) {
            Some((state, value)) => (Some(state), value),
            None => (None, f64::INFINITY),
        };
        let next_damping = match search {
            Search::Damping(equations) if state.is_some() => {
                let promise = equations.promise(&origin.state.s, &self.anchor, &direction);
                let promised = (origin.objective - promise) * eta;
                Damping::after(damping, (origin.objective - value) / promised)
            }
            _ => self.damping,
        };
        Ok(Attempt { state, value, next_damping, newton_steps: trial.newton_steps })
    }
}
