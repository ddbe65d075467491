//! Markers: points of the person's surface, whose place on the template is the closest one.

use crate::math::Vec3;
use crate::math::robust::{huber, robust_deviation};

use super::correspondences::Correspondences;
use super::marker_groups::{MarkerGroup, half_spread_evenly, marker_groups};
use super::rows::Rows;
use super::term::{OUTLIER, Place, Term, Weighed, Weighting};

/// Weight of the two tangential directions of a marker beside its normal one. They are zero at the
/// closest point and only hold the step back: [W]'s point-to-point ties markers to wrong
/// correspondences; none at all makes the iteration zig-zag.
const TANGENTIAL: f64 = 0.02;

/// Near the surface, one marker in two has tangential rows, on behalf of its neighbours.
const HOLDING: usize = 2;

/// Markers farther off than this many standard deviations are far.
const FAR: f64 = 5.0;

/// All markers of a problem.
pub struct Markers {
    pub positions: Vec<Vec3>,
    /// The user's weights.
    weights: Vec<f64>,
    /// Noise of each, in units of `sigma`.
    noise: Vec<f64>,
    /// Noise of a marker whose own is not known.
    pub sigma: f64,
    /// Which ones have tangential rows.
    holds: Vec<bool>,
    /// Groups, where they are many.
    groups: Option<Vec<MarkerGroup>>,
}

impl Markers {
    /// Of positions with weights and noise, the latter in units of `sigma`.
    pub fn new(positions: Vec<Vec3>, weights: Vec<f64>, noise: Vec<f64>, sigma: f64) -> Self {
        let (holds, groups) = (half_spread_evenly(&positions), marker_groups(&positions));
        Self { positions, weights, noise, sigma, holds, groups }
    }

    /// Whether they are so many that a few stand for them.
    pub fn are_grouped(&self) -> bool {
        self.groups.is_some()
    }

    /// Whether all are explained.
    pub fn are_within_noise(&self, at: &Correspondences) -> bool {
        self.residuals(at).iter().all(|distance| *distance <= self.sigma)
    }

    /// Whether any lies far beyond the others' noise.
    pub fn any_is_far(&self, at: &Correspondences) -> bool {
        let residuals = self.residuals(at);
        let far = FAR * robust_deviation(&residuals, self.sigma);
        residuals.iter().any(|distance| *distance > far)
    }

    /// The distances, of a marker with twice the noise half of it.
    fn residuals(&self, at: &Correspondences) -> Vec<f64> {
        at.hits.iter().zip(&self.noise).map(|(hit, noise)| hit.distance / noise).collect()
    }

    fn add(&self, place: &Place, marker: usize, weight: f64, holds: bool, rows: &mut Rows) {
        let hit = &place.correspondences.hits[marker];
        let normal = place.correspondences.directions[marker];
        let gap = hit.position - self.positions[marker];
        let (t1, t2) = tangents(&normal);
        let far = hit.distance > OUTLIER * self.sigma * self.noise[marker];
        let point = place.surface.point(hit.triangle, &hit.barycentric);
        rows.add(&point, [(normal, normal.dot(&gap), weight)]);
        if holds || far {
            let holding = weight * TANGENTIAL * if far { 1.0 } else { HOLDING as f64 };
            rows.hold(&point, [t1, t2].map(|t| (t, t.dot(&gap), holding)));
        }
    }
}

impl Term for Markers {
    /// Those beyond [`OUTLIER`] times the noise of all lose weight.
    fn weigh(&self, place: &Place, weighting: Weighting) -> Weighed {
        let residuals = self.residuals(place.correspondences);
        let c = weighting.scale / self.sigma.powi(2);
        let limit = OUTLIER * robust_deviation(&residuals, self.sigma);
        let (mut weights, mut sum) = (Vec::new(), 0.0);
        for ((weight, noise), r) in self.weights.iter().zip(&self.noise).zip(residuals) {
            let (cost, share) = huber(r, limit);
            sum += c * weight * cost;
            weights.push(c * weight * if weighting.robust { share } else { 1.0 } / noise.powi(2));
        }
        Weighed { weights, cost: Some(sum) }
    }

    fn add_rows(&self, place: &Place, weights: &[f64], rows: &mut Rows) {
        for (i, &weight) in weights.iter().enumerate() {
            self.add(place, i, weight, self.holds[i], rows);
        }
    }

    fn add_representatives(&self, place: &Place, weights: &[f64], rows: &mut Rows) {
        // Neighbours follow each other among the groups, too.
        for (i, group) in self.groups.iter().flatten().enumerate() {
            let weight = group.members.iter().map(|&m| weights[m as usize]).sum();
            self.add(place, group.middle as usize, weight, i % HOLDING == 0, rows);
        }
    }
}

/// Two directions that complete the unit vector `n` to an orthonormal frame.
fn tangents(n: &Vec3) -> (Vec3, Vec3) {
    let axis = if n.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() };
    let t = n.cross(&axis).normalize();
    (t, n.cross(&t))
}
