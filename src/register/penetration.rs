//! How deep bones of a result lie in each other.

use rayon::prelude::*;

use super::skeleton::Skeleton;
use crate::locate::{ClosestPoints, WindingNumber};
use crate::math::Vec3;
use crate::mesh::bounding_box;

/// The deepest place of a bone inside another one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Penetration {
    /// Distance of the deepest vertex to the other bone's surface.
    pub(super) depth: f64,
    /// The other bone.
    pub(super) into: usize,
}

struct Solid {
    low: Vec3,
    high: Vec3,
    winding: WindingNumber,
    closest: ClosestPoints,
}

/// For every bone where one of its vertices lies deepest inside another bone, if any does.
pub(super) fn penetrations(skeleton: &Skeleton) -> Vec<Option<Penetration>> {
    let solids: Vec<Option<Solid>> =
        (0..skeleton.bones.len()).into_par_iter().map(|b| Solid::new(skeleton, b)).collect();
    let deepest = |b: usize| {
        let points = &skeleton.points[skeleton.bones[b].vertices.clone()];
        let (low, high) = bounding_box(points)?;
        let others = solids.iter().enumerate().filter(|(other, _)| *other != b);
        others
            .filter_map(|(other, solid)| Some((other, solid.as_ref()?)))
            .filter(|(_, solid)| (0..3).all(|k| solid.low[k] <= high[k] && low[k] <= solid.high[k]))
            .map(|(into, solid)| Penetration { depth: solid.depth(points), into })
            .filter(|p| p.depth > 0.0)
            .max_by(|p, q| p.depth.total_cmp(&q.depth))
    };
    (0..skeleton.bones.len()).into_par_iter().map(deepest).collect()
}

impl Solid {
    fn new(skeleton: &Skeleton, b: usize) -> Option<Self> {
        let surface = skeleton.bone_surface(b, &skeleton.points);
        let (low, high) = bounding_box(&surface.points)?;
        Some(Self {
            low,
            high,
            winding: WindingNumber::new(&surface.points, &surface.triangles),
            closest: ClosestPoints::new(&surface.points, &surface.triangles),
        })
    }

    /// Depth of the deepest of `points`; 0 when none is inside.
    fn depth(&self, points: &[Vec3]) -> f64 {
        points
            .iter()
            .filter(|p| (0..3).all(|k| self.low[k] <= p[k] && p[k] <= self.high[k]))
            .filter(|p| self.winding.is_inside(p))
            .filter_map(|p| self.closest.closest(p).map(|found| found.distance))
            .fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::skeleton::tests::block;

    #[test]
    fn the_deepest_vertex_counts() {
        let a = block(Vec3::zeros(), Vec3::new(4.0, 2.0, 2.0), 8);
        let b = block(Vec3::new(5.5, 0.0, 0.0), Vec3::new(2.0, 1.0, 1.0), 8);
        let far = block(Vec3::new(50.0, 0.0, 0.0), Vec3::repeat(1.0), 2);
        let skeleton =
            Skeleton::new(vec![("a".into(), a), ("b".into(), b), ("c".into(), far)], vec![])
                .unwrap();
        let found = penetrations(&skeleton);
        let of_b = found[1].as_ref().unwrap();
        assert!(of_b.into == 0 && (of_b.depth - 0.5).abs() < 0.05, "{of_b:?}");
        assert_eq!(found[2], None);
    }
}
