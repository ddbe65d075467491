//! The point of a triangle closest to a given point.
//!
//! C. Ericson, Real-Time Collision Detection (2004), section 5.1.5: the Voronoi region of the point
//! decides between corners, edges and the inside.

use crate::math::Vec3;

/// Barycentric coordinates of the point of triangle (a, b, c) closest to `p`: never negative, sum 1,
/// exactly 0 off the feature hit. Triangles without area are handled as their longest edge or point.
pub fn closest_on_triangle(p: &Vec3, [a, b, c]: &[Vec3; 3]) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let to_a = p - a;
    let (d1, d2) = (ab.dot(&to_a), ac.dot(&to_a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let to_b = p - b;
    let (d3, d4) = (ab.dot(&to_b), ac.dot(&to_b));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let to_c = p - c;
    let (d5, d6) = (ab.dot(&to_c), ac.dot(&to_c));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    // Areas of the sub-triangles, times the squared area normal's length.
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let total = va + vb + vc;
    let degenerate = total <= f64::EPSILON * ab.norm_squared() * ac.norm_squared();
    if degenerate {
        return closest_on_edges(p, &[*a, *b, *c]);
    }
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let (v, w) = (vb / total, vc / total);
    [1.0 - v - w, v, w]
}

/// The closest point of the three edges; they may have no length.
fn closest_on_edges(p: &Vec3, corners: &[Vec3; 3]) -> [f64; 3] {
    let mut best = ([1.0, 0.0, 0.0], f64::INFINITY);
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let edge = corners[j] - corners[i];
        let length_squared = edge.norm_squared();
        let along = if length_squared > 0.0 {
            ((p - corners[i]).dot(&edge) / length_squared).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let distance = (corners[i] + edge * along - p).norm_squared();
        if distance < best.1 {
            let mut weights = [0.0; 3];
            weights[i] = 1.0 - along;
            weights[j] = along;
            best = (weights, distance);
        }
    }
    best.0
}

/// The point of a triangle at barycentric coordinates.
pub(super) fn at(barycentric: &[f64; 3], corners: &[Vec3; 3]) -> Vec3 {
    corners[0] * barycentric[0] + corners[1] * barycentric[1] + corners[2] * barycentric[2]
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact answers are the claim
mod tests {
    use super::*;

    #[test]
    fn each_region_of_a_triangle_is_hit() {
        let (a, b, c) = (Vec3::zeros(), Vec3::x(), Vec3::y());
        let closest = |x, y| closest_on_triangle(&Vec3::new(x, y, 0.7), &[a, b, c]);
        assert_eq!(closest(-1.0, -1.0), [1.0, 0.0, 0.0]);
        assert_eq!(closest(2.0, 0.0), [0.0, 1.0, 0.0]);
        assert_eq!(closest(0.0, 2.0), [0.0, 0.0, 1.0]);
        assert_eq!(closest(0.25, -1.0), [0.75, 0.25, 0.0]);
        assert_eq!(closest(-1.0, 0.25), [0.75, 0.0, 0.25]);
        assert_eq!(closest(1.0, 1.0), [0.0, 0.5, 0.5]);
        assert_eq!(closest(0.25, 0.25), [0.5, 0.25, 0.25]);
    }

    #[test]
    fn triangles_without_area_still_answer() {
        let p = Vec3::new(0.25, 1.0, 0.0);
        let line = [Vec3::zeros(), Vec3::x(), Vec3::x() * 0.5];
        assert!((at(&closest_on_triangle(&p, &line), &line) - Vec3::x() * 0.25).norm() < 1e-15);
        let doubled = [Vec3::zeros(), Vec3::zeros(), Vec3::x()];
        assert!(
            (at(&closest_on_triangle(&p, &doubled), &doubled) - Vec3::x() * 0.25).norm() < 1e-15
        );
        assert_eq!(closest_on_triangle(&p, &[Vec3::zeros(); 3])[0], 1.0);
    }
}
