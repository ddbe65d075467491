//! Distances between points and surfaces, and figures of many.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::locate::{ClosestPoints, NearestPoints};
use crate::math::Vec3;

/// Mean, 95th percentile and largest of some distances, in the template's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Largest.
    pub max: f64,
}

impl Spread {
    /// Of a list; zeros without values.
    pub fn of(values: &[f64]) -> Self {
        if values.is_empty() {
            return Self::default();
        }
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len() - 1;
        Self {
            mean: sorted.iter().sum::<f64>() / sorted.len() as f64,
            p95: sorted[(0.95 * last as f64).round() as usize],
            max: sorted[last],
        }
    }
}

/// Distance of each marker to a surface.
pub fn marker_distances(points: &[Vec3], triangles: &[[u32; 3]], markers: &[Vec3]) -> Vec<f64> {
    let closest = ClosestPoints::new(points, triangles);
    closest.closest_many(markers).into_iter().map(|hit| hit.map_or(0.0, |h| h.distance)).collect()
}

/// Distance of each surface vertex to the nearest marker.
pub fn distance_to_markers(points: &[Vec3], markers: &[Vec3]) -> Vec<f64> {
    let nearest = NearestPoints::new(markers);
    points.par_iter().map(|p| nearest.nearest(p).map_or(0.0, |(_, distance)| distance)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_has_mean_percentile_and_largest() {
        let spread = Spread::of(&[3.0, 1.0, 2.0]);
        assert_eq!(spread, Spread { mean: 2.0, p95: 3.0, max: 3.0 });
    }
}
