//! What is left between a shape and its target: shape that finer clusters would follow, or noise.

use super::correspond::Correspondences;
use crate::math::Vec3;

/// Neighbours' distances agree at least so much where they are shape. Bones of other persons have .55 to
/// .85 with their own surfaces, scans with noise 0 to .45.
const AGREEMENT: f64 = 0.5;

/// Whether the distances from `points` to the surface are larger than `tolerance` and those of neighbours
/// agree, so that they are no noise. Vertices without a pair do not count.
pub(super) fn is_left(
    pairs: &Correspondences,
    points: &[Vec3],
    edges: &[[u32; 2]],
    tolerance: f64,
) -> bool {
    let distance = |i: usize| (pairs.wanted[i] - points[i]).dot(&pairs.normals[i]);
    let (mut products, mut squares, mut weights) = (0.0, 0.0, 0.0);
    for &[i, j] in edges {
        let (i, j) = (i as usize, j as usize);
        let weight = (pairs.trust[i] * pairs.trust[j]).sqrt();
        let (a, b) = (distance(i), distance(j));
        products += weight * a * b;
        squares += weight * f64::midpoint(a * a, b * b);
        weights += weight;
    }
    squares > weights * tolerance.powi(2) && products > AGREEMENT * squares
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::{Noise, sphere};
    use crate::mesh::TriMesh;
    use crate::mesh::adjacency::edges;
    use crate::register::options::Options;
    use crate::register::register;
    use crate::register::skeleton::Skeleton;
    use crate::register::target::Target;
    use crate::run::Run;

    #[test]
    fn a_bump_is_shape_and_noise_is_not() {
        let (points, triangles) = sphere(20, 40);
        let edges = edges(&triangles);
        let left = |off: &mut dyn FnMut(&Vec3) -> f64, tolerance: f64| {
            let wanted = points.iter().map(|p| p + off(p) * p).collect();
            let trust = vec![1.0; points.len()];
            let normals = points.clone();
            let pairs = Correspondences { wanted, trust, normals, ..Correspondences::default() };
            is_left(&pairs, &points, &edges, tolerance)
        };
        let mut bumps = |p: &Vec3| 0.1 * libm::sin(5.0 * p.x) * libm::sin(5.0 * p.y);
        assert!(left(&mut bumps, 0.01) && !left(&mut bumps, 0.2));
        let mut noise = Noise::new(7);
        assert!(!left(&mut |_| 0.1 * noise.vector().x, 0.01));
        assert!(!left(&mut |_| 0.0, 0.01));
    }

    #[test]
    fn finer_levels_follow_a_clean_target_and_leave_noise() {
        let (points, triangles) = sphere(40, 80);
        let template = TriMesh { points, triangles };
        let skeleton = Skeleton::new(vec![("ball".into(), template.clone())], vec![]).unwrap();
        let options = Options { align: false, ..Options::default() };
        let found = |off: &mut dyn FnMut(&Vec3) -> f64| {
            let points = template.points.iter().map(|p| p + off(p) * p).collect();
            let target = Target::whole(TriMesh { points, ..template.clone() }).unwrap();
            register(&skeleton, &target, &options, &Run::new()).unwrap()
        };
        let rippled = found(&mut |p| 0.01 * libm::sin(20.0 * p.x));
        let mut noise = Noise::new(5);
        let noisy = found(&mut |_| 0.01 * noise.vector().x);
        assert!(rippled.levels.len() > noisy.levels.len(), "{:?}", rippled.levels);
        assert!(rippled.bones[0].mean_residual < 0.001, "{:?}", rippled.bones);
    }
}
