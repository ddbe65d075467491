//! Solves with a supernodal factor for many right-hand sides.
//!
//! Rows are contiguous, and supernodes that a sparse right-hand side does not reach are passed over
//! (about three times as fast as faer's solve, column by column; docs/benchmarks.md).

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::sparse::linalg::cholesky::supernodal::{SupernodalLltRef, SymbolicSupernodalCholesky};
use faer::{Accum, MatMut, MatRef, Par};

use super::real::Real;

/// L of L L^T = A.
pub(super) struct Lower<'a, T> {
    pub symbolic: &'a SymbolicSupernodalCholesky<usize>,
    pub values: &'a [T],
    /// Place of each row in the elimination order, unless it is its own.
    pub place: Option<&'a [usize]>,
    /// Rows below the diagonal block of a supernode, at most.
    pub max_pattern: usize,
}

impl<T: Real> Lower<'_, T> {
    /// Solves A X = B for a row-major block, in place, on this thread.
    pub fn solve_rows(&self, b: &mut [T], width: usize) {
        let mut gathered = vec![T::from_f64(0.0); self.max_pattern * width];
        let Some(place) = self.place else {
            self.forward(b, width, &mut gathered);
            self.backward(b, width, &mut gathered);
            return;
        };
        let mut x = vec![T::from_f64(0.0); b.len()];
        for (row, &new) in b.chunks_exact(width).zip(place) {
            x[new * width..][..width].copy_from_slice(row);
        }
        self.forward(&mut x, width, &mut gathered);
        self.backward(&mut x, width, &mut gathered);
        for (row, &new) in b.chunks_exact_mut(width).zip(place) {
            row.copy_from_slice(&x[new * width..][..width]);
        }
    }

    /// x := L^-1 x, supernode by supernode; those whose rows are all zero change nothing.
    fn forward(&self, x: &mut [T], width: usize, gathered: &mut [T]) {
        let (zero, one) = (T::from_f64(0.0), T::from_f64(1.0));
        let llt = SupernodalLltRef::new(self.symbolic, self.values);
        for s in 0..self.symbolic.n_supernodes() {
            let node = llt.supernode(s);
            let (start, size) = (node.start(), node.val().ncols());
            let top = &mut x[start * width..(start + size) * width];
            if top.iter().all(|&value| value == zero) {
                continue;
            }
            let (l_top, l_rest) = node.val().split_at_row(size);
            let mut top = MatMut::from_row_major_slice_mut(top, size, width);
            let below = &mut gathered[..node.pattern().len() * width];
            let product =
                MatMut::from_row_major_slice_mut(&mut *below, node.pattern().len(), width);
            solve_lower_triangular_in_place(l_top, top.as_mut(), Par::Seq);
            matmul(product, Accum::Replace, l_rest, top.as_ref(), one, Par::Seq);
            for (&row, values) in node.pattern().iter().zip(below.chunks_exact(width)) {
                for (target, &value) in x[row * width..][..width].iter_mut().zip(values) {
                    *target -= value;
                }
            }
        }
    }

    /// x := L^-T x.
    fn backward(&self, x: &mut [T], width: usize, gathered: &mut [T]) {
        let minus_one = T::from_f64(-1.0);
        let llt = SupernodalLltRef::new(self.symbolic, self.values);
        for s in (0..self.symbolic.n_supernodes()).rev() {
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
            let top = &mut x[start * width..(start + size) * width];
            let mut top = MatMut::from_row_major_slice_mut(top, size, width);
            matmul(top.as_mut(), Accum::Add, l_rest.transpose(), below, minus_one, Par::Seq);
            solve_upper_triangular_in_place(l_top.transpose(), top, Par::Seq);
        }
    }
}
