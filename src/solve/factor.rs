//! Sparse Cholesky: pattern and ordering once, values many times, many right-hand sides.
//!
//! faer factors; the solve for many right-hand sides is ours: rows are contiguous, and supernodes
//! that a sparse right-hand side does not reach are passed over (about three times as fast as
//! column by column, docs/benchmarks.md).

use std::sync::{Arc, Mutex, PoisonError};

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky, supernodal::SupernodalLltRef,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Accum, MatMut, MatRef, Par, Side};

use super::block_matrix::{BlockMatrix, BlockPattern};
use crate::error::{Error, Result};

/// The symbolic factorization of one pattern.
#[derive(Debug)]
pub struct SymbolicFactor {
    symbolic: SymbolicCholesky<usize>,
    col_ptr: Vec<usize>,
    row_idx: Vec<usize>,
    /// `new_from_old[i]`: place of row i in the elimination order, unless it is i.
    new_from_old: Option<Vec<usize>>,
    max_pattern: usize,
    /// Memory of factors that are no longer used, for the next one.
    spare: Mutex<Vec<Vec<f64>>>,
}

/// A numeric factor L L^T = A.
#[derive(Debug)]
pub struct Factor {
    symbolic: Arc<SymbolicFactor>,
    values: Vec<f64>,
}

impl SymbolicFactor {
    /// Analyses a pattern with its own elimination order.
    pub fn new(pattern: &BlockPattern) -> Result<Arc<Self>> {
        let n = pattern.size();
        // faer takes the lower triangle with a permutation only.
        let own_order: Vec<usize> = (0..n).collect();
        let new_from_old = pattern.order.as_ref().map(|order| inverse(order));
        let failed = |_| Error::Singular("the system is too large to be analysed in memory".into());
        let matrix =
            SymbolicSparseColMatRef::new_checked(n, n, &pattern.col_ptr, None, &pattern.row_idx);
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let order = PermRef::new_checked(
            pattern.order.as_ref().unwrap_or(&own_order),
            new_from_old.as_ref().unwrap_or(&own_order),
            n,
        );
        let symbolic = factorize_symbolic_cholesky(
            matrix,
            Side::Lower,
            SymmetricOrdering::Custom(order),
            params,
        )
        .map_err(failed)?;
        let max_pattern = match symbolic.raw() {
            SymbolicCholeskyRaw::Supernodal(s) => {
                (0..s.n_supernodes()).map(|i| s.supernode(i).pattern().len()).max().unwrap_or(0)
            }
            SymbolicCholeskyRaw::Simplicial(_) => unreachable!("the threshold forces supernodes"),
        };
        let (col_ptr, row_idx) = (pattern.col_ptr.clone(), pattern.row_idx.clone());
        Ok(Arc::new(Self {
            symbolic,
            col_ptr,
            row_idx,
            new_from_old,
            max_pattern,
            spare: Mutex::default(),
        }))
    }

    /// Number of entries of L.
    pub fn fill(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Factors `matrix`; fails when it is not positive definite.
    pub fn factor(self: &Arc<Self>, matrix: &BlockMatrix) -> Result<Factor> {
        let n = self.col_ptr.len() - 1;
        let pattern =
            SymbolicSparseColMatRef::new_checked(n, n, &self.col_ptr, None, &self.row_idx);
        let a = SparseColMatRef::new(pattern, &matrix.values[..]);
        let mut values = self.memory().pop().unwrap_or_else(|| vec![0.0; self.symbolic.len_val()]);
        let mut memory = MemBuffer::new(
            self.symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, faer::Spec::default()),
        );
        let outcome = self
            .symbolic
            .factorize_numeric_llt(
                &mut values,
                a,
                Side::Lower,
                faer::linalg::cholesky::llt::factor::LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                faer::Spec::default(),
            )
            .map(|_| ());
        // A failed factor gives its memory back as well.
        let factor = Factor { symbolic: Arc::clone(self), values };
        match outcome {
            Ok(()) => Ok(factor),
            Err(_) => Err(Error::Singular("the stiffness matrix is not positive definite".into())),
        }
    }

    fn memory(&self) -> std::sync::MutexGuard<'_, Vec<Vec<f64>>> {
        self.spare.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Factor {
    fn drop(&mut self) {
        self.symbolic.memory().push(std::mem::take(&mut self.values));
    }
}

impl Factor {
    /// Number of entries of L.
    pub fn fill(&self) -> usize {
        self.symbolic.fill()
    }

