//! What lies inside a closed surface, and how deep.

use super::{ClosestPoints, WindingNumber};
use crate::math::Vec3;
use crate::mesh::bounding_box;

/// A closed surface in a box, ready for questions.
#[derive(Clone, Debug)]
pub struct Solid {
    low: Vec3,
    high: Vec3,
    winding: WindingNumber,
    /// The surface's closest points.
    pub closest: ClosestPoints,
}

impl Solid {
    /// The inside of `triangles`; nothing is inside when there are no points.
    pub fn new(points: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let (low, high) = bounding_box(points).unwrap_or_default();
        Self {
            low,
            high,
            winding: WindingNumber::new(points, triangles),
            closest: ClosestPoints::new(points, triangles),
        }
    }

    /// Whether the boxes around two surfaces come within `margin` of each other.
    pub fn boxes_meet(&self, other: &Self, margin: f64) -> bool {
        (0..3)
            .all(|k| self.low[k] <= other.high[k] + margin && other.low[k] <= self.high[k] + margin)
    }

    /// Whether a point lies within `margin` of the box around the surface.
    pub fn box_holds(&self, p: &Vec3, margin: f64) -> bool {
        (0..3).all(|k| self.low[k] - margin <= p[k] && p[k] <= self.high[k] + margin)
    }

    /// Whether a point lies inside, by its winding number.
    pub fn holds(&self, p: &Vec3) -> bool {
        self.box_holds(p, 0.0) && self.winding.is_inside(p)
    }

    /// Distances to the surface of those of `points` that lie inside.
    pub fn depths(&self, points: &[Vec3]) -> Vec<f64> {
        let inside = points.iter().filter(|p| self.holds(p));
        inside.filter_map(|p| self.closest.closest(p).map(|found| found.distance)).collect()
    }
}
