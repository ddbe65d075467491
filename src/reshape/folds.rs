//! Folds of the surface: two triangles of an edge that turn over onto each other.
//!
//! Markers of two sheets that lie close, as in a hilum, may pull one sheet over the other. Tets do not
//! invert there, they become thin. So edges whose triangles turn by more than a right angle and some
//! are held back, as by a spring of the hinge.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::rows::Rows;
use super::term::{Place, Term};
use crate::fem::MaterialPoint;
use crate::math::Vec3;

/// Triangles may turn by this angle without resistance, more than a right one, or by what they do at
/// rest.
const ALLOWED: f64 = 100.0 / 180.0 * PI;

/// Each such angle beyond it counts as one standard deviation.
const SIGMA: f64 = 10.0 / 180.0 * PI;

/// The edges of a surface that are shared by two triangles of one orientation.
pub struct Folds {
    hinges: Vec<Hinge>,
}

/// An edge from the first to the second corner; the third lies to its left, the fourth to its right.
struct Hinge {
    corners: [u32; 4],
    /// Angle without resistance.
    allowed: f64,
    weight: f64,
}

impl Folds {
    /// Of a surface at rest. Triangles lower than `tolerance` count less: they turn on so short a path
    /// that they would be as stiff.
    pub fn new(points: &[Vec3], triangles: &[[u32; 3]], tolerance: f64) -> Self {
        // (smaller vertex, larger vertex, whether the triangle runs from small to large, opposite).
        let mut sides: Vec<(u32, u32, bool, u32)> = triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b, c), (b, c, a), (c, a, b)])
            .map(|(a, b, c)| (a.min(b), a.max(b), a < b, c))
            .collect();
        sides.sort_unstable();
        let hinges = sides
            .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
            .filter_map(|chunk| match *chunk {
                [(a, b, false, right), (_, _, true, left)] => Some([a, b, left, right]),
                _ => None,
            })
            .map(|corners| {
                let at = corners.map(|c| points[c as usize]);
                let [.., left, right] = gradient(&at).map(|g| 1.0 / g.norm());
                let weight = (left.min(right) / tolerance).min(1.0).powi(2);
                Hinge { corners, allowed: turn(&at).abs().max(ALLOWED), weight }
            })
            .collect();
        Self { hinges }
    }

    /// The edges that are folded too far when the surface's vertices are at `points`.
    fn excesses(&self, points: &[Vec3]) -> Vec<Fold> {
        let fold = |hinge: &Hinge| {
            let corners = hinge.corners.map(|c| points[c as usize]);
            let (left, right) = normals(&corners);
            if left.dot(&right) >= 0.0 {
                return None;
            }
            let turn = turn(&corners);
            let excess = turn.abs() - hinge.allowed;
            (excess > 0.0).then(|| Fold {
                corners: hinge.corners,
                gradient: gradient(&corners).map(|g| g * (turn.signum() / SIGMA)),
                residual: excess / SIGMA,
                weight: hinge.weight,
            })
        };
        self.hinges.par_iter().filter_map(fold).collect()
    }
}

/// An edge that is folded too far.
struct Fold {
    /// The edge's corners and the opposite ones.
    corners: [u32; 4],
    /// How the residual changes with each.
    gradient: [Vec3; 4],
    /// Angle beyond what is allowed, in standard deviations.
    residual: f64,
    /// Less than 1 where triangles are lower than what matters.
    weight: f64,
}

impl Term for Folds {
    /// One row for each edge that is folded too far.
    fn add_rows(&self, place: &Place, _: &[f64], rows: &mut Rows) {
        for fold in self.excesses(&place.correspondences.points) {
            let gradient =
                fold.corners.iter().zip(&fold.gradient).flat_map(|(&corner, gradient)| {
                    let MaterialPoint(entries) = place.surface.vertex(corner);
                    entries.into_iter().map(move |(v, w)| (v, gradient * w))
                });
            rows.push(gradient, fold.residual, fold.weight);
        }
    }
}

/// Normals of the left and the right triangle, as long as twice their areas.
fn normals([a, b, left, right]: &[Vec3; 4]) -> (Vec3, Vec3) {
    let edge = b - a;
    (edge.cross(&(left - a)), (right - a).cross(&edge))
}

/// The angle from the normal of the left triangle to that of the right one, about the edge.
fn turn(corners: &[Vec3; 4]) -> f64 {
    let edge = corners[1] - corners[0];
    let (left, right) = normals(corners);
    libm::atan2(left.cross(&right).dot(&edge), left.dot(&right) * edge.norm())
}

/// The derivative of [`turn`] by the four corners: each opposite corner turns its triangle by its
/// path along the normal over its height, and the edge's ends turn both by their shares.
fn gradient(corners: &[Vec3; 4]) -> [Vec3; 4] {
    let [a, b, left, right] = corners;
    let edge = b - a;
    let along = |p: &Vec3| (p - a).dot(&edge) / edge.norm_squared();
    let over_height = |normal: Vec3| normal * (edge.norm() / normal.norm_squared());
    let (n, m) = normals(corners);
    let (to_left, to_right) = (over_height(n), over_height(m));
    let (s, t) = (along(left), along(right));
    [to_left * (1.0 - s) + to_right * (1.0 - t), to_left * s + to_right * t, -to_left, -to_right]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles, the right one turned up by `angle` about their edge.
    fn turned(angle: f64) -> [Vec3; 4] {
        [
            Vec3::zeros(),
            Vec3::new(0.0, 2.0, 0.0),
            Vec3::new(-1.0, 0.7, 0.0),
            Vec3::new(1.5 * libm::cos(angle), 0.4, 1.5 * libm::sin(angle)),
        ]
    }

    #[test]
    fn the_turn_is_the_angle_and_its_gradient_its_derivative() {
        for angle in [-2.9, -1.0, 0.3, 1.8, 3.0] {
            let corners = turned(angle);
            assert!((turn(&corners).abs() - angle.abs()).abs() < 1e-12);
            let direction: [Vec3; 4] = std::array::from_fn(|k| {
                Vec3::new(0.3, -0.2, 0.5).map(|c| libm::sin(c * (3 * k + 1) as f64))
            });
            let moved = |h: f64| turn(&std::array::from_fn(|k| corners[k] + direction[k] * h));
            let slope: f64 = gradient(&corners).iter().zip(&direction).map(|(g, d)| g.dot(d)).sum();
            let error = |h: f64| ((moved(h) - moved(-h)) / (2.0 * h) - slope).abs();
            let order = libm::log2(error(2e-3) / error(1e-3));
            assert!((1.9..2.1).contains(&order), "{angle}: {order}");
        }
    }

    #[test]
    fn only_edges_that_turn_over_are_held_back() {
        let triangles = [[0, 1, 2], [1, 0, 3]];
        let folds = Folds::new(&turned(0.2), &triangles, 1e-3);
        assert!(folds.excesses(&turned(1.5)).is_empty());
        let over = turned(2.6);
        let fold = &folds.excesses(&over)[0];
        assert!((fold.residual - (2.6 - ALLOWED) / SIGMA).abs() < 1e-12);
        // A crease of the template may stay one.
        assert!(Folds::new(&over, &triangles, 1e-3).excesses(&turned(2.59)).is_empty());
    }
}
