//! The area that belongs to each vertex, used as its mass.

use crate::math::Vec3;

/// Mixed Voronoi area of every vertex: Voronoi cells in triangles without an obtuse angle, else
/// half of the triangle for the obtuse corner and a quarter for the others (Meyer et al. 2003).
/// The areas sum to the area of the surface; vertices without a triangle get zero.
pub fn vertex_areas(points: &[Vec3], triangles: &[[u32; 3]]) -> Vec<f64> {
    let mut areas = vec![0.0; points.len()];
    for triangle in triangles {
        let p = triangle.map(|v| points[v as usize]);
        let double_area = (p[1] - p[0]).cross(&(p[2] - p[0])).norm();
        if double_area <= 0.0 {
            continue;
        }
        let cosine: [f64; 3] =
            std::array::from_fn(|k| (p[(k + 1) % 3] - p[k]).dot(&(p[(k + 2) % 3] - p[k])));
        let obtuse = cosine.iter().position(|&c| c < 0.0);
        for k in 0..3 {
            areas[triangle[k] as usize] += match obtuse {
                Some(corner) if corner == k => double_area / 4.0,
                Some(_) => double_area / 8.0,
                None => {
                    // Squared edge times cotangent of the opposite angle, over 8, for both edges at k.
                    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                    let to_i = (p[i] - p[k]).norm_squared() * cosine[j] / double_area;
                    let to_j = (p[j] - p[k]).norm_squared() * cosine[i] / double_area;
                    (to_i + to_j) / 8.0
                }
            };
        }
    }
    areas
}

/// Mean length of the triangles' edges; 0 without triangles.
pub fn mean_edge(points: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    let total: f64 = triangles
        .iter()
        .map(|t| {
            let p = t.map(|v| points[v as usize]);
            (p[1] - p[0]).norm() + (p[2] - p[1]).norm() + (p[0] - p[2]).norm()
        })
        .sum();
    total / (3 * triangles.len().max(1)) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_areas_sum_to_the_surface() {
        let points = [[0., 0., 0.], [4., 0., 0.], [0.2, 1., 0.], [5., 3., 1.]].map(Vec3::from);
        let triangles = [[0, 1, 2], [1, 3, 2]];
        let expected: f64 = triangles
            .iter()
            .map(|t| {
                let p = t.map(|v: u32| points[v as usize]);
                (p[1] - p[0]).cross(&(p[2] - p[0])).norm() / 2.0
            })
            .sum();
        let areas = vertex_areas(&points, &triangles);
        assert!((areas.iter().sum::<f64>() - expected).abs() < 1e-12);
        assert!(areas.iter().all(|&a| a > 0.0));
        // An equilateral triangle is shared evenly.
        let even = [[0., 0., 0.], [1., 0., 0.], [0.5, 0.75_f64.sqrt(), 0.]].map(Vec3::from);
        let thirds = vertex_areas(&even, &[[0, 1, 2]]);
        assert!((thirds[0] - thirds[1]).abs() < 1e-12 && (thirds[1] - thirds[2]).abs() < 1e-12);
    }
}
