//! Nearest neighbours in a set of points.

use super::box_tree::{Bounds, BoxTree};
use crate::math::Vec3;

/// Answers nearest-neighbour questions on a fixed set of points.
#[derive(Clone, Debug)]
pub struct NearestPoints {
    points: Vec<Vec3>,
    tree: BoxTree,
}

impl NearestPoints {
    /// Builds the search tree.
    pub fn new(points: &[Vec3]) -> Self {
        let bounds: Vec<Bounds> = points.iter().map(|&p| Bounds { low: p, high: p }).collect();
        Self { points: points.to_vec(), tree: BoxTree::new(&bounds) }
    }

    /// Index and distance of the point nearest to `p`, the lowest index of equally near ones; None
    /// without points or for a `p` that is not finite.
    pub fn nearest(&self, p: &Vec3) -> Option<(u32, f64)> {
        if !p.iter().all(|c| c.is_finite()) {
            return None;
        }
        let (point, distance_squared, ()) = self
            .tree
            .nearest(p, f64::INFINITY, |i, _| ((self.points[i as usize] - p).norm_squared(), ()))?;
        Some((point, distance_squared.sqrt()))
    }

    /// Indices and squared distances of the `N` points nearest to `p`, nearest first, the lower index first of
    /// equally near ones; `(u32::MAX, INFINITY)` where there are fewer points.
    pub fn few_nearest<const N: usize>(&self, p: &Vec3) -> [(u32, f64); N] {
        let mut few = [(u32::MAX, f64::INFINITY); N];
        self.tree.visit_nearest(p, f64::INFINITY, |i, _| {
            let mut own = (i, (self.points[i as usize] - p).norm_squared());
            for known in &mut few {
                if own.1 < known.1 || (own.1 <= known.1 && own.0 < known.0) {
                    std::mem::swap(known, &mut own);
                }
            }
            few[N - 1].1
        });
        few
    }

    /// All points at most `distance` away from `p`, in ascending order.
    pub fn within(&self, p: &Vec3, distance: f64) -> Vec<u32> {
        let mut found = Vec::new();
        self.tree.visit_within(p, distance, |i| {
            if (self.points[i as usize] - p).norm() <= distance {
                found.push(i);
            }
        });
        found.sort_unstable();
        found
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact answers are the claim
mod tests {
    use super::*;
    use crate::locate::test_shapes::Noise;

    #[test]
    fn agrees_with_brute_force() {
        let mut noise = Noise::new(7);
        let points: Vec<Vec3> = (0..200).map(|_| noise.vector()).collect();
        let nearest = NearestPoints::new(&points);
        for _ in 0..100 {
            let p = noise.vector() * 1.2;
            let distances: Vec<f64> = points.iter().map(|q| (q - p).norm()).collect();
            let (i, d) = nearest.nearest(&p).unwrap();
            assert!(distances.iter().all(|&other| d <= other));
            assert_eq!(d, distances[i as usize]);
            let close: Vec<u32> = (0..200).filter(|&i| distances[i as usize] <= 0.6).collect();
            assert_eq!(nearest.within(&p, 0.6), close);
            let mut order: Vec<u32> = (0..200).collect();
            order.sort_by(|&a, &b| distances[a as usize].total_cmp(&distances[b as usize]));
            assert_eq!(nearest.few_nearest::<5>(&p).map(|(i, _)| i)[..], order[..5]);
        }
    }

    #[test]
    fn fewer_points_than_asked_for_are_filled_up() {
        let twice = [Vec3::repeat(1.0); 2];
        let few = NearestPoints::new(&twice).few_nearest::<3>(&Vec3::zeros());
        assert_eq!(few, [(0, 3.0), (1, 3.0), (u32::MAX, f64::INFINITY)]);
    }
}
