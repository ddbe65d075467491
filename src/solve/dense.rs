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

use crate::error::{Error, Result};

/// Columns of the Gram matrix computed together.
const BLOCK: usize = 128;

/// Rows of the factor multiplied in one call; keeps both panels in the cache.
const PANEL: usize = 512;

/// gram += Y^T Y in its lower triangle, for a row-major Y of `columns` columns. Parallel over
/// blocks of the result, each summed in row order.
pub fn gram_lower(y: &[f64], columns: usize, gram: &mut Mat<f64>) {
    let rows = y.len() / columns.max(1);
    let y = MatRef::from_row_major_slice(y, rows, columns);
    let blocks = columns.div_ceil(BLOCK);
    let pairs: Vec<(usize, usize)> =
        (0..blocks).flat_map(|i| (0..=i).map(move |j| (i, j))).collect();
    let products: Vec<Mat<f64>> = pairs
        .par_iter()
        .map(|&(i, j)| {
            let (ri, rj) = (i * BLOCK, j * BLOCK);
            let (ni, nj) = (BLOCK.min(columns - ri), BLOCK.min(columns - rj));
            let mut block = Mat::zeros(ni, nj);
            for start in (0..rows).step_by(PANEL) {
                let height = PANEL.min(rows - start);
                let left = y.submatrix(start, ri, height, ni).transpose();
                let right = y.submatrix(start, rj, height, nj);
                matmul(block.as_mut(), Accum::Add, left, right, 1.0, Par::Seq);
            }
            block
        })
        .collect();
    for (&(i, j), block) in pairs.iter().zip(&products) {
        let mut part =
            gram.as_mut().submatrix_mut(i * BLOCK, j * BLOCK, block.nrows(), block.ncols());
        part += block;
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
