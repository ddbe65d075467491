//! Dense symmetric systems: Gram matrices and their Cholesky factor.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{
    LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

use super::memory::Memory;
use super::real::Real;
use crate::error::{Error, Result};

/// Rows multiplied in one call; keeps both panels in the cache.
const PANEL: usize = 512;

/// A dense matrix in blocks of columns, so that each block can be computed on its own thread.
pub struct ColumnBlocks<'m, T> {
    /// Row-major blocks of [`Self::WIDTH`] columns; the last may be narrower.
    pub blocks: Vec<Vec<T>>,
    rows: usize,
    columns: usize,
    memory: &'m Memory<T>,
}

impl<'m, T: Real> ColumnBlocks<'m, T> {
    /// Columns of a block.
    pub const WIDTH: usize = 64;

    /// A matrix whose entries are not set yet.
    pub fn new(rows: usize, columns: usize, memory: &'m Memory<T>) -> Self {
        let block = |first| {
            let size = rows * Self::WIDTH.min(columns - first);
            let mut block = memory.take(size);
            block.resize(size, T::from_f64(0.0));
            block
        };
        let blocks = (0..columns).step_by(Self::WIDTH).map(block).collect();
        Self { blocks, rows, columns, memory }
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Sum of the squares of all entries, the trace of A^T A.
    pub fn squared_norm(&self) -> f64 {
        let square = |value: &T| value.to_f64() * value.to_f64();
        let sums: Vec<f64> =
            self.blocks.par_iter().map(|block| block.iter().map(square).sum()).collect();
        sums.iter().sum()
    }

    /// gram += A^T A in its lower triangle. Parallel over blocks of the result, each summed in row
    /// order: panels in the precision P, their sums in double precision.
    pub fn add_gram_lower<P: Real>(&self, gram: &mut Mat<f64>) {
        let pairs: Vec<(usize, usize)> =
            (0..self.blocks.len()).flat_map(|i| (0..=i).map(move |j| (i, j))).collect();
        let products: Vec<Mat<f64>> =
            pairs.par_iter().map(|&(i, j)| self.block_product::<P>(i, j)).collect();
        for (&(i, j), block) in pairs.iter().zip(&products) {
            let (i, j) = (i * Self::WIDTH, j * Self::WIDTH);
            let mut part = gram.as_mut().submatrix_mut(i, j, block.nrows(), block.ncols());
            part += block;
        }
    }

    /// A_i^T A_j for two blocks.
    fn block_product<P: Real>(&self, i: usize, j: usize) -> Mat<f64> {
        let width = |k: usize| Self::WIDTH.min(self.columns - k * Self::WIDTH);
        let mut product = Mat::<f64>::zeros(width(i), width(j));
        let mut part = Mat::<P>::zeros(width(i), width(j));
        let (mut left, mut right) = (Vec::new(), Vec::new());
        for start in (0..self.rows).step_by(PANEL) {
            let height = PANEL.min(self.rows - start);
            for (k, panel) in [(i, &mut left), (j, &mut right)] {
                let rows = &self.blocks[k][start * width(k)..][..height * width(k)];
                panel.clear();
                panel.extend(rows.iter().map(|value| P::from_f64(value.to_f64())));
            }
            let left = MatRef::from_row_major_slice(&left, height, width(i)).transpose();
            let right = MatRef::from_row_major_slice(&right, height, width(j));
            matmul(part.as_mut(), Accum::Replace, left, right, P::from_f64(1.0), Par::Seq);
            for c in 0..width(j) {
                for r in 0..width(i) {
                    product[(r, c)] += part[(r, c)].to_f64();
                }
            }
        }
        product
    }
}

impl<T> Drop for ColumnBlocks<'_, T> {
    fn drop(&mut self) {
        for block in self.blocks.drain(..) {
            self.memory.give(block);
        }
    }
}

/// Cholesky factor of a dense symmetric positive definite matrix.
pub struct DenseCholesky(Mat<f64>);

impl DenseCholesky {
    /// Factors a matrix, of which the lower triangle is read; fails when it is not positive
    /// definite.
    pub fn new(mut matrix: Mat<f64>) -> Result<Self> {
        let params = faer::Spec::default();
        let mut memory =
            MemBuffer::new(cholesky_in_place_scratch::<f64>(matrix.nrows(), Par::Seq, params));
        cholesky_in_place(
            matrix.as_mut(),
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            params,
        )
        .map_err(|_| Error::Singular("the dense system is not positive definite".into()))?;
        Ok(Self(matrix))
    }

    /// Solves in place for the right-hand sides that are the columns of `b`.
    pub fn solve(&self, mut b: MatMut<'_, f64>) {
        solve_lower_triangular_in_place(self.0.as_ref(), b.as_mut(), Par::Seq);
        solve_upper_triangular_in_place(self.0.transpose(), b, Par::Seq);
    }
}
