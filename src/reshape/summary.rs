//! What happened during a reshaping.

use serde::Serialize;

/// Why a reshaping ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The objective no longer falls by a relevant amount.
    Settled,
    /// All markers are within the tolerance.
    ToleranceMet,
    /// No step lowers the objective although it should.
    NoStep,
    /// The iterations ran out.
    IterationLimit,
    /// The caller asked to stop.
    Cancelled,
}

impl Stop {
    /// Of further steps from a shape that had settled: that they found nothing better, or met a limit,
    /// is no failure.
    pub(super) fn after_settling(self) -> Self {
        match self {
            Self::NoStep | Self::IterationLimit => Self::Settled,
            other => other,
        }
    }
}

/// Where the run stands at its start or after a Gauss-Newton iteration. Lengths in the template's unit.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct IterationRecord {
    /// Share of the markers' full weight.
    pub data_scale: f64,
    /// Smoothness plus data terms.
    pub objective: f64,
    /// Mean distance of the markers to the shape.
    pub mean_marker_distance: f64,
    /// Largest distance of a marker to the shape.
    pub max_marker_distance: f64,
    /// Newton steps of all static solves so far.
    pub newton_steps: usize,
    /// Seconds since the start.
    pub seconds: f64,
}

/// The course of a run.
#[derive(Clone, Debug)]
pub struct Summary {
    /// The start, then one record per iteration; the last is the end.
    pub iterations: Vec<IterationRecord>,
    /// Newton steps of all static solves.
    pub newton_steps: usize,
    /// Why it ended.
    pub stop: Stop,
    /// Whether no step was found from where it ended.
    pub stuck: bool,
}

impl Summary {
    /// Gauss-Newton iterations taken.
    pub fn iteration_count(&self) -> usize {
        self.iterations.len().saturating_sub(1)
    }
}
