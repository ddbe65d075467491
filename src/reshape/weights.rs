//! What every datum weighs at a shape: 1 / sigma^2, less for outliers.

use crate::math::{Vec3, robust_deviation};

use super::correspondences::Correspondences;
use super::scene::{Pair, Scene};

/// Residuals beyond this many sigmas are taken for outliers.
pub const OUTLIER: f64 = 3.0;

/// Markers farther off than this many standard deviations are far.
const FAR: f64 = 5.0;

/// 1 / sigma^2 of every datum, robust factors included.
#[derive(Clone, Debug, Default)]
pub struct Weights {
    /// Per marker.
    pub markers: Vec<f64>,
    /// Per landmark.
    pub landmarks: Vec<f64>,
    /// Per attachment.
    pub attachments: Vec<f64>,
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

impl Weights {
    /// From the present residuals. `gains`: what each attachment's weight is multiplied by.
    pub fn new(
        scene: &Scene,
        correspondences: &Correspondences,
        x: &[Vec3],
        weighting: Weighting,
        gains: &[f64],
    ) -> Self {
        let distances = correspondences.distances();
        let c = weighting.scale / scene.marker_sigma.powi(2);
        let limit = if weighting.robust {
            OUTLIER * robust_deviation(&distances, scene.marker_sigma)
        } else {
            f64::INFINITY
        };
        let markers = scene
            .markers
            .iter()
            .zip(&distances)
            .map(|((_, weight), d)| c * weight * (limit / d).min(1.0))
            .collect();
        // Without markers nothing speaks against a pair, however far it has to go.
        let doubted = !scene.markers.is_empty();
        let group = |pairs: &[Pair], sigma: f64, doubted: bool| {
            if doubted { group_weights(pairs, x, sigma) } else { plain_weights(pairs, sigma) }
        };
        let attachments = &scene.attachments;
        let attachments =
            group(attachments, scene.attachment_sigma, doubted && !scene.hard_attachments);
        Self {
            markers,
            landmarks: group(&scene.landmarks, scene.landmark_sigma, doubted),
            attachments: attachments
                .iter()
                .zip(gains)
                .map(|(weight, gain)| weight * gain)
                .collect(),
        }
    }
}

/// Pairs that are not doubted.
fn plain_weights(pairs: &[Pair], tolerance: f64) -> Vec<f64> {
    pairs.iter().map(|pair| pair.weight / tolerance.powi(2)).collect()
}

/// Pairs are weighted by the noise of their group, which is estimated from the residuals (never below
/// the tolerance), and single ones far beyond it fade out (Geman-McClure). So bad landmarks lose to
/// the markers, good ones are met exactly.
fn group_weights(pairs: &[Pair], x: &[Vec3], tolerance: f64) -> Vec<f64> {
    let residuals = pair_distances(pairs, x);
    let sigma = robust_deviation(&residuals, tolerance);
    pairs
        .iter()
        .zip(&residuals)
        .map(|(pair, r)| pair.weight / (sigma * (1.0 + (r / (OUTLIER * sigma)).powi(2))).powi(2))
        .collect()
}

fn pair_distances(pairs: &[Pair], x: &[Vec3]) -> Vec<f64> {
    pairs.iter().map(|p| (p.point.position(x) - p.target).norm()).collect()
}

/// Whether any marker lies far beyond the others' noise.
pub fn has_far_markers(scene: &Scene, correspondences: &Correspondences) -> bool {
    let distances = correspondences.distances();
    let far = FAR * robust_deviation(&distances, scene.marker_sigma);
    distances.iter().any(|distance| *distance > far)
}

/// The attachments beyond the tolerance, but for outliers. None where most are beyond it: there they
/// and the markers contradict each other, and the markers are followed.
pub fn lagging_attachments(scene: &Scene, x: &[Vec3]) -> Vec<usize> {
    let (attachments, tolerance) = (&scene.attachments, scene.attachment_sigma);
    let distances = pair_distances(attachments, x);
    if robust_deviation(&distances, tolerance) > tolerance {
        return Vec::new();
    }
    let lags = |distance: f64| distance > tolerance && distance <= OUTLIER * tolerance;
    (0..distances.len()).filter(|&i| lags(distances[i]) && attachments[i].weight > 0.0).collect()
}
