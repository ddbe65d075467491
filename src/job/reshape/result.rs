//! What came out of the solver, measured.

use super::inputs::Inputs;
use super::report::{Change, Deviations, Ending, Estimate, PairLine, Report, Shapes};
use crate::error::Result;
use crate::fem::{principal_stretches, stretches_of};
use crate::math::{Mat3, Vec3, median};
use crate::measure::{Spread, marker_distances};
use crate::mesh::quality::dihedral_angles;
use crate::mesh::{SurfaceCheck, TetMesh, TetQuality, TriMesh};
use crate::reshape::{Options, Pair, Reshaped, Stop, Tolerances, Uncertainty};

/// A pair farther off than so many tolerances, and than so many times the median, is suspect.
const SUSPECT: f64 = 5.0;
/// A tet counts for the figures if at least this share of it is inside the surface.
const INSIDE: f64 = 0.5;
/// Bins of 10 degrees up to 180.
const BINS: usize = 18;

/// The solver's result with what the outputs need.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The result itself.
    pub reshaped: Reshaped,
    /// Marker positions.
    pub markers: Vec<Vec3>,
    /// Largest and smallest principal stretch per surface vertex.
    pub stretch: (Vec<f64>, Vec<f64>),
    /// Plausible shapes, if there are any.
    pub uncertainty: Option<Uncertainty>,
    tolerances: Tolerances,
}

impl Outcome {
    /// Measures what the outputs need.
    pub fn new(
        inputs: &Inputs,
        options: &Options,
        reshaped: Reshaped,
        uncertainty: Option<Uncertainty>,
    ) -> Self {
        let problem = &reshaped.problem;
        let stretch = stretches_of(&reshaped.gradients(), &problem.tets, &problem.embedding);
        Self {
            markers: inputs.markers.iter().map(|m| m.position).collect(),
            tolerances: options.tolerances(&inputs.surface, 1.0),
            stretch,
            uncertainty,
            reshaped,
        }
    }

    /// The report, without stages and files.
    pub fn report(&self, inputs: &Inputs) -> Result<Report> {
        let (problem, reshaped) = (&self.reshaped.problem, &self.reshaped);
        let summary = &reshaped.summary;
        let (ending, why) = ending(summary.stop);
        let distances = self.distances(inputs);
        let inverted_tets = TetQuality::of(&problem.tets.tets, &reshaped.tet_points).inverted;
        let now = &reshaped.tet_points;
        let inside: Vec<usize> = (0..problem.tets.tets.len())
            .filter(|&t| problem.inside_fraction[t] >= INSIDE)
            .collect();
        let pairs = |list: &[Pair], tolerance: f64| {
            let positions: Vec<Vec3> = list.iter().map(|pair| pair.position).collect();
            Ok(pair_lines(list, &reshaped.carry(&positions)?, tolerance))
        };
        let moved = TriMesh { points: reshaped.surface_points.clone(), ..inputs.surface.clone() };
        Ok(Report {
            version: env!("CARGO_PKG_VERSION"),
            template: inputs.template_path.clone(),
            ending,
            why: why.to_owned(),
            warnings: [inputs.warnings.clone(), inverted_warning(inverted_tets)].concat(),
            vertices: inputs.surface.points.len(),
            tet_vertices: problem.tets.points.len(),
            tets: problem.tets.tets.len(),
            tets_made_by: problem.made_by.to_string(),
            markers: self.markers.len(),
            fixed: inputs.fixed.len(),
            iteration_count: summary.iteration_count(),
            stages: Vec::new(),
            tolerance: self.tolerances.marker,
            marker_distance: Change {
                before: Spread::of(&distances.before),
                after: Spread::of(&distances.after),
            },
            marker_distances: distances,
            landmarks: pairs(&inputs.landmarks, self.tolerances.landmark)?,
            attachments: pairs(&inputs.attachments, self.tolerances.attachment)?,
            min_dihedral_histogram: Change {
                before: min_dihedrals(&problem.tets, &problem.tets.points, &inside),
                after: min_dihedrals(&problem.tets, now, &inside),
            },
            inverted_tets,
            stretch_range: stretch_range(&reshaped.gradients(), &inside),
            volume_ratio: moved.volume() / inputs.surface.volume(),
            volume: SurfaceCheck::new(&moved)
                .is_closed()
                .then(|| self.estimate(&moved, TriMesh::volume)),
            area: self.estimate(&moved, TriMesh::area),
            millimetres: false,
            deviations: self.uncertainty.as_ref().map(deviations),
            iterations: summary.iterations.clone(),
            remeshes: summary.remeshes.clone(),
            refinement: None,
            label_fit: None,
            slices: Vec::new(),
            written: Vec::new(),
        })
    }

