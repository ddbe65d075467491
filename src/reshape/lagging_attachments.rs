//! Attachments that are still farther off than allowed when the run has settled.

use crate::error::Result;
use crate::math::{Vec3, robust_deviation};

use super::earlier::State;
use super::evidence::OUTLIER;
use super::solver::Solver;
use super::summary::Stop;

/// An attachment that lags gains this factor in weight, so often at most.
const GAIN: f64 = 2.0;
const ROUNDS: usize = 8;

/// After a smaller relative decrease the shape has followed the new weights.
const FOLLOWED: f64 = 0.01;

impl Solver<'_> {
    /// Gives weight to the attachments beyond the tolerance, until all but outliers are within it.
    /// Where most are beyond it, they and the markers contradict each other, and the markers are
    /// followed. The published formulation does without.
    pub(super) fn pull_lagging_attachments(&mut self, mut state: State) -> Result<State> {
        let settled = matches!(self.summary.stop, Stop::Settled | Stop::ToleranceMet);
        if !settled || self.options.paper || self.options.hard_attachments {
            return Ok(state);
        }
        for _ in 0..ROUNDS {
            if self.interruption().is_some() || !self.strengthen_lagging_attachments(&state.x) {
                break;
            }
            state = self.settle(state, FOLLOWED)?;
            if self.summary.stop == Stop::IterationLimit {
                // The shape before had settled: a limit reached meanwhile is no failure.
                self.summary.stop = Stop::Settled;
            }
        }
        Ok(state)
    }

    /// Whether any attachment lags.
    fn strengthen_lagging_attachments(&mut self, x: &[Vec3]) -> bool {
        let tolerance = self.scene.attachment_sigma;
        let attachments = &self.scene.attachments;
        let distances: Vec<f64> =
            attachments.iter().map(|a| (a.point.position(x) - a.target).norm()).collect();
        if robust_deviation(&distances, tolerance) > tolerance {
            return false;
        }
        let lags = |distance: f64| distance > tolerance && distance <= OUTLIER * tolerance;
        let lagging: Vec<usize> = (0..distances.len())
            .filter(|&i| lags(distances[i]) && attachments[i].weight > 0.0)
            .collect();
        for &i in &lagging {
            self.strengthen_attachment(i, GAIN);
        }
        !lagging.is_empty()
    }

    /// What an earlier run's attachments gained, if they are as many.
    pub(super) fn keep_attachment_gains(&mut self, gains: &[f64]) {
        if gains.len() == self.attachment_gains.len() {
            for (i, &gain) in gains.iter().enumerate() {
                self.strengthen_attachment(i, gain);
            }
        }
    }

    fn strengthen_attachment(&mut self, i: usize, gain: f64) {
        self.scene.attachments[i].weight *= gain;
        self.attachment_gains[i] *= gain;
    }
}
