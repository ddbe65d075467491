//! Dense symmetric systems: Gram matrices and their Cholesky factor.

use std::ops::Range;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{
    LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, Mat, MatMut, MatRef, Par, unzip, zip};
use rayon::prelude::*;

use super::memory::Memory;
use super::real::Real;
use crate::error::{Error, Result};

/// Rows multiplied in one call; keeps both panels in the cache.
const PANEL: usize = 512;

/// Blocks on the right that are multiplied with one block on the left.
const GROUP: usize = 4;

/// Trace of A^T A up to which its products may be rounded to single precision: beyond, their rounding
/// outweighs the identity that is added.
const ROUNDED_PRODUCTS_TRACE: f64 = 3e7;

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
        let block = |first| memory.take(rows * Self::WIDTH.min(columns - first));
        let blocks = (0..columns).step_by(Self::WIDTH).map(block).collect();
        Self { blocks, rows, columns, memory }
    }

    /// Adds a row below.
    pub fn push_row(&mut self, row: impl Iterator<Item = f64>) {
        let mut row = row.map(T::from_f64);
        let columns = self.columns;
        for (j, block) in self.blocks.iter_mut().enumerate() {
            block.extend(row.by_ref().take(Self::WIDTH.min(columns - j * Self::WIDTH)));
        }
        self.rows += 1;
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
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

    /// A^T A in its lower triangle, for a sum with the identity: products are rounded to T up to a
    /// trace where that adds less than the identity does.
    pub fn gram_lower(&self, trace: f64) -> Mat<f64> {
        if trace > ROUNDED_PRODUCTS_TRACE {
            self.products(|sum, left, right| {
                let (left, right) = (doubled_transpose(left), doubled_transpose(right));
                matmul(sum.as_mut(), Accum::Add, &left, right.transpose(), 1.0, Par::Seq);
            })
        } else {
            self.products(|sum, left, right| {
                let mut product = Mat::<T>::zeros(sum.nrows(), sum.ncols());
                let one = T::from_f64(1.0);
                matmul(product.as_mut(), Accum::Replace, left.transpose(), right, one, Par::Seq);
                zip!(sum, &product).for_each(|unzip!(sum, product)| *sum += product.to_f64());
            })
        }
    }

    /// A^T A in its lower triangle by `add`, which adds the product of two panels, in row order.
    /// Parallel over groups of blocks of one row of the result: a panel on the left stays in the
    /// cache for its group.
    fn products(&self, add: impl Fn(&mut Mat<f64>, MatRef<T>, MatRef<T>) + Sync) -> Mat<f64> {
        let group = |i: usize| {
            (0..=i).step_by(GROUP).map(move |first| (i, first..(first + GROUP).min(i + 1)))
        };
        let groups: Vec<(usize, Range<usize>)> = (0..self.blocks.len()).flat_map(group).collect();
        let products = |(i, columns): &(usize, Range<usize>)| {
            let mut sums: Vec<Mat<f64>> =
                columns.clone().map(|j| Mat::zeros(self.width(*i), self.width(j))).collect();
            for panel in 0..self.rows.div_ceil(PANEL) {
                let left = self.panel(*i, panel);
                for (sum, j) in sums.iter_mut().zip(columns.clone()) {
                    add(sum, left, self.panel(j, panel));
                }
            }
            sums
        };
        let products: Vec<Vec<Mat<f64>>> = groups.par_iter().map(products).collect();
        let mut gram = Mat::zeros(self.columns, self.columns);
        for ((i, columns), sums) in groups.iter().zip(&products) {
            for (j, sum) in columns.clone().zip(sums) {
                let (first, height) = (j * Self::WIDTH, sum.ncols());
                let mut part =
                    gram.as_mut().submatrix_mut(i * Self::WIDTH, first, sum.nrows(), height);
                part += sum;
            }
        }
        gram
    }

    /// out := out - A b for a row-major block of `b.ncols()` columns.
    pub fn subtract_product(&self, b: MatRef<f64>, out: &mut [T]) {
        let minus_one = T::from_f64(-1.0);
        for (j, block) in self.blocks.iter().enumerate() {
            let width = self.width(j);
            let rounded =
                Mat::from_fn(width, b.ncols(), |i, c| T::from_f64(b[(j * Self::WIDTH + i, c)]));
            let block = MatRef::from_row_major_slice(block, self.rows, width);
            let out = MatMut::from_row_major_slice_mut(&mut *out, self.rows, b.ncols());
            matmul(out, Accum::Add, block, rounded, minus_one, Par::Seq);
        }
    }

    /// A^T b for a row-major block of `width` columns.
    pub fn transpose_multiply(&self, b: &[T], width: usize) -> Mat<f64> {
        let b = MatRef::from_row_major_slice(b, self.rows, width);
        let mut product = Mat::zeros(self.columns, width);
        for (j, block) in self.blocks.iter().enumerate() {
            let block = MatRef::from_row_major_slice(block, self.rows, self.width(j));
            let mut part = Mat::<T>::zeros(block.ncols(), width);
            let one = T::from_f64(1.0);
            matmul(part.as_mut(), Accum::Replace, block.transpose(), b, one, Par::Seq);
            let first = j * Self::WIDTH;
            let mut rows = product.as_mut().subrows_mut(first, part.nrows());
            zip!(&mut rows, &part).for_each(|unzip!(to, from)| *to = from.to_f64());
        }
        product
    }

    fn width(&self, block: usize) -> usize {
        Self::WIDTH.min(self.columns - block * Self::WIDTH)
    }

    /// [`PANEL`] rows of a block.
    fn panel(&self, block: usize, panel: usize) -> MatRef<'_, T> {
        let (width, start) = (self.width(block), panel * PANEL);
        let height = PANEL.min(self.rows - start);
        let values = &self.blocks[block][start * width..][..height * width];
        MatRef::from_row_major_slice(values, height, width)
    }
}

impl<T> Drop for ColumnBlocks<'_, T> {
    fn drop(&mut self) {
        for block in self.blocks.drain(..) {
            self.memory.give(block);
        }
    }
}

fn doubled_transpose<T: Real>(panel: MatRef<T>) -> Mat<f64> {
    let mut doubled = Mat::zeros(panel.ncols(), panel.nrows());
    zip!(&mut doubled, panel.transpose()).for_each(|unzip!(to, from)| *to = from.to_f64());
    doubled
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