    /// Solves A x = b for one right-hand side, in place.
    pub fn solve(&self, b: &mut [f64]) {
        self.solve_rows(b, 1);
    }

    /// Solves A X = B for a row-major block of at most a few hundred columns, in place, on this
    /// thread.
    pub fn solve_rows(&self, b: &mut [f64], width: usize) {
        let mut gathered = vec![0.0; self.symbolic.max_pattern * width];
        let Some(place) = &self.symbolic.new_from_old else {
            self.forward(b, width, &mut gathered);
            self.backward(b, width, &mut gathered);
            return;
        };
        let mut x = vec![0.0; b.len()];
        for (row, &new) in b.chunks_exact(width).zip(place) {
            x[new * width..][..width].copy_from_slice(row);
        }
        self.forward(&mut x, width, &mut gathered);
        self.backward(&mut x, width, &mut gathered);
        for (row, &new) in b.chunks_exact_mut(width).zip(place) {
            row.copy_from_slice(&x[new * width..][..width]);
        }
    }

    fn supernodes(&self) -> SupernodalLltRef<'_, usize, f64> {
        match self.symbolic.symbolic.raw() {
            SymbolicCholeskyRaw::Supernodal(s) => SupernodalLltRef::new(s, &self.values),
            SymbolicCholeskyRaw::Simplicial(_) => unreachable!("the threshold forces supernodes"),
        }
    }

    /// x := L^-1 x, supernode by supernode; those whose rows are all zero change nothing.
    fn forward(&self, x: &mut [f64], width: usize, gathered: &mut [f64]) {
        let llt = self.supernodes();
        for s in 0..llt.symbolic().n_supernodes() {
            let node = llt.supernode(s);
            let (start, size) = (node.start(), node.val().ncols());
            let top = &mut x[start * width..(start + size) * width];
            if top.iter().all(|&value| value == 0.0) {
                continue;
            }
            let (l_top, l_rest) = node.val().split_at_row(size);
            let top = MatMut::from_row_major_slice_mut(top, size, width);
            let product = MatMut::from_row_major_slice_mut(
                &mut gathered[..node.pattern().len() * width],
                node.pattern().len(),
                width,
            );
            multiply_forward(l_top, l_rest, top, product);
            for (&row, values) in node.pattern().iter().zip(gathered.chunks_exact(width)) {
                for (target, value) in x[row * width..][..width].iter_mut().zip(values) {
                    *target -= value;
                }
            }
        }
    }

    /// x := L^-T x.
    fn backward(&self, x: &mut [f64], width: usize, gathered: &mut [f64]) {
        let llt = self.supernodes();
        for s in (0..llt.symbolic().n_supernodes()).rev() {
            let node = llt.supernode(s);
            let (start, size) = (node.start(), node.val().ncols());
            for (&row, values) in node.pattern().iter().zip(gathered.chunks_exact_mut(width)) {
                values.copy_from_slice(&x[row * width..][..width]);
            }
            let (l_top, l_rest) = node.val().split_at_row(size);
            let below = MatRef::from_row_major_slice(
                &gathered[..node.pattern().len() * width],
                node.pattern().len(),
                width,
            );
            let mut top = MatMut::from_row_major_slice_mut(
                &mut x[start * width..(start + size) * width],
                size,
                width,
            );
            matmul(top.as_mut(), Accum::Add, l_rest.transpose(), below, -1.0, Par::Seq);
            solve_upper_triangular_in_place(l_top.transpose(), top, Par::Seq);
        }
    }
}

/// top := L_top^-1 top, product := L_rest top.
fn multiply_forward(
    l_top: MatRef<'_, f64>,
    l_rest: MatRef<'_, f64>,
    mut top: MatMut<'_, f64>,
    product: MatMut<'_, f64>,
) {
    solve_lower_triangular_in_place(l_top, top.as_mut(), Par::Seq);
    matmul(product, Accum::Replace, l_rest, top.as_ref(), 1.0, Par::Seq);
}

/// The inverse permutation.
fn inverse(order: &[usize]) -> Vec<usize> {
    let mut inverse = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        inverse[old] = new;
    }
    inverse
}
