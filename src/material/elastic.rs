//! Stress and stiffness of any isotropic density psi(I, J), I = |F|^2, J = det F.
//!
//! - `stress`         - P = 2 psi_I F + psi_J cof F
//! - `stress_change`  - D : dF, D = dP/dF
//! - `stiffness_spd`  - the nearest positive semidefinite D as a matrix, by its analytic eigenpairs
//!
//! Matrices are stacked by columns: entry (i, j) of F is number i + 3 j.

use nalgebra::{SMatrix, SVector};

use crate::math::{Mat3, SignedSvd, Vec3, signed_svd, symmetric3};

/// dP/dF: both sides stacked by columns.
pub type Mat9 = SMatrix<f64, 9, 9>;

/// A density and its derivatives by I and J.
#[derive(Clone, Copy, Debug, Default)]
pub struct Density {
    /// psi, zero at rest.
    pub value: f64,
    /// d psi / dI
    pub d_i: f64,
    /// d psi / dJ
    pub d_j: f64,
    /// d2 psi / dI2
    pub d_ii: f64,
    /// d2 psi / dI dJ
    pub d_ij: f64,
    /// d2 psi / dJ2
    pub d_jj: f64,
}

/// An isotropic energy density as a function of I = |F|^2 and J = det F, rest state (3, 1).
pub trait IsotropicDensity: Sync {
    /// Value and derivatives.
    fn density(&self, i: f64, j: f64) -> Density;

    /// Value and derivatives at a deformation gradient.
    fn at(&self, f: &Mat3) -> Density {
        self.density(f.norm_squared(), f.determinant())
    }
}

/// First Piola-Kirchhoff stress.
pub fn stress(d: &Density, f: &Mat3) -> Mat3 {
    f * (2.0 * d.d_i) + cofactor(f) * d.d_j
}

/// dP/dF : dF, the change of the stress for a change `df` of the deformation gradient.
pub fn stress_change(d: &Density, f: &Mat3, df: &Mat3) -> Mat3 {
    let cof = cofactor(f);
    let (di, dj) = (2.0 * f.dot(df), cof.dot(df));
    df * (2.0 * d.d_i)
        + f * (2.0 * (d.d_ii * di + d.d_ij * dj))
        + cof * (d.d_ij * di + d.d_jj * dj)
        + cofactor_change(f, df) * d.d_j
}

/// dP/dF with its negative eigenvalues set to zero.
///
/// Three eigenmatrices are U diag(q) V^T, three twists and three flips are fixed; no divisions.
pub fn stiffness_spd(d: &Density, f: &Mat3) -> Mat9 {
    let SignedSvd { u, s, v } = signed_svd(f);
    let mut k = Mat9::zeros();
    let (lambda, q) = symmetric3::eigen(&stretch_block(d, &s));
    for e in 0..3 {
        let scaled = u * Mat3::from_diagonal(&q.column(e).into_owned()) * v.transpose();
        add_eigenpair(&mut k, lambda[e], &stack(&scaled));
    }
    let m = 2.0 * d.d_i;
    for (i, j, l) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
        let ij = u.column(i) * v.column(j).transpose();
        let ji = u.column(j) * v.column(i).transpose();
        let half = std::f64::consts::FRAC_1_SQRT_2;
        add_eigenpair(&mut k, m - d.d_j * s[l], &stack(&((ij + ji) * half)));
        add_eigenpair(&mut k, m + d.d_j * s[l], &stack(&((ij - ji) * half)));
    }
    k
}

/// Second derivatives of psi by the three signed stretches.
fn stretch_block(d: &Density, s: &Vec3) -> Mat3 {
    let c = Vec3::new(s[1] * s[2], s[0] * s[2], s[0] * s[1]);
    Mat3::from_fn(|a, b| {
        let mixed = 2.0 * d.d_ij * (s[a] * c[b] + c[a] * s[b]);
        let common = 4.0 * d.d_ii * s[a] * s[b] + d.d_jj * c[a] * c[b] + mixed;
        if a == b { common + 2.0 * d.d_i } else { common + d.d_j * s[3 - a - b] }
    })
}

