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

    /// Sum of all tet volumes.
    pub fn total_volume(&self) -> f64 {
        (0..self.tets.len()).map(|t| self.volume(t)).sum()
    }
}

/// Signed volume of a tet from its corners.
pub fn signed_volume([a, b, c, d]: [Vec3; 4]) -> f64 {
    (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
}
