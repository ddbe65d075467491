//! A tet mesh: points and index quadruples.

use super::tri_mesh::check_points;
use crate::error::{Error, Result};
use crate::math::Vec3;

/// A tetrahedral mesh. All its indices are in range and all its points finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TetMesh {
    /// Vertex positions.
    pub points: Vec<Vec3>,
    /// Vertex indices of each tet; (b-a) x (c-a) . (d-a) > 0.
    pub tets: Vec<[u32; 4]>,
}

impl TetMesh {
    /// Checks that indices are in range and points finite; tets of negative volume are turned
    /// around, tets without volume are an error.
    pub fn new(points: Vec<Vec3>, mut tets: Vec<[u32; 4]>) -> Result<Self> {
        check_points(&points)?;
        for (t, tet) in tets.iter_mut().enumerate() {
            if let Some(&v) = tet.iter().find(|&&v| v as usize >= points.len()) {
                return Err(Error::invalid(format!(
                    "tet {t} refers to vertex {v}, but there are only {} vertices (numbered from 0)",
                    points.len()
                )));
            }
            let volume = signed_volume(tet.map(|v| points[v as usize]));
            if volume == 0.0 {
                return Err(Error::invalid(format!(
                    "tet {t} has no volume; remove it or mesh again"
                )));
            }
            if volume < 0.0 {
                tet.swap(2, 3);
            }
        }
        Ok(Self { points, tets })
    }

    /// Corner positions of tet `t`.
    pub fn corners(&self, t: usize) -> [Vec3; 4] {
        self.tets[t].map(|v| self.points[v as usize])
    }

    /// Volume of tet `t`, positive as long as it is not inverted.
    pub fn volume(&self, t: usize) -> f64 {
        signed_volume(self.corners(t))
    }

    /// Pairs of tets that share a face, each pair once, lower number first.
    pub fn face_neighbours(&self) -> Vec<(u32, u32)> {
        let mut faces: Vec<([u32; 3], u32)> = Vec::with_capacity(4 * self.tets.len());
        for (t, tet) in self.tets.iter().enumerate() {
            for corner in 0..4 {
                let mut face = [1, 2, 3].map(|k| tet[(corner + k) % 4]);
                face.sort_unstable();
                faces.push((face, t as u32));
            }
        }
        faces.sort_unstable();
        faces.windows(2).filter(|w| w[0].0 == w[1].0).map(|w| (w[0].1, w[1].1)).collect()
    }

    /// Sum of all tet volumes.
    pub fn total_volume(&self) -> f64 {
        (0..self.tets.len()).map(|t| self.volume(t)).sum()
    }
}

/// The faces of a tet, face k opposite to corner k, counter-clockwise seen from outside.
pub fn tet_faces(&[a, b, c, d]: &[u32; 4]) -> [[u32; 3]; 4] {
    [[b, c, d], [a, d, c], [a, b, d], [a, c, b]]
}

/// Signed volume of a tet from its corners.
pub fn signed_volume([a, b, c, d]: [Vec3; 4]) -> f64 {
    (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
}
