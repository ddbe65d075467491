//! The published way to one Gauss-Newton direction, for `--paper`: [W] Section 3.6, Eqs. 12-18.
//!
//! H = R + Z^T Z = B + Zh^T Zh with B = R - sum psi psi^T and Zh = [Z; psi^T], psi the six constant
//! strains that R leaves free. B is never formed: by the singular lemma, B^-1 = R^+ - sum psi psi^T.
//! B and the capacity matrix I + Zh B^-1 Zh^T are indefinite, so that the latter is factored by LU
//! with pivoting. (Z carries sqrt(c), not c as [W] Eq. 12 prints.)

use faer::Mat;
use faer::prelude::Solve;
use nalgebra::Vector6;

use super::gauss_newton::Direction;
use super::linearization::Linearization;
use super::rows::Rows;
use crate::fem::StrainSmoothness;
use crate::material::IsotropicDensity;
use crate::math::Sym3;
use crate::solve::ColumnBlocks;

impl<M: IsotropicDensity> Linearization<'_, M> {
    /// The direction of a held body with a smoothness that leaves constants free; the same as
    /// [`super::NormalEquations::direction`] in exact arithmetic.
    pub fn woodbury_direction(
        &self,
        rows: &Rows,
        smoothness: &StrainSmoothness,
        s: &[Sym3],
        anchor: &[Sym3],
    ) -> Direction {
        let offset: Vec<Sym3> = s.iter().zip(anchor).map(|(s, a)| s - a).collect();
        let residuals = rows.residuals();
        // v = B^-1 times the negative gradient R (s - anchor) + Z^T r.
        let mut gradient = smoothness.apply(&offset);
        for (g, z) in gradient.iter_mut().zip(self.transpose_multiply(rows, &residuals)) {
            *g += z;
        }
        let v: Vec<Sym3> = lemma(smoothness, &gradient).into_iter().map(|v| -v).collect();
        // ds = v - B^-1 Zh^T (I + Zh B^-1 Zh^T)^-1 Zh v.
        let stiffness = self.stiffness.rounded::<f64>();
        let (half, constants) = self.half_inverse(&stiffness, rows, smoothness);
        let right = self.extended_multiply(rows, &v);
        let right = Mat::from_fn(right.len(), 1, |i, _| right[i]);
        let y = capacity(&half, &constants, s.len()).partial_piv_lu().solve(&right);
        let q = rows.rows.len();
        let mut back =
            self.transpose_multiply(rows, &(0..q).map(|i| y[(i, 0)]).collect::<Vec<_>>());
        let constant = Sym3::from_fn(|p, _| y[(q + p, 0)]) / (s.len() as f64).sqrt();
        for b in &mut back {
            *b += constant;
        }
        let ds: Vec<Sym3> = v.iter().zip(lemma(smoothness, &back)).map(|(v, b)| v - b).collect();
        Direction { dx: self.shape_change(&ds), ds, rigid: None }
    }

    /// [Z v; psi^T v].
    fn extended_multiply(&self, rows: &Rows, v: &[Sym3]) -> Vec<f64> {
        let mut product = rows.measure(&self.shape_change(v));
        let constant: Sym3 = v.iter().sum::<Sym3>() / (v.len() as f64).sqrt();
        product.extend(constant.iter());
        product
    }
}

/// B^-1 b = R^+ b - sum psi (psi . b): the singular lemma (iii) of [W] Appendix A.
fn lemma(smoothness: &StrainSmoothness, b: &[Sym3]) -> Vec<Sym3> {
    let mean: Sym3 = b.iter().sum::<Sym3>() / b.len() as f64;
    smoothness.solve(b).into_iter().map(|x| x - mean).collect()
}

/// I + Zh B^-1 Zh^T from Z R^+ Z^T = H^T H and Z psi = constants / sqrt(carriers).
fn capacity(half: &ColumnBlocks<'_, f64>, constants: &[Vector6<f64>], carriers: usize) -> Mat<f64> {
    let q = constants.len();
    let mut gram = Mat::zeros(q, q);
    half.add_gram_lower::<f64>(&mut gram);
    let z_psi = |i: usize, p: usize| constants[i][p] / (carriers as f64).sqrt();
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
