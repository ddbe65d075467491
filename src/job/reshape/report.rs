//! What a run was given, did and reached.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::job::images::compare::SliceFigure;
use crate::job::report::stages::Stage;
use crate::math::Vec3;
use crate::measure::LabelFit;
use crate::measure::Spread;
use crate::reshape::{IterationRecord, Pair, Refinement, Remesh, Tolerances};

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// The solver is satisfied.
    Good,
    /// The solver could not make further progress; the result is its best shape.
    GaveUp,
    /// The caller asked to stop; the result is the best shape so far.
    Interrupted,
}

/// Something before and after the run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Change<T> {
    /// Of the template.
    pub before: T,
    /// Of the result.
    pub after: T,
}

/// One landmark or attachment.
#[derive(Clone, Debug, Serialize)]
pub struct PairLine {
    /// Its name.
    pub label: String,
    /// Distance to its target on the template.
    pub before: f64,
    /// Distance to its target on the result.
    pub after: f64,
    /// Far off although the rest fits: perhaps put at the wrong place.
    pub suspect: bool,
}

/// A number and how sure it is.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Estimate {
    /// Of the result.
    pub value: f64,
    /// Its standard deviation, where plausible shapes were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sd: Option<f64>,
}

impl Estimate {
    /// Five digits and a unit; the deviation to the same place.
    pub fn text(&self, unit: &str) -> String {
        let digits = if self.value == 0.0 { 0.0 } else { libm::log10(self.value.abs()).floor() };
        let decimals = (4.0 - digits).clamp(0.0, 15.0) as usize;
        let sd = self.sd.map_or_else(String::new, |sd| format!(" (sd {sd:.decimals$})"));
        format!("{:.decimals$}{unit}{sd}", self.value)
    }
}

/// How far plausible shapes differ from the result.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Deviations {
    /// Plausible shapes.
    pub samples: usize,
    /// Standard deviations of the vertices across the surface.
    pub sd_normal: Spread,
    /// In all directions.
    pub sd: Spread,
}

impl Report {
    /// The result's volume in words, in millilitres where lengths are millimetres.
    pub fn volume_text(&self) -> Option<String> {
        let volume = self.volume?;
        let millilitres =
            Estimate { value: volume.value / 1000.0, sd: volume.sd.map(|sd| sd / 1000.0) };
        Some(if self.millimetres { millilitres.text(" ml") } else { volume.text("") })
    }
}

/// Everything about one run. Lengths in the template's unit.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Version of moulage.
    pub version: &'static str,
    /// The template's file.
    pub template: PathBuf,
    /// How it ended.
    pub ending: Ending,
    /// Why it stopped, in words.
    pub why: String,
    /// What the user should know, one sentence each.
    pub warnings: Vec<String>,
    /// Vertices of the template.
    pub vertices: usize,
    /// Vertices of the tet mesh (#vtx of \[W\] Table 2).
    pub tet_vertices: usize,
    /// Tets (#ele).
    pub tets: usize,
    /// What made the tets.
    pub tets_made_by: String,
    /// Markers.
    pub markers: usize,
    /// Fixed vertices.
    pub fixed: usize,
    /// Iterations of the solver (#iter).
    pub iteration_count: usize,
    /// Seconds of each stage.
    pub stages: Vec<Stage>,
    /// Tolerance of the markers.
    pub tolerance: f64,
    /// Distance of the markers (`e_init`, `e_final`).
    pub marker_distance: Change<Spread>,
    /// The same, one by one.
    pub marker_distances: Change<Vec<f64>>,
    /// Each landmark.
    pub landmarks: Vec<PairLine>,
    /// Each attachment.
    pub attachments: Vec<PairLine>,
    /// Smallest dihedral angle of each tet, counted in 10 degrees each, of the tets inside.
    pub min_dihedral_histogram: Change<Vec<usize>>,
    /// Tets without or with negative volume.
    pub inverted_tets: usize,
    /// Smallest and largest principal stretch of the tets inside.
    pub stretch_range: [f64; 2],
    /// Ratio of the result's volume to the template's.
    pub volume_ratio: f64,
    /// The result's volume, if its surface is closed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume: Option<Estimate>,
    /// Its surface area.
    pub area: Estimate,
    /// Whether lengths are known to be millimetres, which those of images are.
    #[serde(skip)]
    pub millimetres: bool,
    /// How sure its vertices are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deviations: Option<Deviations>,
    /// Each iteration.
    pub iterations: Vec<IterationRecord>,
    /// Where new tets were made.
    pub remeshes: Vec<Remesh>,
    /// What the image added to the user's markers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refinement: Option<Refinement>,
    /// How well the result meets the label of the person's label map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label_fit: Option<LabelFit>,
    /// The result on slices of the person's image.
    #[serde(skip)]
    pub slices: Vec<SliceFigure>,
    /// Files written.
    pub written: Vec<PathBuf>,
}

/// Shapes for the report's pictures.
#[derive(Clone, Copy, Debug)]
pub struct Shapes<'a> {
    /// Triangles of the template.
    pub triangles: &'a [[u32; 3]],
    /// Vertices before.
    pub before: &'a [Vec3],
    /// Vertices after.
    pub after: &'a [Vec3],
    /// Largest principal stretch of each vertex.
    pub stretch: &'a [f64],
    /// Standard deviation of each vertex across the surface.
    pub sd_normal: Option<&'a [f64]>,
    /// The markers.
    pub markers: &'a [Vec3],
    /// Landmarks.
    pub landmarks: &'a [Pair],
    /// Attachments.
    pub attachments: &'a [Pair],
    /// What they are to be met by.
    pub tolerances: Tolerances,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_has_five_digits_in_any_unit() {
        let written = |value: f64, sd| Estimate { value, sd }.text("");
        assert_eq!(written(79_819.49, Some(42_360.163)), "79819 (sd 42360)");
        assert_eq!(written(7.981_949e-5, Some(4.2e-6)), "0.000079819 (sd 0.000004200)");
        assert_eq!(written(1_234_567.8, None), "1234568");
        assert_eq!(written(0.0, None), "0.0000");
        let litres = Estimate { value: 1.52, sd: Some(0.014) };
        assert_eq!(litres.text(" l"), "1.5200 l (sd 0.0140)");
    }
}
