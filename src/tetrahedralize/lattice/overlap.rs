//! Whether a triangle and a tet overlap, by the separating-axis theorem.

use crate::math::Vec3;

/// Overlaps thinner than this (in cell edges) do not count: a surface that lies in a lattice plane
/// would otherwise take the tets on both sides.
const TOUCH: f64 = 1e-9;

/// Whether a triangle and a tet share more than a touch. Lengths in cell edges.
pub fn triangle_overlaps_tet(triangle: &[Vec3; 3], tet: &[Vec3; 4]) -> bool {
    let [a, b, c] = *triangle;
    let [p, q, r, s] = *tet;
    let sides = [b - a, c - b, a - c];
    let edges = [q - p, r - p, s - p, r - q, s - q, s - r];
    let separated = |axis: Vec3| {
        let length = axis.norm();
        if length < TOUCH {
            return false;
        }
        let (low_a, high_a) = range(&axis, triangle);
        let (low_b, high_b) = range(&axis, tet);
        low_a > high_b - TOUCH * length || low_b > high_a - TOUCH * length
    };
    let normal = sides[0].cross(&sides[1]);
    let in_plane_of_normal = {
        // A flat triangle has no extent along its normal: only a true gap separates there.
        let (low, high) = range(&normal, tet);
        let at = normal.dot(&a);
        at > high - TOUCH * normal.norm() || at < low + TOUCH * normal.norm()
    };
    if normal.norm() > 0.0 && in_plane_of_normal {
        return false;
    }
    let faces = [[0, 1], [0, 2], [1, 2], [3, 4]];
    !faces.iter().any(|&[i, j]| separated(edges[i].cross(&edges[j])))
        && !sides.iter().any(|side| edges.iter().any(|edge| separated(side.cross(edge))))
}

fn range(axis: &Vec3, points: &[Vec3]) -> (f64, f64) {
    points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
        let along = axis.dot(p);
        (low.min(along), high.max(along))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossing_touching_and_apart() {
        let tet = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let moved = |triangle: [Vec3; 3], by: Vec3| triangle.map(|p| p + by);
        let large =
            [Vec3::new(-5.0, -5.0, 0.0), Vec3::new(9.0, -5.0, 0.0), Vec3::new(0.0, 9.0, 0.0)];
        assert!(triangle_overlaps_tet(&moved(large, Vec3::z() * 0.5), &tet));
        assert!(!triangle_overlaps_tet(&large, &tet), "it only lies in the face");
        assert!(!triangle_overlaps_tet(&moved(large, Vec3::z() * 1.1), &tet));
        let small = [Vec3::zeros(), Vec3::x() * 0.1, Vec3::y() * 0.1];
        assert!(triangle_overlaps_tet(&moved(small, Vec3::repeat(0.2)), &tet), "wholly inside");
        // Beyond the slanted face although within the box of the tet.
        assert!(!triangle_overlaps_tet(&moved(small, Vec3::repeat(0.4)), &tet));
    }
}