    /// Shapes for the pictures.
    pub fn shapes<'a>(&'a self, inputs: &'a Inputs) -> Shapes<'a> {
        Shapes {
            triangles: &inputs.surface.triangles,
            before: &inputs.surface.points,
            after: &self.reshaped.surface_points,
            stretch: &self.stretch.0,
            sd_normal: self.uncertainty.as_ref().map(|u| &u.sd_normal[..]),
            markers: &self.markers,
            landmarks: &inputs.landmarks,
            attachments: &inputs.attachments,
            tolerances: self.tolerances,
        }
    }

    /// A number that the result has, and how far it differs among the plausible shapes.
    fn estimate(&self, result: &TriMesh, measure: fn(&TriMesh) -> f64) -> Estimate {
        let deviation = |uncertainty: &Uncertainty| uncertainty.deviation_of(measure);
        Estimate { value: measure(result), sd: self.uncertainty.as_ref().map(deviation) }
    }

    fn distances(&self, inputs: &Inputs) -> Change<Vec<f64>> {
        let of =
            |points: &[Vec3]| marker_distances(points, &inputs.surface.triangles, &self.markers);
        Change { before: of(&inputs.surface.points), after: of(&self.reshaped.surface_points) }
    }
}

fn deviations(uncertainty: &Uncertainty) -> Deviations {
    Deviations {
        samples: uncertainty.count(),
        sd_normal: Spread::of(&uncertainty.sd_normal),
        sd: Spread::of(&uncertainty.sd),
    }
}

fn ending(stop: Stop) -> (Ending, &'static str) {
    match stop {
        Stop::Settled => (Ending::Good, "The objective no longer falls by a relevant amount."),
        Stop::ToleranceMet => (Ending::Good, "All markers are within the tolerance."),
        Stop::NoStep => (
            Ending::GaveUp,
            "No step lowers the objective although one should; look for markers or landmarks that contradict each other, or allow a larger tolerance.",
        ),
        Stop::IterationLimit => {
            (Ending::GaveUp, "The iterations ran out; allow more, or a larger tolerance.")
        }
        Stop::Cancelled => (Ending::Interrupted, "It was asked to stop."),
    }
}

fn pair_lines(pairs: &[Pair], moved: &[Vec3], tolerance: f64) -> Vec<PairLine> {
    let distances: Vec<(f64, f64)> = pairs
        .iter()
        .zip(moved)
        .map(|(pair, now)| ((pair.position - pair.target).norm(), (now - pair.target).norm()))
        .collect();
    let middle = median(distances.iter().map(|d| d.1)).unwrap_or(0.0);
    let limit = SUSPECT * tolerance.max(middle);
    pairs
        .iter()
        .zip(&distances)
        .map(|(pair, &(before, after))| PairLine {
            label: pair.label.clone(),
            before,
            after,
            suspect: after > limit,
        })
        .collect()
}

fn min_dihedrals(mesh: &TetMesh, points: &[Vec3], inside: &[usize]) -> Vec<usize> {
    let mut bins = vec![0; BINS];
    for &t in inside {
        let angles = dihedral_angles(&mesh.tets[t].map(|v| points[v as usize]));
        let smallest = angles.into_iter().fold(180.0, f64::min);
        bins[((smallest / 10.0) as usize).min(BINS - 1)] += 1;
    }
    bins
}

fn inverted_warning(count: usize) -> Vec<String> {
    let sentence = format!(
        "{count} tets came out inverted; the shape is folded there: allow a larger tolerance, or look for markers that contradict each other"
    );
    if count == 0 { Vec::new() } else { vec![sentence] }
}

fn stretch_range(gradients: &[Mat3], inside: &[usize]) -> [f64; 2] {
    inside
        .iter()
        .map(|&t| principal_stretches(&gradients[t]))
        .fold([f64::INFINITY, 0.0], |[low, high], stretches| {
            [low.min(stretches[2]), high.max(stretches[0])]
        })
}
