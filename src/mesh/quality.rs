//! How good the tets of a mesh are.

use std::fmt;

use super::TetMesh;
use super::tet_mesh::signed_volume;
use crate::math::Vec3;

/// Bins of [`TetQuality::dihedral_histogram`]: 10 degrees each.
const BINS: usize = 18;

/// A summary of tet shapes. Lengths and volumes in the mesh's own unit, angles in degrees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TetQuality {
    /// Number of tets.
    pub tets: usize,
    /// Number of vertices.
    pub vertices: usize,
    /// Sum of the signed volumes.
    pub volume: f64,
    /// Tets of no or negative volume.
    pub inverted: usize,
    /// Smallest dihedral angle; a regular tet has 70.5 throughout.
    pub min_dihedral: f64,
    /// Largest dihedral angle.
    pub max_dihedral: f64,
    /// Number of dihedral angles in each 10 degrees from 0 to 180.
    pub dihedral_histogram: [usize; BINS],
    /// Smallest radius ratio (3 inner / outer sphere): 1 for regular tets, 0 for flat ones.
    pub min_radius_ratio: f64,
    /// Mean radius ratio.
    pub mean_radius_ratio: f64,
    /// Smallest scaled Jacobian: 1 for regular tets, 0 for flat ones, below 0 for inverted ones.
    pub min_scaled_jacobian: f64,
}

impl TetQuality {
    /// Measures a mesh; `points` may be those of a deformed state.
    pub fn of(tets: &[[u32; 4]], points: &[Vec3]) -> Self {
        let mut quality = Self {
            tets: tets.len(),
            vertices: points.len(),
            min_dihedral: 180.0,
            min_radius_ratio: 1.0,
            min_scaled_jacobian: 1.0,
            ..Self::default()
        };
        for tet in tets {
            quality.add(&tet.map(|v| points[v as usize]));
        }
        quality.mean_radius_ratio /= tets.len().max(1) as f64;
        quality
    }

    /// Measures a mesh as it is.
    pub fn of_mesh(mesh: &TetMesh) -> Self {
        Self::of(&mesh.tets, &mesh.points)
    }

    fn add(&mut self, corners: &[Vec3; 4]) {
        let volume = signed_volume(*corners);
        self.volume += volume;
        self.inverted += usize::from(volume <= 0.0);
        for angle in dihedral_angles(corners) {
            self.min_dihedral = self.min_dihedral.min(angle);
            self.max_dihedral = self.max_dihedral.max(angle);
            self.dihedral_histogram[((angle / 10.0) as usize).min(BINS - 1)] += 1;
        }
        let ratio = radius_ratio(corners);
        self.min_radius_ratio = self.min_radius_ratio.min(ratio);
        self.mean_radius_ratio += ratio;
        self.min_scaled_jacobian = self.min_scaled_jacobian.min(scaled_jacobian(corners));
    }
}

impl fmt::Display for TetQuality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} tets, {} vertices, volume {:.6}", self.tets, self.vertices, self.volume)?;
        if self.inverted > 0 {
            writeln!(f, "{} inverted tets", self.inverted)?;
        }
        write!(
            f,
            "dihedral angles {:.1} to {:.1} degrees, radius ratio from {:.3} (mean {:.3}), scaled Jacobian from {:.3}",
            self.min_dihedral,
            self.max_dihedral,
            self.min_radius_ratio,
            self.mean_radius_ratio,
            self.min_scaled_jacobian
        )
    }
}

/// The six dihedral angles in degrees; 0 or 180 in flat tets.
pub fn dihedral_angles(corners: &[Vec3; 4]) -> [f64; 6] {
    // Edge (i, j) and the two other corners.
    let edges =
        [[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 0, 2], [2, 3, 0, 1]];
    edges.map(|[i, j, k, l]| {
        let edge = corners[j] - corners[i];
        let u = edge.cross(&(corners[k] - corners[i]));
        let v = edge.cross(&(corners[l] - corners[i]));
        libm::atan2(u.cross(&v).norm(), u.dot(&v)).to_degrees()
    })
}

/// 3 times the radius of the inner sphere over that of the outer one; 1 for a regular tet.
pub fn radius_ratio([a, b, c, d]: &[Vec3; 4]) -> f64 {
    let (u, v, w) = (b - a, c - a, d - a);
    let six_volumes = u.cross(&v).dot(&w).abs();
    let areas = u.cross(&v).norm()
        + v.cross(&w).norm()
        + w.cross(&u).norm()
        + (v - u).cross(&(w - u)).norm();
    // inner radius = 6V / (2 areas); outer radius = |...| / (2 * 6V)
    let outer = u.norm_squared() * v.cross(&w)
        + v.norm_squared() * w.cross(&u)
        + w.norm_squared() * u.cross(&v);
    let below = areas * outer.norm();
    if below > 0.0 { 6.0 * six_volumes * six_volumes / below } else { 0.0 }
}

/// Least of sqrt 2 times the Jacobian over the product of the three edge lengths at a corner.
pub fn scaled_jacobian(corners: &[Vec3; 4]) -> f64 {
    let jacobian = 6.0 * signed_volume(*corners);
    let longest = (0..4)
        .map(|i| {
            (0..4).filter(|&j| j != i).map(|j| (corners[j] - corners[i]).norm()).product::<f64>()
        })
        .fold(0.0, f64::max);
    if longest > 0.0 { std::f64::consts::SQRT_2 * jacobian / longest } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn regular() -> [Vec3; 4] {
        [[1., 1., 1.], [-1., 1., -1.], [1., -1., -1.], [-1., -1., 1.]].map(Vec3::from)
    }

    #[test]
    fn a_regular_tet_is_perfect() {
        let points = regular().to_vec();
        let mesh = TetMesh::new(points, vec![[0, 1, 2, 3]]).unwrap();
        let quality = TetQuality::of_mesh(&mesh);
        let angle = libm::acos(1.0_f64 / 3.0).to_degrees();
        assert!((quality.min_dihedral - angle).abs() < 1e-12);
        assert!((quality.max_dihedral - angle).abs() < 1e-12);
        assert!((quality.min_radius_ratio - 1.0).abs() < 1e-14);
        assert!((quality.min_scaled_jacobian - 1.0).abs() < 1e-14);
        assert_eq!((quality.dihedral_histogram[7], quality.inverted), (6, 0));
    }

    #[test]
    fn a_corner_of_a_cube_has_known_values_and_turning_it_around_is_noticed() {
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let mut angles = dihedral_angles(&corners);
        angles.sort_by(f64::total_cmp);
        assert!((angles[5] - 90.0).abs() < 1e-12);
        assert!((angles[0] - libm::acos(3.0_f64.sqrt().recip()).to_degrees()).abs() < 1e-12);
        // inner radius (3 - sqrt 3) / 6, outer sqrt 3 / 2
        assert!((radius_ratio(&corners) - (3.0_f64.sqrt() - 1.0)).abs() < 1e-14);
        let turned = TetQuality::of(&[[0, 1, 3, 2]], &corners);
        assert_eq!(turned.inverted, 1);
        assert!(turned.min_scaled_jacobian < 0.0);
    }
}
