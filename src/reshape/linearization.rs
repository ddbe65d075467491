//! The shape as a linear function of the plastic strain, at one equilibrium.
//!
//! Z = sqrt(c) A J, K J = -G ([W] Eqs. 8-11): neither J nor Z is formed.

use faer::Mat;
use nalgebra::Vector6;
use rayon::prelude::*;

use super::rows::Rows;
use crate::fem::{Body, Sensitivity, StrainSmoothness, rigid_modes, solve_vectors};
use crate::material::IsotropicDensity;
use crate::math::{Sym3, Vec3};
use crate::solve::{ColumnBlocks, Factor, Real, RoundedFactor};

/// Trace of H^T H up to which H may be rounded to single precision: beyond, what a direction misses is
/// no longer found by corrections.
const ROUNDED_SYSTEM_TRACE: f64 = 1e9;

/// What the direction is computed at.
pub struct Linearization<'a, M> {
    /// The body.
    pub body: &'a Body<M>,
    /// Factor of its stiffness at `x`.
    pub stiffness: &'a Factor,
    /// The same in single precision, for what is corrected afterwards.
    pub single: RoundedFactor<f32>,
    /// d(gradient)/ds at `x`.
    pub sensitivity: &'a Sensitivity,
    /// Vertex positions.
    pub x: &'a [Vec3],
    /// Centre of the rigid motions.
    pub center: Vec3,
}

impl<'a, M: IsotropicDensity> Linearization<'a, M> {
    /// At the shape `x` with the factor of its stiffness and its sensitivity.
    pub fn new(
        body: &'a Body<M>,
        stiffness: &'a Factor,
        sensitivity: &'a Sensitivity,
        x: &'a [Vec3],
    ) -> Self {
        let center = x.iter().sum::<Vec3>() / x.len() as f64;
        Self { body, stiffness, single: stiffness.rounded(), sensitivity, x, center }
    }

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

    /// Z R^+ Z^T in its lower triangle, for a sum with the identity, and the sums of Z^T over all
    /// carriers: Z times each constant strain. In single precision where corrections can find what that
    /// misses.
    pub(super) fn prior_gram(
        &self,
        rows: &Rows,
        smoothness: &StrainSmoothness,
    ) -> (Mat<f64>, Vec<Vector6<f64>>) {
        let (half, constants) = self.half_inverse(&self.single, rows, smoothness);
        let trace = half.squared_norm();
        let (mut gram, constants) = if trace <= ROUNDED_SYSTEM_TRACE {
            (half.gram_lower(trace), constants)
        } else {
            drop(half);
            let stiffness = self.stiffness.rounded::<f64>();
            let (half, constants) = self.half_inverse(&stiffness, rows, smoothness);
            (half.gram_lower(trace), constants)
        };
        if let Some(mean) = smoothness.mean() {
            mean.add_to_gram(&mut gram, &constants);
        }
        (gram, constants)
    }

    /// H with H^T H = Z R^+ Z^T, but for the mean's part, in blocks of columns, one column per row of data,
    /// and the sums of
    /// Z^T over all carriers: Z times each constant strain. In the precision of `stiffness`.
    pub(super) fn half_inverse<'m, T: Real>(
        &self,
        stiffness: &'m RoundedFactor<T>,
        rows: &Rows,
        smoothness: &StrainSmoothness,
    ) -> (ColumnBlocks<'m, T>, Vec<Vector6<f64>>) {
        let sensitivity = self.sensitivity.rounded::<T>();
        let smoothness = smoothness.half_inverse::<T>();
        let mut half =
            ColumnBlocks::new(6 * self.sensitivity.carriers(), rows.rows.len(), stiffness.memory());
        let constants: Vec<Vec<Vector6<f64>>> = half
            .blocks
            .par_iter_mut()
            .zip(rows.rows.par_chunks(ColumnBlocks::<T>::WIDTH))
            .map(|(z, part)| {
                let width = part.len();
                let mut y = stiffness.memory().take(3 * self.x.len() * width);
                y.fill(T::from_f64(0.0));
                for (c, row) in part.iter().enumerate() {
                    for &(v, gradient) in rows.gradient(row) {
                        let scaled = gradient * -row.weight.sqrt();
                        for axis in 0..3 {
                            y[(3 * v as usize + axis) * width + c] += T::from_f64(scaled[axis]);
                        }
                    }
                }
                stiffness.solve_rows(&mut y, width);
                sensitivity.transpose_multiply(&y, width, z);
                stiffness.memory().give(y);
                let mut sums = vec![Vector6::zeros(); width];
                for carrier in z.chunks_exact(6 * width) {
                    for (p, row) in carrier.chunks_exact(width).enumerate() {
                        sums.iter_mut().zip(row).for_each(|(sum, z)| sum[p] += z.to_f64());
                    }
                }
                smoothness.apply(z, width);
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
