//! Which triangles of two surfaces have a point in common, decided exactly.
//!
//! Two triangles that do not lie in one plane meet exactly if an edge of one meets the other
//! triangle. Signs come from adaptive exact predicates (J. Shewchuk 1997, crate `robust`), so that
//! rounding decides nothing; touching counts as crossing.

use rayon::prelude::*;
use robust::{Coord, Coord3D, orient2d, orient3d};

use super::box_tree::{Bounds, BoxTree};
use crate::math::Vec3;

/// Pairs (triangle of the first, triangle of the second surface) that have a point in common, in
/// ascending order.
pub fn crossing_triangles(
    first: (&[Vec3], &[[u32; 3]]),
    second: (&[Vec3], &[[u32; 3]]),
) -> Vec<(u32, u32)> {
    let corners = |(points, triangles): (&[Vec3], &[[u32; 3]]), t: u32| {
        triangles[t as usize].map(|v| points[v as usize])
    };
    let bounds: Vec<Bounds> =
        (0..second.1.len() as u32).map(|t| Bounds::of(&corners(second, t))).collect();
    let tree = BoxTree::new(&bounds);
    (0..first.1.len() as u32)
        .into_par_iter()
        .with_min_len(64)
        .flat_map_iter(|t| {
            let own = corners(first, t);
            let own_bounds = Bounds::of(&own);
            let mut found = Vec::new();
            tree.visit_meeting(&own_bounds, |u| {
                if bounds[u as usize].meets(&own_bounds)
                    && triangles_cross(&own, &corners(second, u))
                {
                    found.push((t, u));
                }
            });
            found.sort_unstable();
            found
        })
        .collect()
}

/// Whether two triangles have a point in common.
pub fn triangles_cross(p: &[Vec3; 3], q: &[Vec3; 3]) -> bool {
    let edges = [(0, 1), (1, 2), (2, 0)];
    edges.iter().any(|&(i, j)| segment_meets(&p[i], &p[j], q))
        || edges.iter().any(|&(i, j)| segment_meets(&q[i], &q[j], p))
}

fn segment_meets(a: &Vec3, b: &Vec3, triangle: &[Vec3; 3]) -> bool {
    let [p, q, r] = triangle;
    let (side_a, side_b) = (side(p, q, r, a), side(p, q, r, b));
    if side_a == 0 && side_b == 0 {
        return segment_meets_in_plane(a, b, triangle);
    }
    if side_a == side_b {
        return false;
    }
    // The line through a and b passes the triangle's edges all on one side.
    let turns = [side(a, b, p, q), side(a, b, q, r), side(a, b, r, p)];
    turns.iter().all(|&s| s >= 0) || turns.iter().all(|&s| s <= 0)
}

/// The same where all five points lie in one plane: along two axes in which the triangle keeps its
/// area. A triangle without area is taken as its edges along every pair of axes.
fn segment_meets_in_plane(a: &Vec3, b: &Vec3, triangle: &[Vec3; 3]) -> bool {
    let normal = (triangle[1] - triangle[0]).cross(&(triangle[2] - triangle[0]));
    let drop = normal.iamax();
    let flat = |p: &Vec3| Coord { x: p[(drop + 1) % 3], y: p[(drop + 2) % 3] };
    let [p, q, r] = [0, 1, 2].map(|k| flat(&triangle[k]));
    let (a, b) = (flat(a), flat(b));
    let inside = |x: Coord<f64>| {
        let turns = [turn(p, q, x), turn(q, r, x), turn(r, p, x)];
        turns.iter().all(|&s| s >= 0) || turns.iter().all(|&s| s <= 0)
    };
    let meets = |c: Coord<f64>, d: Coord<f64>| {
        let overlap = |a: f64, b: f64, c: f64, d: f64| a.min(b) <= c.max(d) && c.min(d) <= a.max(b);
        turn(a, b, c) * turn(a, b, d) <= 0
            && turn(c, d, a) * turn(c, d, b) <= 0
            && overlap(a.x, b.x, c.x, d.x)
            && overlap(a.y, b.y, c.y, d.y)
    };
    inside(a) || inside(b) || meets(p, q) || meets(q, r) || meets(r, p)
}

fn side(a: &Vec3, b: &Vec3, c: &Vec3, d: &Vec3) -> i32 {
    let exact = |p: &Vec3| Coord3D { x: p.x, y: p.y, z: p.z };
    sign(orient3d(exact(a), exact(b), exact(c), exact(d)))
}

fn turn(a: Coord<f64>, b: Coord<f64>, c: Coord<f64>) -> i32 {
    sign(orient2d(a, b, c))
}

fn sign(value: f64) -> i32 {
    i32::from(value > 0.0) - i32::from(value < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::{Noise, sphere};

    fn triangle(corners: [[f64; 3]; 3]) -> [Vec3; 3] {
        corners.map(Vec3::from)
    }

    #[test]
    fn piercing_touching_and_passing_are_told_apart() {
        let flat = triangle([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let piercing = triangle([[0.2, 0.2, -1.0], [0.2, 0.2, 1.0], [5.0, 5.0, 0.0]]);
        let touching = triangle([[0.2, 0.2, 0.0], [0.2, 0.2, 1.0], [0.3, 0.2, 1.0]]);
        let above = triangle([[0.2, 0.2, 1e-300], [0.2, 0.2, 1.0], [0.3, 0.2, 1.0]]);
        let beside = triangle([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [3.0, 3.0, 0.0]]);
        assert!(triangles_cross(&flat, &piercing) && triangles_cross(&piercing, &flat));
        assert!(triangles_cross(&flat, &touching) && triangles_cross(&touching, &flat));
        assert!(!triangles_cross(&flat, &above) && !triangles_cross(&above, &flat));
        assert!(!triangles_cross(&flat, &beside));
    }

    #[test]
    fn triangles_in_one_plane_are_told_apart() {
        let flat = triangle([[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 1.0, 2.0]]);
        let shifted = |x: f64| flat.map(|p| p + Vec3::new(x, x, 0.0));
        assert!(triangles_cross(&flat, &flat));
        assert!(triangles_cross(&flat, &shifted(0.4)));
        assert!(!triangles_cross(&flat, &shifted(0.6)));
        let within = flat.map(|p| Vec3::new(0.25, 0.25, 1.6) + p * 0.2);
        assert!(triangles_cross(&flat, &within) && triangles_cross(&within, &flat));
    }

    #[test]
    fn surfaces_agree_with_all_pairs() {
        let (points, triangles) = sphere(8, 11);
        let mut noise = Noise::new(5);
        for _ in 0..4 {
            let shift = noise.vector();
            let moved: Vec<Vec3> = points.iter().map(|p| p * 0.8 + shift).collect();
            let corners = |points: &[Vec3], t: usize| triangles[t].map(|v| points[v as usize]);
            let mut expected = Vec::new();
            for t in 0..triangles.len() {
                for u in 0..triangles.len() {
                    if triangles_cross(&corners(&points, t), &corners(&moved, u)) {
                        expected.push((t as u32, u as u32));
                    }
                }
            }
            let found = crossing_triangles((&points, &triangles), (&moved, &triangles));
            assert_eq!(found, expected);
        }
    }
}
