//! The shape as a linear function of the plastic strain, at one equilibrium.
//!
//! Z = sqrt(c) A J, K J = -G ([W] Eqs. 8-11): neither J nor Z is formed.

use nalgebra::Vector6;
use rayon::prelude::*;

use super::rows::Rows;
use crate::fem::{Body, Sensitivity, StrainSmoothness, rigid_modes, solve_vectors};
use crate::material::IsotropicDensity;
use crate::math::{Sym3, Vec3};
use crate::solve::{ColumnBlocks, Factor};

/// What the direction is computed at.
pub struct Linearization<'a, M> {
    /// The body.
    pub body: &'a Body<M>,
    /// Factor of its stiffness at `x`.
    pub stiffness: &'a Factor,
    /// d(gradient)/ds at `x`.
    pub sensitivity: &'a Sensitivity,
    /// Vertex positions.
    pub x: &'a [Vec3],
    /// Centre of the rigid motions.
    pub center: Vec3,
}

impl<M: IsotropicDensity> Linearization<'_, M> {
    /// J ds = -K^-1 G ds: how the shape answers a change of strain, to first order.
    pub fn shape_change(&self, ds: &[Sym3]) -> Vec<Vec3> {
        let forces = self.sensitivity.multiply(ds);
        solve_vectors(self.stiffness, &forces).into_iter().map(|x| -x).collect()
    }

    /// Z^T a = -G^T K^-1 A^T sqrt(c) a.
    pub(super) fn transpose_multiply(&self, rows: &Rows, a: &[f64]) -> Vec<Sym3> {
        let y = solve_vectors(self.stiffness, &rows.spread(a, self.x.len()));
        let flat: Vec<f64> = y.iter().flat_map(|v| [-v.x, -v.y, -v.z]).collect();
        let mut z = vec![0.0; 6 * self.sensitivity.carriers()];
        self.sensitivity.transpose_multiply(&flat, 1, &mut z);
        z.chunks_exact(6).map(Sym3::from_column_slice).collect()
    }

    /// H with H^T H = Z R^+ Z^T in blocks of columns, one column per row of data, and the sums of
    /// Z^T over all carriers: Z times each constant strain.
    pub(super) fn half_inverse(
        &self,
        rows: &Rows,
        smoothness: &StrainSmoothness,
    ) -> (ColumnBlocks, Vec<Vector6<f64>>) {
        let mut half = ColumnBlocks::zeros(6 * self.sensitivity.carriers(), rows.rows.len());
        let constants: Vec<Vec<Vector6<f64>>> = half
            .blocks
            .par_iter_mut()
            .zip(rows.rows.par_chunks(ColumnBlocks::WIDTH))
            .map_init(Vec::new, |y: &mut Vec<f64>, (z, part)| {
                let width = part.len();
                y.clear();
                y.resize(3 * self.x.len() * width, 0.0);
                for (c, row) in part.iter().enumerate() {
                    let scaled = row.direction * -row.weight.sqrt();
                    for &(v, w) in &rows.points[row.point].0 {
                        for axis in 0..3 {
                            y[(3 * v as usize + axis) * width + c] += scaled[axis] * w;
                        }
                    }
                }
                self.stiffness.solve_rows(y, width);
                self.sensitivity.transpose_multiply(y, width, z);
                let mut sums = vec![Vector6::zeros(); width];
                for carrier in z.chunks_exact(6 * width) {
                    for (p, row) in carrier.chunks_exact(width).enumerate() {
                        sums.iter_mut().zip(row).for_each(|(sum, z)| sum[p] += z);
                    }
                }
                smoothness.half_inverse(z, width);
                sums
            })
            .collect();
        (half, constants.into_iter().flatten().collect())
    }

    /// The rigid modes of the shape, measured by `rows`.
    pub(super) fn rigid_columns(&self, rows: &Rows) -> Vec<Vec<f64>> {
        let modes: Vec<[Vec3; 6]> = self.x.iter().map(|x| rigid_modes(x, &self.center)).collect();
        (0..6).map(|k| rows.measure(&modes.iter().map(|m| m[k]).collect::<Vec<_>>())).collect()
    }
}
