//! Markers that lie far off when the run has settled. In a narrow cleft that is half closed they match
//! the wrong sheet and, as outliers, have too little weight to change that: they get another chance.

use crate::error::Result;
use crate::math::robust_deviation;

use super::damping::Damping;
use super::earlier::State;
use super::evidence::{Belief, Contact};
use super::solver::Solver;
use super::summary::Stop;

/// Markers farther off than this many standard deviations are far.
const FAR: f64 = 5.0;

/// Steps that take every marker at its word.
const LITERAL_STEPS: usize = 4;

/// Share of the objective that a chance must gain for another one.
const WORTH_ANOTHER: f64 = 0.02;

impl Solver<'_> {
    /// Takes every marker at its word for some steps, then doubts again: one that was right lies on
    /// its own sheet now, one that was wrong is given up as before. The lower objective is kept.
    /// The published formulation does without.
    pub(super) fn reconsider_far_markers(&mut self, state: State) -> Result<State> {
        let mut best = state;
        if self.options.paper {
            return Ok(best);
        }
        while self.summary.stop == Stop::Settled
            && self.interruption().is_none()
            && self.has_far_markers(&best)
        {
            let least = self.objective_on_record();
            let other = self.follow_all_markers(best.clone())?;
            if matches!(self.summary.stop, Stop::NoStep | Stop::IterationLimit) {
                // The shape before had settled: that nothing better was found is no fault.
                self.summary.stop = Stop::Settled;
            }
            let gain = 1.0 - self.objective_on_record() / least;
            if gain > 0.0 {
                best = other;
            } else {
                self.record(&best, Belief::ROBUST);
            }
            if gain < WORTH_ANOTHER {
                break;
            }
        }
        Ok(best)
    }

    fn follow_all_markers(&mut self, mut state: State) -> Result<State> {
        self.damping = Damping::default();
        for k in 0..LITERAL_STEPS {
            if k > 0 {
                self.record(&state, Belief::ROBUST);
            }
            let Some((next, _)) = self.step(&state, Belief::LITERAL)? else { break };
            state = next;
            if self.interruption().is_some() {
                break;
            }
        }
        self.damping = Damping::default();
        self.minimize(state, 1.0)
    }

    fn has_far_markers(&self, state: &State) -> bool {
        let distances = Contact::new(&self.scene, &state.x).distances();
        let far = FAR * robust_deviation(&distances, self.scene.marker_sigma);
        distances.iter().any(|distance| *distance > far)
    }

    /// Of the last state recorded.
    fn objective_on_record(&self) -> f64 {
        self.summary.iterations.last().map_or(f64::INFINITY, |record| record.objective)
    }
}
