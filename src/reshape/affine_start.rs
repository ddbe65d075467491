//! The start of a free body: one constant strain and a rigid motion, fitted to all data.
//!
//! Without external forces a constant plastic strain is an equilibrium of its own,
//! x = R exp(S) X + t, so that this stage needs no statics: Gauss-Newton over twelve numbers. [W] solves the
//! attachments alone first, which lets free strains collapse; docs/papers.md says why we do not.

use nalgebra::{DMatrix, DVector, Rotation3, SVector};

use crate::fem::rigid_modes;
use crate::math::symmetric3::{MULTIPLICITY, exp, exp_with_derivatives};
use crate::math::{Mat3, Sym3, Vec3};

use super::correspondences::Correspondences;
use super::formulation::MEAN_SIGMA;
use super::rows::Rows;
use super::scene::Scene;
use super::term::Weighting;

/// Iterations; correspondences settle well before.
const ITERATIONS: usize = 100;

/// The fit ends when no vertex would move farther than this.
const SETTLED: f64 = 1e-5;

/// A homogeneous deformation.
pub struct AffineStart {
    /// Vertex positions.
    pub x: Vec<Vec3>,
    /// Logarithm of the constant stretch.
    pub strain: Sym3,
}

/// Fits strain and rigid motion.
pub fn affine_start(scene: &Scene) -> AffineStart {
    let rest = &scene.body.mesh.points;
    let (mut rotation, mut translation, mut s) = (Mat3::identity(), Vec3::zeros(), Sym3::zeros());
    let place = |rotation: &Mat3, translation: &Vec3, s: &Sym3| -> Vec<Vec3> {
        let f = rotation * exp(s);
        rest.iter().map(|p| f * p + translation).collect()
    };
    for _ in 0..ITERATIONS {
        let x = place(&rotation, &translation, &s);
        let correspondences = scene.data.correspondences(&x);
        let data = scene.data.evaluate(&x, &correspondences, spread(scene, &correspondences)).rows;
        let step = step(&data, &x, rest, &rotation, &s);
        s += step.fixed_rows::<6>(0);
        let turn = Rotation3::new(step.fixed_rows::<3>(9).into_owned()).into_inner();
        rotation = turn * rotation;
        translation = turn * translation + step.fixed_rows::<3>(6);
        if step.norm() < SETTLED {
            break;
        }
    }
    AffineStart { x: place(&rotation, &translation, &s), strain: s }
}

/// For a fit that cannot be exact: the markers count by the spread of their distances.
fn spread(scene: &Scene, correspondences: &Correspondences) -> Weighting {
    let distances = correspondences.distances();
    let variance = scene.data.markers.sigma.powi(2);
    let mean_square = distances.iter().map(|d| d * d).sum::<f64>() / distances.len().max(1) as f64;
    Weighting { scale: variance / mean_square.max(variance), robust: true }
}

/// One Gauss-Newton step: six strains, translation, rotation vector about the origin.
fn step(data: &Rows, x: &[Vec3], rest: &[Vec3], rotation: &Mat3, s: &Sym3) -> SVector<f64, 12> {
    let (_, derivatives) = exp_with_derivatives(s);
    let mut jacobian = DMatrix::zeros(data.rows.len() + 6, 12);
    let mut residual = DVector::zeros(data.rows.len() + 6);
    for (i, row) in data.rows.iter().enumerate() {
        let c = row.weight.sqrt();
        for &(v, gradient) in data.gradient(row) {
            let (at_rest, at) = (rest[v as usize], x[v as usize]);
            for (p, derivative) in derivatives.iter().enumerate() {
                jacobian[(i, p)] += c * gradient.dot(&(rotation * (derivative * at_rest)));
            }
            for (k, mode) in rigid_modes(&at, &Vec3::zeros()).iter().enumerate() {
                jacobian[(i, 6 + k)] += c * gradient.dot(mode);
            }
        }
        residual[i] = c * row.residual;
    }
    for p in 0..6 {
        let i = data.rows.len() + p;
        let c = MULTIPLICITY[p].sqrt() / MEAN_SIGMA;
        jacobian[(i, p)] = c;
        residual[i] = c * s[p];
    }
    let normal = jacobian.transpose() * &jacobian;
    let damping = DMatrix::identity(12, 12) * (1e-9 * normal.trace());
    let right = jacobian.transpose() * residual;
    let solution =
        (normal + damping).cholesky().map_or_else(|| DVector::zeros(12), |c| c.solve(&right));
    let step = SVector::<f64, 12>::from_column_slice((-solution).as_slice());
    step * (0.5 / step.norm()).min(1.0)
}
