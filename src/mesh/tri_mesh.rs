//! A triangle mesh: points and index triples.

use super::normals::{area_vectors, vertex_normals};
use crate::error::{Error, Result};
use crate::math::Vec3;

/// A triangle surface. It carries no unit; all its indices are in range and all its points finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertex positions.
    pub points: Vec<Vec3>,
    /// Vertex indices of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// Checks that indices are in range and points finite.
    pub fn new(points: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self> {
        check_points(&points)?;
        for (t, triangle) in triangles.iter().enumerate() {
            if let Some(&v) = triangle.iter().find(|&&v| v as usize >= points.len()) {
                return Err(Error::invalid(format!(
                    "triangle {t} refers to vertex {v}, but there are only {} vertices (numbered from 0)",
                    points.len()
                )));
            }
        }
        Ok(Self { points, triangles })
    }

    /// Puts the points and triangles of another mesh behind its own.
    pub fn append(&mut self, other: &Self) {
        let first = self.points.len() as u32;
        self.points.extend_from_slice(&other.points);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    }

    /// Corner positions of triangle `t`.
    pub fn corners(&self, t: usize) -> [Vec3; 3] {
        self.triangles[t].map(|v| self.points[v as usize])
    }

    /// Length of the bounding box's diagonal; 0 without points.
    pub fn diagonal(&self) -> f64 {
        diagonal(&self.points)
    }

    /// Signed volume enclosed (exact for closed surfaces; positive when normals point outwards).
    pub fn volume(&self) -> f64 {
        let six_volumes: f64 = (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t);
                a.dot(&b.cross(&c))
            })
            .sum();
        six_volumes / 6.0
    }

    /// Sum of the areas of all triangles.
    pub fn area(&self) -> f64 {
        let of_triangle = |t| {
            let [a, b, c] = self.corners(t);
            (b - a).cross(&(c - a)).norm() / 2.0
        };
        (0..self.triangles.len()).map(of_triangle).sum()
    }

    /// The triangles, by number, that `keep` holds, with their points in their order.
    #[must_use]
    pub fn part(&self, keep: impl Fn(usize) -> bool) -> Self {
        let kept = self.triangles.iter().enumerate().filter(|(t, _)| keep(*t));
        let mut triangles: Vec<[u32; 3]> = kept.map(|(_, triangle)| *triangle).collect();
        let mut number = vec![u32::MAX; self.points.len()];
        for &v in triangles.as_flattened() {
            number[v as usize] = 0;
        }
        let mut points = Vec::new();
        for (number, point) in number.iter_mut().zip(&self.points) {
            if *number == 0 {
                *number = points.len() as u32;
                points.push(*point);
            }
        }
        triangles.iter_mut().flatten().for_each(|v| *v = number[*v as usize]);
        Self { points, triangles }
    }

    /// Area-weighted vertex normals, unit length (zero where no face has an area).
    pub fn vertex_normals(&self) -> Vec<Vec3> {
        let areas = area_vectors(&self.points, &self.triangles);
        vertex_normals(self.points.len(), &self.triangles, &areas)
    }
}

/// Lowest and highest corner of the box around `points`.
pub fn bounding_box(points: &[Vec3]) -> Option<(Vec3, Vec3)> {
    let first = *points.first()?;
    Some(points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p))))
}

/// Length of the diagonal of the box around `points`; 0 without points.
pub fn diagonal(points: &[Vec3]) -> f64 {
    bounding_box(points).map_or(0.0, |(low, high)| (high - low).norm())
}

/// Fails on the first point with a coordinate that is not a finite number.
pub(super) fn check_points(points: &[Vec3]) -> Result<()> {
    match points.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        Some(v) => {
            Err(Error::invalid(format!("vertex {v} has a coordinate that is not a finite number")))
        }
        None => Ok(()),
    }
}
