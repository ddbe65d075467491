//! What one kind of datum adds to the objective: robust least squares, by reweighting.

use super::carried_surface::CarriedSurface;
use super::correspondences::Correspondences;
use super::rows::Rows;
use crate::math::Vec3;

/// Residuals beyond this many standard deviations are taken for outliers.
pub const OUTLIER: f64 = 3.0;

/// A shape, as terms see it.
pub struct Place<'a> {
    pub surface: &'a CarriedSurface,
    /// The body's vertices.
    pub x: &'a [Vec3],
    pub correspondences: &'a Correspondences,
}

/// How the markers are weighted.
#[derive(Clone, Copy, Debug)]
pub struct Weighting {
    /// Multiplies their weight.
    pub scale: f64,
    /// Whether those far beyond the others lose weight.
    pub robust: bool,
}

impl Weighting {
    /// The weight that the tolerance gives, but for outliers.
    pub const ROBUST: Self = Self { scale: 1.0, robust: true };
    /// The same for every one, however far off.
    pub const LITERAL: Self = Self { scale: 1.0, robust: false };
}

/// What every datum of a term weighs, and the cost that these weights belong to.
#[derive(Default)]
pub struct Weighed {
    /// 1 / sigma^2 of each datum, less for outliers.
    pub weights: Vec<f64>,
    /// The robust cost: sums over the residuals r of rho(r), where a weight is rho'(r) / r. `None`: half
    /// the weighted squares.
    pub cost: Option<f64>,
}

/// A kind of data.
pub trait Term: Sync {
    /// The weights at a shape; nothing where the rows have weights of their own.
    fn weigh(&self, _: &Place, _: Weighting) -> Weighed {
        Weighed::default()
    }

    /// Adds the residual rows of a shape at given weights.
    fn add_rows(&self, place: &Place, weights: &[f64], rows: &mut Rows);

    /// Fewer rows that stand for them, where there are very many.
    fn add_representatives(&self, place: &Place, weights: &[f64], rows: &mut Rows) {
        self.add_rows(place, weights, rows);
    }
}
