//! Generalized winding number: how often a surface goes around a point.
//!
//! A. Jacobson, L. Kavan, O. Sorkine-Hornung, Robust inside-outside segmentation using generalized
//! winding numbers (2013): 1 inside, 0 outside, in between near holes, so that open and
//! self-intersecting surfaces have an inside as well. Fast form: G. Barill et al., Fast winding
//! numbers for soups and clouds (2018): far parts of the surface act as a dipole, here with the
//! next term of the expansion.

use std::f64::consts::PI;

use super::box_tree::{Bounds, BoxTree, Part};
use crate::math::{Mat3, Vec3};

/// A part of the surface is far when it is this many times its own radius away. The paper's choice;
/// the error stays below 0.05 and is mostly 1e-3, plenty for a decision at 0.5.
const FAR: f64 = 2.0;

/// Exact winding number of a triangle surface around `p`.
pub fn winding_number(points: &[Vec3], triangles: &[[u32; 3]], p: &Vec3) -> f64 {
    triangles.iter().map(|t| solid_angle(t.map(|v| points[v as usize]), p)).sum::<f64>()
        / (4.0 * PI)
}

/// Fast winding numbers of a fixed surface.
#[derive(Clone, Debug)]
pub struct WindingNumber {
    triangles: Vec<[Vec3; 3]>,
    tree: BoxTree,
    dipoles: Vec<Dipole>,
}

/// A part of the surface seen from afar.
#[derive(Clone, Debug)]
struct Dipole {
    /// Area-weighted mean.
    centre: Vec3,
    area: f64,
    /// Integral of the normal.
    normal: Vec3,
    /// Integral of (x - centre) normal^T.
    first_order: Mat3,
    /// Largest distance of a corner to the centre.
    radius: f64,
}

impl WindingNumber {
    /// Builds the tree.
    ///
    /// # Panics
    /// When a triangle refers to a missing point; a [`crate::mesh::TriMesh`] never does.
    pub fn new(points: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let triangles: Vec<[Vec3; 3]> =
            triangles.iter().map(|t| t.map(|v| points[v as usize])).collect();
        let bounds: Vec<Bounds> = triangles.iter().map(|t| Bounds::of(t)).collect();
        let tree = BoxTree::new(&bounds);
        let of_leaf = |items: &[u32]| {
            let parts = items.iter().map(|&t| Dipole::of_triangle(&triangles[t as usize]));
            parts.reduce(|a, b| a.join(&b)).expect("leaves have items")
        };
        let dipoles = tree.fold_up(of_leaf, Dipole::join);
        Self { triangles, tree, dipoles }
    }

    /// Winding number around `p`, to about 1e-2 (at worst 0.05).
    pub fn at(&self, p: &Vec3) -> f64 {
        let mut sum = 0.0;
        // Median splits keep the tree shallower than this for any 32-bit count.
        let mut stack = [0_u32; 64];
        let mut depth = usize::from(!self.dipoles.is_empty());
        while depth > 0 {
            depth -= 1;
            let n = stack[depth];
            let dipole = &self.dipoles[n as usize];
            let far = FAR * dipole.radius;
            if (dipole.centre - p).norm_squared() > far * far {
                sum += dipole.solid_angle(p);
                continue;
            }
            match self.tree.node(n) {
                Part::Inner([left, right]) => {
                    stack[depth] = right;
                    stack[depth + 1] = left;
                    depth += 2;
                }
                Part::Leaf(items) => {
                    sum += items
                        .iter()
                        .map(|&t| solid_angle(self.triangles[t as usize], p))
                        .sum::<f64>();
                }
            }
        }
        sum / (4.0 * PI)
    }

    /// Whether the surface goes around `p`, in either orientation.
    pub fn is_inside(&self, p: &Vec3) -> bool {
        self.at(p).abs() > 0.5
    }
}

impl Dipole {
    fn of_triangle(&[a, b, c]: &[Vec3; 3]) -> Self {
        let centre = (a + b + c) / 3.0;
        let normal = (b - a).cross(&(c - a)) / 2.0;
        let radius = [a, b, c].iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        Self { centre, area: normal.norm(), normal, first_order: Mat3::zeros(), radius }
    }

    fn join(&self, other: &Self) -> Self {
        let area = self.area + other.area;
        let share = if area > 0.0 { self.area / area } else { 0.5 };
        let centre = self.centre * share + other.centre * (1.0 - share);
        let moved = |d: &Self| d.first_order + (d.centre - centre) * d.normal.transpose();
        let reach = |d: &Self| d.radius + (d.centre - centre).norm();
        Self {
            centre,
            area,
            normal: self.normal + other.normal,
            first_order: moved(self) + moved(other),
            radius: reach(self).max(reach(other)),
        }
    }

    /// First two terms of the expansion of the integral of r . n / |r|^3 around the centre.
    fn solid_angle(&self, p: &Vec3) -> f64 {
        let r = self.centre - p;
        let squared = r.norm_squared();
        let cubed = squared * squared.sqrt();
        let along = r.dot(&(self.first_order * r));
        self.normal.dot(&r) / cubed + (self.first_order.trace() - 3.0 * along / squared) / cubed
    }
}

/// Signed solid angle of a triangle seen from `p`: A. van Oosterom, J. Strackee (1983).
fn solid_angle(corners: [Vec3; 3], p: &Vec3) -> f64 {
    let [a, b, c] = corners.map(|x| x - p);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2.0 * libm::atan2(a.dot(&b.cross(&c)), below)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::{Noise, sphere};

    #[test]
    fn is_one_inside_and_zero_outside_a_closed_surface() {
        let (points, triangles) = sphere(9, 12);
        let exact = |p: &Vec3| winding_number(&points, &triangles, p);
        assert!((exact(&Vec3::new(0.1, 0.5, -0.6)) - 1.0).abs() < 1e-14);
        assert!(exact(&Vec3::new(1.1, 0.5, -0.6)).abs() < 1e-14);
        let flipped: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        let flipped = WindingNumber::new(&points, &flipped);
        assert!(flipped.is_inside(&Vec3::zeros()) && !flipped.is_inside(&Vec3::repeat(0.9)));
    }

    #[test]
    fn the_fast_form_agrees_with_the_exact_one_on_open_surfaces_too() {
        let (points, triangles) = sphere(30, 40);
        for keep in [triangles.len(), triangles.len() / 2] {
            let fast = WindingNumber::new(&points, &triangles[..keep]);
            let mut noise = Noise::new(11);
            let queries: Vec<Vec3> = (0..500).map(|_| noise.vector() * 1.5).collect();
            let errors: Vec<f64> = queries
                .iter()
                .map(|p| (fast.at(p) - winding_number(&points, &triangles[..keep], p)).abs())
                .collect();
            assert!(errors.iter().all(|&e| e < 5e-2), "{errors:?}");
            assert!(errors.iter().sum::<f64>() / 500.0 < 5e-3);
        }
        assert!(WindingNumber::new(&[], &[]).at(&Vec3::zeros()).abs() < 1e-300);
    }
}
