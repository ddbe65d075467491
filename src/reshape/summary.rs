//! What happened during a reshaping.

use serde::Serialize;

/// Why a reshaping ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stop {
    /// The objective no longer falls by a relevant amount.
    #[default]
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

/// Where the run stood before one Gauss-Newton iteration. Lengths in the template's unit.
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
#[derive(Clone, Debug, Default)]
pub struct Summary {
    /// One record per iteration; the first is the start, the last the end.
    pub iterations: Vec<IterationRecord>,
    /// Newton steps of all static solves.
    pub newton_steps: usize,
    /// Why it ended.
    pub stop: Stop,
}
