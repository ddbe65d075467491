//! Sparse Cholesky: pattern and ordering once, values many times, many right-hand sides.
//!
use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Par, Side};

use super::block_matrix::{BlockMatrix, BlockPattern};
use super::memory::{Memories, Memory};
use super::real::Real;
use super::triangular::Lower;
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
    /// Memory of factors that are no longer used, and for work with them.
    memories: Memories,
}

/// A numeric factor L L^T = A.
#[derive(Debug)]
pub struct Factor {
    symbolic: Arc<SymbolicFactor>,
    values: Vec<f64>,
}

/// A factor in another precision, for right-hand sides in that precision.
#[derive(Debug)]
pub struct RoundedFactor<T: Real> {
    symbolic: Arc<SymbolicFactor>,
    values: Vec<T>,
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
            memories: Memories::default(),
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
        let mut values = self.memories.double.take(self.symbolic.len_val());
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

    /// Factors `matrix` with its diagonal shifted as little as it takes, in steps of a hundred; `least`
    /// and `most`: the first shift and about the last one, as shares of the mean of the diagonal.
    pub fn factor_shifted(
        self: &Arc<Self>,
        pattern: &BlockPattern,
        matrix: &BlockMatrix,
        [least, most]: [f64; 2],
    ) -> Result<Factor> {
        let mean = pattern.mean_diagonal(matrix);
        let mut shift = least * mean;
        loop {
            let mut shifted = matrix.clone();
            pattern.shift_diagonal(&mut shifted, shift);
            match self.factor(&shifted) {
                Err(error) if shift > most * mean => return Err(error),
                Err(_) => shift *= 100.0,
                Ok(factor) => return Ok(factor),
            }
        }
    }

    fn lower<'a, T: Real>(&'a self, values: &'a [T]) -> Lower<'a, T> {
        let SymbolicCholeskyRaw::Supernodal(symbolic) = self.symbolic.raw() else {
            unreachable!("the threshold forces supernodes");
        };
        let place = self.new_from_old.as_deref();
        Lower { symbolic, values, place, max_pattern: self.max_pattern }
    }
}

impl Drop for Factor {
    fn drop(&mut self) {
        self.symbolic.memories.double.give(std::mem::take(&mut self.values));
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
        self.symbolic.lower(&self.values).solve_rows(b, width);
    }

    /// A copy with rounded values.
    pub fn rounded<T: Real>(&self) -> RoundedFactor<T> {
        let mut values = T::memory(&self.symbolic.memories).take(self.values.len());
        values.iter_mut().zip(&self.values).for_each(|(to, &value)| *to = T::from_f64(value));
        RoundedFactor { symbolic: Arc::clone(&self.symbolic), values }
    }
}

impl<T: Real> RoundedFactor<T> {
    /// Memory for right-hand sides.
    pub fn memory(&self) -> &Memory<T> {
        T::memory(&self.symbolic.memories)
    }

    /// Solves A X = B for a row-major block of at most a few hundred columns, in place, on this
    /// thread.
    pub fn solve_rows(&self, b: &mut [T], width: usize) {
        self.symbolic.lower(&self.values).solve_rows(b, width);
    }
}

impl<T: Real> Drop for RoundedFactor<T> {
    fn drop(&mut self) {
        let values = std::mem::take(&mut self.values);
        self.memory().give(values);
    }
}

/// The inverse permutation.
fn inverse(order: &[usize]) -> Vec<usize> {
    let mut inverse = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        inverse[old] = new;
    }
    inverse
}
