//! An even choice of vertices that stands for all of them.

use super::neighbours::PointGrid;
use crate::math::Vec3;

/// Chosen vertices with the area each stands for.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    pub(super) vertices: Vec<u32>,
    pub(super) areas: Vec<f64>,
}

impl Samples {
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
        for (p, &area) in points.iter().zip(areas) {
            let distance = |i: u32| (points[i as usize] - p).norm_squared();
            let near = grid.within(p);
            if let Some(best) =
                near.into_iter().min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
            {
                sums[slot[best as usize] as usize] += area;
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