fn add_eigenpair(k: &mut Mat9, lambda: f64, e: &SVector<f64, 9>) {
    if lambda > 0.0 {
        *k += e * e.transpose() * lambda;
    }
}

/// cof F = dJ/dF.
pub fn cofactor(f: &Mat3) -> Mat3 {
    let [a, b, c] = [f.column(0), f.column(1), f.column(2)];
    Mat3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)])
}

/// d(cof F)/dF : dF.
fn cofactor_change(f: &Mat3, df: &Mat3) -> Mat3 {
    let column =
        |b: usize, c: usize| df.column(b).cross(&f.column(c)) + f.column(b).cross(&df.column(c));
    Mat3::from_columns(&[column(1, 2), column(2, 0), column(0, 1)])
}

fn stack(m: &Mat3) -> SVector<f64, 9> {
    SVector::from_column_slice(m.as_slice())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::StableNeoHookean;
    use crate::math::derivative_check::order_of_convergence;

    /// A density with all mixed derivatives, so that no term of the general formulas is idle.
    struct Mixed;

    impl IsotropicDensity for Mixed {
        fn density(&self, i: f64, j: f64) -> Density {
            let value = i * i * j + j * j * j - 0.5 * i;
            Density {
                value,
                d_i: 2.0 * i * j - 0.5,
                d_j: i * i + 3.0 * j * j,
                d_ii: 2.0 * j,
                d_ij: 2.0 * i,
                d_jj: 6.0 * j,
            }
        }
    }

    fn materials() -> [Box<dyn IsotropicDensity>; 2] {
        [Box::new(StableNeoHookean::new(1.0, 0.45)), Box::new(Mixed)]
    }

    fn samples() -> [Mat3; 2] {
        let f = Mat3::new(1.1, 0.2, -0.4, 0.3, 0.9, 0.1, 0.05, 0.5, 1.3);
        [f, Mat3::from_columns(&[f.column(1), f.column(0), f.column(2)])]
    }

    #[test]
    fn stress_and_its_change_converge_at_second_order() {
        let df = Mat3::new(0.3, -0.2, 0.5, 0.1, 0.7, -0.3, 0.2, 0.4, -0.6);
        for material in materials() {
            for f in samples() {
                let psi = |f: &Mat3| material.at(f).value;
                let p = |f: &Mat3| stress(&material.at(f), f);
                let slope = p(&f).dot(&df);
                let order = order_of_convergence(|h| {
                    nalgebra::Vector1::new(
                        (psi(&(f + df * h)) - psi(&(f - df * h))) / (2.0 * h) - slope,
                    )
                });
                assert!(order > 1.9, "stress: order {order}");
                let dp = stress_change(&material.at(&f), &f, &df);
                let order = order_of_convergence(|h| {
                    stack(&((p(&(f + df * h)) - p(&(f - df * h))) / (2.0 * h) - dp))
                });
                assert!(order > 1.9, "stress change: order {order}");
            }
        }
    }

    #[test]
    fn projection_equals_the_dense_eigenvalue_clamp() {
        for material in materials() {
            for f in samples() {
                let d = material.at(&f);
                let unit = |k| Mat3::from_fn(|i, j| f64::from(u8::from(i + 3 * j == k)));
                let columns =
                    std::array::from_fn::<_, 9, _>(|k| stack(&stress_change(&d, &f, &unit(k))));
                let dense = Mat9::from_columns(&columns).symmetric_eigen();
                let clamped = dense.eigenvectors
                    * Mat9::from_diagonal(&dense.eigenvalues.map(|l| l.max(0.0)))
                    * dense.eigenvectors.transpose();
                assert!((stiffness_spd(&d, &f) - clamped).norm() < 1e-12 * clamped.norm());
            }
        }
    }
}
