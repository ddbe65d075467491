//! Points paired on template and person: landmarks and attachments.

use crate::fem::MaterialPoint;
use crate::math::Vec3;
use crate::math::robust::{geman_mcclure, robust_deviation};

use super::rows::Rows;
use super::term::{OUTLIER, Place, Term, Weighed, Weighting};

/// A paired point.
pub struct PairedPoint {
    /// The point of the body.
    pub point: MaterialPoint,
    /// Where it belongs.
    pub target: Vec3,
    /// The user's weight.
    pub weight: f64,
}

/// The pairs of one kind.
pub struct PairedPoints {
    pub list: Vec<PairedPoint>,
    /// Noise of one that can be trusted.
    pub sigma: f64,
    /// Whether single ones may be wrong.
    pub doubted: bool,
    /// What each weight is multiplied by.
    pub gains: Vec<f64>,
}

impl PairedPoints {
    pub fn new(list: Vec<PairedPoint>, sigma: f64, doubted: bool) -> Self {
        Self { gains: vec![1.0; list.len()], list, sigma, doubted }
    }

    /// Those beyond the tolerance, but for outliers. None where most are beyond it: there they and the
    /// markers contradict each other, and the markers are followed.
    pub fn lagging(&self, x: &[Vec3]) -> Vec<usize> {
        let distances = self.distances(x);
        if robust_deviation(&distances, self.sigma) > self.sigma {
            return Vec::new();
        }
        let lags = |distance: f64| distance > self.sigma && distance <= OUTLIER * self.sigma;
        let lags = |i: &usize| lags(distances[*i]) && self.list[*i].weight > 0.0;
        (0..distances.len()).filter(lags).collect()
    }

    fn distances(&self, x: &[Vec3]) -> Vec<f64> {
        self.list.iter().map(|pair| pair.gap(x).norm()).collect()
    }
}

impl PairedPoint {
    fn gap(&self, x: &[Vec3]) -> Vec3 {
        self.point.position(x) - self.target
    }
}

impl Term for PairedPoints {
    /// The noise of all is estimated from the residuals (never below the tolerance), and single ones far
    /// beyond it fade out. So bad landmarks lose to the markers, good ones are met exactly.
    fn weigh(&self, place: &Place, _: Weighting) -> Weighed {
        let distances = self.distances(place.x);
        let (sigma, limit) = if self.doubted {
            let sigma = robust_deviation(&distances, self.sigma);
            (sigma, OUTLIER * sigma)
        } else {
            (self.sigma, f64::INFINITY)
        };
        // A noise that is found larger has its price: -log of the normal density's height.
        let price = 3.0 * libm::log(sigma / self.sigma);
        let (mut weights, mut sum) = (Vec::new(), 0.0);
        for ((pair, gain), r) in self.list.iter().zip(&self.gains).zip(distances) {
            let (cost, share) = geman_mcclure(r, limit);
            sum += pair.weight * gain * (cost / sigma.powi(2) + price);
            weights.push(pair.weight * gain * share / sigma.powi(2));
        }
        Weighed { weights, cost: Some(sum) }
    }

    fn add_rows(&self, place: &Place, weights: &[f64], rows: &mut Rows) {
        for (pair, &weight) in self.list.iter().zip(weights) {
            let gap = pair.gap(place.x);
            let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
            rows.add(&pair.point, axes.map(|d| (d, d.dot(&gap), weight)));
        }
    }
}
