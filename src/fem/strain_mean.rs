//! The mean that a screened strain returns to away from data.
//!
//! The strain is a constant a and a field about it, each with a price:
//!
//!   1/2 u^T R u = min over a of 1/2 (u - 1 a)^T K (u - 1 a) + 1/2 |a|^2 / sigma^2
//!
//! with K the screened bi-Laplacian. Then R = K - K 1 (1/sigma^2 + 1^T K 1)^-1 1^T K and
//! R^-1 = K^-1 + sigma^2 1 1^T, for each component of the strain.

use faer::Mat;
use nalgebra::Vector6;

use crate::math::Sym3;
use crate::math::symmetric3::MULTIPLICITY;

/// The mean of a strain field.
pub struct StrainMean {
    /// sigma^2.
    variance: f64,
    /// K 1.
    force: Vec<f64>,
    /// (1/sigma^2 + 1^T K 1)^-1.
    compliance: f64,
}

impl StrainMean {
    /// With a standard deviation and the force K 1 of a unit constant.
    pub fn new(sigma: f64, force: Vec<f64>) -> Self {
        let variance = sigma * sigma;
        let compliance = 1.0 / (1.0 / variance + force.iter().sum::<f64>());
        Self { variance, force, compliance }
    }

    /// The energy that a field `u` is spared for being a constant in part.
    pub(super) fn energy(&self, u: &[Sym3]) -> f64 {
        let pull = self.pull(u);
        let squares = (0..6).map(|p| MULTIPLICITY[p] * pull[p] * pull[p]);
        0.5 * self.compliance * squares.sum::<f64>()
    }

    /// The same of the gradient, taken from `gradient`.
    pub(super) fn take_from(&self, gradient: &mut [Sym3], u: &[Sym3]) {
        let pull = self.pull(u) * self.compliance;
        let pull = Sym3::from_fn(|p, _| MULTIPLICITY[p] * pull[p]);
        gradient.iter_mut().zip(&self.force).for_each(|(g, force)| *g -= pull * *force);
    }

    /// sigma^2 1^T b: the constant that answers a force.
    pub(super) fn answer(&self, b: &[Sym3]) -> Sym3 {
        let total: Sym3 = b.iter().sum();
        Sym3::from_fn(|p, _| self.variance * total[p] / MULTIPLICITY[p])
    }

    /// Prior standard deviation of each component.
    pub fn sigma(&self) -> Sym3 {
        Sym3::from_fn(|p, _| (self.variance / MULTIPLICITY[p]).sqrt())
    }

    /// Adds Z (sigma^2 1 1^T) Z^T to the lower triangle of `gram`; `sums` are Z 1, by row of Z.
    pub fn add_to_gram(&self, gram: &mut Mat<f64>, sums: &[Vector6<f64>]) {
        let scale = Vector6::from_fn(|p, _| self.variance / MULTIPLICITY[p]);
        for (j, sum) in sums.iter().enumerate() {
            let scaled = sum.component_mul(&scale);
            for (i, other) in sums.iter().enumerate().skip(j) {
                gram[(i, j)] += other.dot(&scaled);
            }
        }
    }

    /// 1^T K u.
    fn pull(&self, u: &[Sym3]) -> Sym3 {
        u.iter().zip(&self.force).map(|(u, force)| u * *force).sum()
    }
}
