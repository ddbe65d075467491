//! All data of a problem.

use super::carried_surface::CarriedSurface;
use super::correspondences::Correspondences;
use super::coverage::Coverage;
use super::folds::Folds;
use super::markers::Markers;
use super::paired_points::PairedPoints;
use super::pins::Pins;
use super::rows::Rows;
use super::term::{Place, Term, Weighed, Weighting};
use crate::math::Vec3;

/// The data, and the surface that they speak of.
pub struct DataTerms {
    /// The template's surface.
    pub surface: CarriedSurface,
    /// Markers.
    pub markers: Markers,
    /// Landmarks that are weighed against the markers.
    pub landmarks: PairedPoints,
    /// Landmarks that are not.
    pub pins: Pins,
    /// Attachments.
    pub attachments: PairedPoints,
    /// Where the markers cover the person, when that can be known.
    pub coverage: Option<Coverage>,
    /// The surface's edges, which are kept from folding over.
    pub folds: Option<Folds>,
}

/// What the data say about a shape.
#[derive(Default)]
pub struct DataEvaluation {
    /// The robust cost.
    pub cost: f64,
    /// The weights of each term.
    pub weights: Vec<Vec<f64>>,
    /// The residual rows at these weights.
    pub rows: Rows,
}

impl DataTerms {
    /// Where the markers touch the shape `x`.
    pub fn correspondences(&self, x: &[Vec3]) -> Correspondences {
        Correspondences::new(&self.surface, &self.markers.positions, self.markers.sigma, x)
    }

    /// What the data say about the shape `x`.
    pub fn evaluate(
        &self,
        x: &[Vec3],
        correspondences: &Correspondences,
        weighting: Weighting,
    ) -> DataEvaluation {
        let place = self.place(x, correspondences);
        let mut all = DataEvaluation::default();
        for term in self.terms() {
            let first = all.rows.rows.len();
            let Weighed { weights, cost } = term.weigh(&place, weighting);
            term.add_rows(&place, &weights, &mut all.rows);
            all.cost += cost.unwrap_or_else(|| all.rows.energy_from(first));
            all.weights.push(weights);
        }
        all
    }

    /// The rows of the shape `x` at given weights of each term.
    pub fn rows(
        &self,
        x: &[Vec3],
        correspondences: &Correspondences,
        weights: &[Vec<f64>],
    ) -> Rows {
        let place = self.place(x, correspondences);
        let mut rows = Rows::default();
        for (term, weights) in self.terms().zip(weights) {
            term.add_rows(&place, weights, &mut rows);
        }
        rows
    }

    /// Fewer rows that stand for them, where the markers are many.
    pub fn representatives(
        &self,
        x: &[Vec3],
        correspondences: &Correspondences,
        weights: &[Vec<f64>],
    ) -> Option<Rows> {
        if !self.markers.are_grouped() {
            return None;
        }
        let place = self.place(x, correspondences);
        let mut rows = Rows::default();
        for (term, weights) in self.terms().zip(weights) {
            term.add_representatives(&place, weights, &mut rows);
        }
        Some(rows)
    }

    fn place<'a>(&'a self, x: &'a [Vec3], correspondences: &'a Correspondences) -> Place<'a> {
        Place { surface: &self.surface, x, correspondences }
    }

    fn terms(&self) -> impl Iterator<Item = &dyn Term> {
        let pairs: [&dyn Term; 4] = [&self.markers, &self.landmarks, &self.pins, &self.attachments];
        let coverage = self.coverage.iter().map(|coverage| coverage as &dyn Term);
        pairs.into_iter().chain(coverage).chain(self.folds.iter().map(|folds| folds as &dyn Term))
    }
}
