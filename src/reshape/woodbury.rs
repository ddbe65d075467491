//! The published way to one Gauss-Newton direction, for `--paper`: [W] Section 3.6, Eqs. 12-18.
//!
//! H = R + Z^T Z = B + Zh^T Zh with B = R - sum psi psi^T and Zh = [Z; psi^T], psi the six constant
//! strains that R leaves free. B is never formed: by the singular lemma, B^-1 = R^+ - sum psi psi^T.
//! B and the capacity matrix I + Zh B^-1 Zh^T are indefinite, so that the latter is factored by LU
//! with pivoting. (Z carries sqrt(c), not c as [W] Eq. 12 prints.)

use faer::Mat;
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::Solve;
use nalgebra::Vector6;

use super::gauss_newton::{Corrections, Direction};
use super::linearization::Linearization;
use super::rows::Rows;
use crate::fem::StrainSmoothness;
use crate::material::IsotropicDensity;
use crate::math::Sym3;

impl<M: IsotropicDensity> Linearization<'_, M> {
    /// The direction of a held body with a smoothness that leaves constants free; the same as
    /// [`super::NormalEquations::direction`] in exact arithmetic. The capacity matrix may be rounded;
    /// what its direction misses is solved for again, until the error, in the norm of the equations,
    /// is about the share `reduction`.
    pub fn woodbury_direction(
        &self,
        rows: &Rows,
        smoothness: &StrainSmoothness,
        s: &[Sym3],
        reduction: f64,
    ) -> Direction {
        let (gram, constants) = self.prior_gram(rows, smoothness);
        let capacity = capacity(&gram, &constants, s.len());
        let solver = Woodbury { at: self, rows, smoothness, capacity: capacity.partial_piv_lu() };

        // The negative gradient R s + Z^T r.
        let mut force = smoothness.apply(s);
        for (f, z) in force.iter_mut().zip(self.transpose_multiply(rows, &rows.residuals())) {
            *f = -(*f + z);
        }
        let mut ds = vec![Sym3::zeros(); s.len()];
        let mut corrections = Corrections::new(reduction);
        for _ in 0..Corrections::MAX {
            let change = solver.solve(&force);
            if !corrections.is_needed(force.iter().zip(&change).map(|(f, c)| f.dot(c)).sum()) {
                break;
            }
            ds.iter_mut().zip(&change).for_each(|(ds, c)| *ds += c);
            let data = self.transpose_multiply(rows, &rows.measure(&self.shape_change(&change)));
            let prior = smoothness.apply(&change);
            force.iter_mut().zip(prior.iter().zip(&data)).for_each(|(f, (r, z))| *f -= r + z);
        }
        Direction { dx: self.shape_change(&ds), ds, rigid: None }
    }
}

/// H^-1 by the Woodbury identity.
struct Woodbury<'a, M> {
    at: &'a Linearization<'a, M>,
    rows: &'a Rows,
    smoothness: &'a StrainSmoothness,
    capacity: PartialPivLu<f64>,
}

impl<M: IsotropicDensity> Woodbury<'_, M> {
    /// v - B^-1 Zh^T (I + Zh B^-1 Zh^T)^-1 Zh v with v = B^-1 f.
    fn solve(&self, f: &[Sym3]) -> Vec<Sym3> {
        let v = lemma(self.smoothness, f);
        let root = (f.len() as f64).sqrt();
        let mut right = self.rows.measure(&self.at.shape_change(&v));
        right.extend((v.iter().sum::<Sym3>() / root).iter());
        let y = self.capacity.solve(&Mat::from_fn(right.len(), 1, |i, _| right[i]));
        let q = self.rows.rows.len();
        let y: Vec<f64> = (0..q + 6).map(|i| y[(i, 0)]).collect();
        let mut back = self.at.transpose_multiply(self.rows, &y[..q]);
        let constant = Sym3::from_column_slice(&y[q..]) / root;
        for b in &mut back {
            *b += constant;
        }
        v.iter().zip(lemma(self.smoothness, &back)).map(|(v, b)| v - b).collect()
    }
}

/// B^-1 b = R^+ b - sum psi (psi . b): the singular lemma (iii) of [W] Appendix A.
fn lemma(smoothness: &StrainSmoothness, b: &[Sym3]) -> Vec<Sym3> {
    let mean: Sym3 = b.iter().sum::<Sym3>() / b.len() as f64;
    smoothness.solve(b).into_iter().map(|x| x - mean).collect()
}

/// I + Zh B^-1 Zh^T from Z R^+ Z^T and Z psi = constants / sqrt(carriers).
fn capacity(gram: &Mat<f64>, constants: &[Vector6<f64>], carriers: usize) -> Mat<f64> {
    let q = constants.len();
    let root = (carriers as f64).sqrt();
    let z_psi = |i: usize, p: usize| constants[i][p] / root;
    Mat::from_fn(q + 6, q + 6, |i, j| match (i < q, j < q) {
        (true, true) => {
            let common: f64 = (0..6).map(|p| z_psi(i, p) * z_psi(j, p)).sum();
            f64::from(u8::from(i == j)) + gram[(i.max(j), i.min(j))] - common
        }
        (true, false) => -z_psi(i, j - q),
        (false, true) => -z_psi(j, i - q),
        // psi^T B^-1 psi = -1 takes the identity away.
        (false, false) => 0.0,
    })
}
