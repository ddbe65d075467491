//! Closest points on a triangle surface.

use rayon::prelude::*;

use super::box_tree::{Bounds, BoxTree};
use super::triangle::{at, closest_on_triangle};
use crate::math::Vec3;

/// A point on a triangle surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The triangle it lies in.
    pub triangle: u32,
    /// Weights of the triangle's corners: none negative, sum 1.
    pub barycentric: [f64; 3],
    /// Where it is.
    pub position: Vec3,
    /// Distance to the point asked for.
    pub distance: f64,
}

/// Answers closest-point questions on a surface; after the points have moved, [`Self::refit`] is
/// some ten times faster than building it again.
#[derive(Clone, Debug)]
pub struct ClosestPoints {
    triangles: Vec<[u32; 3]>,
    /// Corners of all triangles in the order of the tree's items.
    corners: Vec<[Vec3; 3]>,
    /// Where each triangle stands in that order.
    places: Vec<u32>,
    tree: BoxTree,
}

impl ClosestPoints {
    /// Builds the search tree.
    ///
    /// # Panics
    /// When a triangle refers to a missing point; a [`crate::mesh::TriMesh`] never does.
    pub fn new(points: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let bounds: Vec<Bounds> =
            triangles.iter().map(|t| Bounds::of(&t.map(|v| points[v as usize]))).collect();
        let tree = BoxTree::new(&bounds);
        let mut places = vec![0; triangles.len()];
        for (place, &t) in tree.items().iter().enumerate() {
            places[t as usize] = place as u32;
        }
        let corners = tree
            .items()
            .iter()
            .map(|&t| triangles[t as usize].map(|v| points[v as usize]))
            .collect();
        Self { triangles: triangles.to_vec(), corners, places, tree }
    }

    /// Takes moved points of the same surface.
    ///
    /// # Panics
    /// When there are fewer points than before.
    pub fn refit(&mut self, points: &[Vec3]) {
        let Self { triangles, corners, places, tree } = self;
        let of = |&t: &u32| {
            let [a, b, c] = triangles[t as usize];
            [points[a as usize], points[b as usize], points[c as usize]]
        };
        corners.par_iter_mut().zip(tree.items()).with_min_len(512).for_each(|(c, t)| *c = of(t));
        tree.refit(|t| Bounds::of(&corners[places[t as usize] as usize]));
    }

    /// The surface point closest to `p`; of several equally close ones that of the lowest triangle
    /// index. None without triangles or for a `p` that is not finite.
    pub fn closest(&self, p: &Vec3) -> Option<SurfacePoint> {
        self.closest_below(p, f64::INFINITY)
    }

    /// [`Self::closest`], faster where triangle `hint` is near: the answer is the same.
    pub fn closest_from(&self, p: &Vec3, hint: u32) -> Option<SurfacePoint> {
        if hint as usize >= self.triangles.len() {
            return self.closest(p);
        }
        let corners = self.corners(hint);
        self.closest_below(p, (at(&closest_on_triangle(p, corners), corners) - p).norm_squared())
    }

    /// Like [`Self::closest`], but only up to a distance.
    pub fn closest_within(&self, p: &Vec3, distance: f64) -> Option<SurfacePoint> {
        self.closest_below(p, distance * distance)
    }

    /// Like [`Self::closest`], of the triangles whose outward side faces against `direction`. None if
    /// no triangle does.
    pub fn closest_against(&self, p: &Vec3, direction: &Vec3, cosine: f64) -> Option<SurfacePoint> {
        let faces = |[a, b, c]: &[Vec3; 3]| {
            let area = (b - a).cross(&(c - a));
            area.dot(direction) < -cosine * area.norm()
        };
        self.closest_of(p, f64::INFINITY, faces).filter(|found| found.distance.is_finite())
    }

    /// [`Self::closest`] for many points, in parallel, in their order.
    pub fn closest_many(&self, points: &[Vec3]) -> Vec<Option<SurfacePoint>> {
        points.par_iter().with_min_len(64).map(|p| self.closest(p)).collect()
    }

