//! An even choice of vertices that stands for all of them.

use std::ops::Range;

use rayon::prelude::*;

use super::neighbours::PointGrid;
use crate::math::Vec3;

/// Chosen vertices with the area each stands for.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    pub(super) vertices: Vec<u32>,
    pub(super) areas: Vec<f64>,
}

/// A bone with fewer places than this is not held by them,
const LEAST_OF_BONE: usize = 4;
/// and is sampled at about so many.
const OF_SMALL_BONE: f64 = 24.0;

impl Samples {
    /// Vertices at least `spacing` apart; bones that would have too few of them to be held are sampled
    /// by themselves, more densely. `bone_of` gives the bone of each vertex; a bone's vertices stand
    /// together. Comes with the factor by which there are more than of even ones.
    pub(super) fn of_bones(
        points: &[Vec3],
        areas: &[f64],
        bone_of: &[u32],
        spacing: f64,
    ) -> (Self, f64) {
        let even = Self::new(points, areas, spacing);
        let mut bones = Vec::new();
        let mut first = 0;
        for bone in bone_of.chunk_by(|a, b| a == b) {
            bones.push(first..first + bone.len());
            first += bone.len();
        }
        let is_small = |bone: &Range<usize>| {
            let own = even.vertices.iter().filter(|&&v| bone.contains(&(v as usize)));
            own.count() < LEAST_OF_BONE.min(bone.len())
        };
        let (small, large): (Vec<_>, Vec<_>) = bones.into_iter().partition(is_small);
        if small.is_empty() {
            return (even, 1.0);
        }
        let count = even.vertices.len() as f64;
        let mut all = Self::default();
        all.add(points, areas, &large.into_iter().flatten().collect::<Vec<_>>(), spacing);
        for bone in small {
            let area: f64 = areas[bone.clone()].iter().sum();
            let dense = (area / OF_SMALL_BONE).sqrt();
            all.add(points, areas, &bone.collect::<Vec<_>>(), dense.min(spacing));
        }
        let factor = all.vertices.len() as f64 / count;
        (all, factor)
    }

    /// Adds an even choice of some vertices.
    fn add(&mut self, points: &[Vec3], areas: &[f64], of: &[usize], spacing: f64) {
        let local: Vec<Vec3> = of.iter().map(|&v| points[v]).collect();
        let local_areas: Vec<f64> = of.iter().map(|&v| areas[v]).collect();
        let own = Self::new(&local, &local_areas, spacing);
        self.vertices.extend(own.vertices.iter().map(|&v| of[v as usize] as u32));
        self.areas.extend(own.areas);
    }

    /// Vertices at least `spacing` apart; every vertex gives its area to the nearest chosen one.
    /// A spacing of 0 takes all.
    pub(super) fn new(points: &[Vec3], areas: &[f64], spacing: f64) -> Self {
        if spacing <= 0.0 || points.is_empty() {
            return Self { vertices: (0..points.len() as u32).collect(), areas: areas.to_vec() };
        }
        let mut grid = PointGrid::empty(points, spacing);
        let mut vertices = Vec::new();
        let mut slot = vec![u32::MAX; points.len()];
        for i in 0..points.len() as u32 {
            if !grid.any_within(&points[i as usize], |_| true) {
                grid.insert(i);
                slot[i as usize] = vertices.len() as u32;
                vertices.push(i);
            }
        }
        let mut sums = vec![0.0; vertices.len()];
        let nearest: Vec<Option<u32>> = points.par_iter().map(|p| grid.nearest(p)).collect();
        for (nearest, &area) in nearest.into_iter().zip(areas) {
            if let Some(i) = nearest {
                sums[slot[i as usize] as usize] += area;
            }
        }
        Self { vertices, areas: sums }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_keep_their_distance_and_share_out_all_area() {
        let points: Vec<Vec3> = (0..100).map(|i| Vec3::new(f64::from(i) * 0.1, 0.0, 0.0)).collect();
        let areas = vec![2.0; 100];
        let samples = Samples::new(&points, &areas, 0.95);
        assert_eq!(samples.vertices.len(), 10);
        assert!((samples.areas.iter().sum::<f64>() - 200.0).abs() < 1e-9);
        assert_eq!(Samples::new(&points, &areas, 0.0).vertices.len(), 100);
    }
}
