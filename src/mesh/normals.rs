//! Normals of triangles and vertices.

use rayon::prelude::*;

use crate::math::Vec3;

/// Twice the area of each triangle along its normal.
pub fn area_vectors(points: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let of = |&[a, b, c]: &[u32; 3]| {
        let a = points[a as usize];
        (points[b as usize] - a).cross(&(points[c as usize] - a))
    };
    triangles.par_iter().with_min_len(1024).map(of).collect()
}

/// Unit vertex normals: the sum of the area vectors around each of `count` vertices.
pub fn vertex_normals(count: usize, triangles: &[[u32; 3]], area_vectors: &[Vec3]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::zeros(); count];
    for (&[a, b, c], area) in triangles.iter().zip(area_vectors) {
        sums[a as usize] += area;
        sums[b as usize] += area;
        sums[c as usize] += area;
    }
    sums.iter().map(unit_or_zero).collect()
}

/// A direction; zero for a vector without length.
pub fn unit_or_zero(v: &Vec3) -> Vec3 {
    v.try_normalize(f64::MIN_POSITIVE).unwrap_or_default()
}