    fn closest_below(&self, p: &Vec3, limit_squared: f64) -> Option<SurfacePoint> {
        self.closest_of(p, limit_squared, |_| true)
    }

    /// The closest point of the triangles that `counts` lets through; at an infinite distance if
    /// there is none.
    fn closest_of(
        &self,
        p: &Vec3,
        limit_squared: f64,
        counts: impl Fn(&[Vec3; 3]) -> bool,
    ) -> Option<SurfacePoint> {
        if !p.iter().all(|c| c.is_finite()) {
            return None;
        }
        let (triangle, distance_squared, (barycentric, position)) =
            self.tree.nearest(p, limit_squared, |_, place| {
                let corners = &self.corners[place];
                let barycentric = closest_on_triangle(p, corners);
                let position = at(&barycentric, corners);
                let distance_squared =
                    if counts(corners) { (position - p).norm_squared() } else { f64::INFINITY };
                (distance_squared, (barycentric, position))
            })?;
        Some(SurfacePoint { triangle, barycentric, position, distance: distance_squared.sqrt() })
    }

    fn corners(&self, t: u32) -> &[Vec3; 3] {
        &self.corners[self.places[t as usize] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::{Noise, sphere};

    fn brute_force(points: &[Vec3], triangles: &[[u32; 3]], p: &Vec3) -> (u32, f64) {
        let mut best = (0, f64::INFINITY);
        for (t, triangle) in triangles.iter().enumerate() {
            let corners = triangle.map(|v| points[v as usize]);
            let d = (at(&closest_on_triangle(p, &corners), &corners) - p).norm_squared();
            if d < best.1 {
                best = (t as u32, d);
            }
        }
        (best.0, best.1.sqrt())
    }

    #[test]
    fn agrees_with_brute_force_before_and_after_the_points_moved() {
        let (mut points, triangles) = sphere(12, 17);
        let mut noise = Noise::new(3);
        let queries: Vec<Vec3> = (0..300).map(|_| noise.vector() * 1.7).collect();
        let mut closest = ClosestPoints::new(&points, &triangles);
        for _ in 0..2 {
            for (k, (q, found)) in queries.iter().zip(closest.closest_many(&queries)).enumerate() {
                let found = found.unwrap();
                assert_eq!(closest.closest_from(q, 3 * k as u32), Some(found));
                assert_eq!((found.triangle, found.distance), brute_force(&points, &triangles, q));
            }
            for p in &mut points {
                *p = Vec3::new(p.x * 2.0 + p.z * p.z, p.y, p.z * 0.3);
            }
            closest.refit(&points);
        }
    }

    #[test]
    fn the_escape_is_to_the_side_that_faces_the_other_surface() {
        let (points, triangles) = sphere(16, 24);
        let closest = ClosestPoints::new(&points, &triangles);
        let p = Vec3::new(0.0, 0.0, 0.4);
        assert!(closest.closest(&p).unwrap().position.z > 0.9);
        let out = closest.closest_against(&p, &Vec3::z(), 0.0).unwrap();
        assert!(out.position.z < 0.05, "{}", out.position);
        assert!(closest.closest_against(&p, &Vec3::zeros(), 0.0).is_none());
    }

    #[test]
    fn ties_go_to_the_lowest_triangle_and_limits_hold() {
        let (points, triangles) = sphere(8, 8);
        let closest = ClosestPoints::new(&points, &triangles);
        for (v, p) in points.iter().enumerate() {
            let first = triangles.iter().position(|t| t.contains(&(v as u32))).unwrap();
            assert_eq!(closest.closest(&(p * 1.5)).unwrap().triangle, first as u32);
        }
        let p = Vec3::new(0.0, 0.0, 1.5);
        assert!(closest.closest_within(&p, 0.4).is_none());
        assert!(closest.closest_within(&p, 0.5 + 1e-9).is_some());
        assert!(closest.closest(&Vec3::repeat(f64::NAN)).is_none());
        assert!(ClosestPoints::new(&[], &[]).closest(&p).is_none());
    }
}
