//! What the data leave open: samples of the strain's posterior, linearized about the best one.
//!
//! In white numbers z a change of the strain is ds = h z with h h^T the prior's covariance, and the rows
//! see H^T z, H^T = Z h. The data, with white noise v of their own, turn a sample of the prior into one of
//! the posterior (Matheron's rule):
//!
//!   (I + H^T H) a = H^T z + v,   z := z - H a.
//!
//! Among z are the strain's mean and the rigid motion of a free body. Those that the solver leaves free
//! have a prior deviation of 1 here: a strain, a length of the body or an angle of that size.

use std::ops::Range;

use faer::Mat;
use nalgebra::Vector6;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::linearization::Linearization;
use super::rows::Rows;
use crate::error::Result;
use crate::fem::{HalfInverse, Sensitivity, StrainMean, StrainSmoothness, rigid_modes};
use crate::material::IsotropicDensity;
use crate::math::{Sym3, Vec3};
use crate::solve::{ColumnBlocks, DenseCholesky};

/// Start of the random numbers of all samples; each has its own sequence of them.
const SEED: u128 = 2021;

/// The posterior of one linearization.
pub struct Posterior<'a, M> {
    at: &'a Linearization<'a, M>,
    /// h, but for the mean and the rigid motion.
    prior: HalfInverse<'a, f32>,
    /// G.
    sensitivity: Sensitivity<f32>,
    /// H; its last rows belong to the mean and the rigid motion.
    half: ColumnBlocks<'a, f32>,
    /// Prior deviation of the strain's mean.
    mean_sigma: Sym3,
    /// I + H^T H.
    capacity: DenseCholesky,
}

impl<'a, M: IsotropicDensity> Posterior<'a, M> {
    /// Given the rows.
    pub fn new(
        at: &'a Linearization<'a, M>,
        rows: &Rows,
        smoothness: &'a StrainSmoothness,
    ) -> Result<Self> {
        let (mut half, constants) = at.half_inverse(&at.single, rows, smoothness);
        let mean_sigma = smoothness.mean().map_or(Sym3::repeat(1.0), StrainMean::sigma);
        for (p, sigma) in mean_sigma.iter().enumerate() {
            half.push_row(constants.iter().map(|z| z[p] * sigma));
        }
        if at.body.is_free() {
            for mode in at.rigid_columns(rows) {
                half.push_row(mode.into_iter());
            }
        }
        // As if beyond all rounding: nothing corrects afterwards what the products miss.
        let mut capacity = half.gram_lower(f64::INFINITY);
        for i in 0..capacity.nrows() {
            capacity[(i, i)] += 1.0;
        }
        let (capacity, sensitivity) = (DenseCholesky::new(capacity)?, at.sensitivity.rounded());
        let prior = smoothness.half_inverse();
        Ok(Self { at, prior, sensitivity, half, mean_sigma, capacity })
    }

    /// Displacements of the body's vertices, a field for each sample; the same for the same number.
    pub fn samples(&self, numbers: Range<usize>) -> Vec<Vec<Vec3>> {
        let width = numbers.len();
        let (mut z, noise) = self.white(numbers);
        let mut a = self.half.transpose_multiply(&z, width) + noise;
        self.capacity.solve(a.as_mut());
        self.half.subtract_product(a.as_ref(), &mut z);

        let (strain, wide) = z.split_at_mut(6 * self.at.sensitivity.carriers() * width);
        self.prior.transpose_apply(strain, width);
        let (mean, rigid) = wide.split_at(6 * width);
        for carrier in strain.chunks_exact_mut(6 * width) {
            for (k, value) in carrier.iter_mut().enumerate() {
                *value += self.mean_sigma[k / width] as f32 * mean[k];
            }
        }
        // J ds = -K^-1 G ds
        let mut x = self.sensitivity.multiply_rows(strain, width);
        self.at.single.solve_rows(&mut x, width);
        let number = |list: &[f32], row: usize, c: usize| -> f64 {
            list.get(row * width + c).copied().unwrap_or_default().into()
        };
        let field = |c: usize| {
            let rigid = Vector6::from_fn(|k, _| number(rigid, k, c));
            let displacement = |(v, place): (usize, &Vec3)| {
                let modes = rigid_modes(place, &self.at.center);
                let moved: Vec3 = modes.iter().zip(&rigid).map(|(mode, xi)| mode * *xi).sum();
                moved - Vec3::from_fn(|axis, _| number(&x, 3 * v + axis, c))
            };
            self.at.x.iter().enumerate().map(displacement).collect()
        };
        (0..width).map(field).collect()
    }

    /// Independent numbers of variance 1: z, row-major, and v.
    fn white(&self, numbers: Range<usize>) -> (Vec<f32>, Mat<f64>) {
        let (rows, columns, width) = (self.half.rows(), self.half.columns(), numbers.len());
        let (mut z, mut v) = (vec![0.0; rows * width], Mat::zeros(columns, width));
        for (c, number) in numbers.enumerate() {
            let mut random = Pcg64::new(SEED, number as u128);
            for row in 0..rows {
                z[row * width + c] = StandardNormal.sample(&mut random);
            }
            for row in 0..columns {
                v[(row, c)] = StandardNormal.sample(&mut random);
            }
        }
        (z, v)
    }
}
