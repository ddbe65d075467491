//! What happened during a reshaping.

use serde::Serialize;

use crate::mesh::TetMesh;
use crate::mesh::quality::radius_ratio;

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
    /// Where new tets were made.
    pub remeshes: Vec<Remesh>,
    /// What the user should know about these, one sentence each.
    pub warnings: Vec<String>,
}

impl Summary {
    /// Gauss-Newton iterations taken.
    pub fn iteration_count(&self) -> usize {
        self.iterations.len().saturating_sub(1)
    }

    /// Mean distance of the markers at the end.
    pub fn marker_distance(&self) -> f64 {
        self.iterations.last().map_or(0.0, |record| record.mean_marker_distance)
    }

    /// The course with that of another leg on new tets.
    pub(super) fn followed_by(mut self, remesh: Remesh, next: Self) -> Self {
        // The end of one leg is the start of the next.
        self.iterations.pop();
        self.iterations.extend(next.iterations.into_iter().map(|record| IterationRecord {
            newton_steps: self.newton_steps + record.newton_steps,
            ..record
        }));
        self.newton_steps += next.newton_steps;
        self.remeshes.push(remesh);
        Self { stop: next.stop, ..self }
    }
}

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

impl Shapeliness {
    pub(super) fn of(mesh: &TetMesh) -> Self {
        let mut ratios: Vec<f64> =
            (0..mesh.tets.len()).map(|t| radius_ratio(&mesh.corners(t))).collect();
        ratios.sort_by(f64::total_cmp);
        let at = |share: f64| ratios.get((share * ratios.len() as f64) as usize).copied();
        Self { worst: at(0.0).unwrap_or(0.0), p5: at(0.05).unwrap_or(0.0) }
    }
}
