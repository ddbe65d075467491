//! Symmetric 3x3 matrices as six numbers, and their exponential with its derivative.
//!
//! The six numbers (s0..s5) stand for [[s0,s1,s2],[s1,s3,s4],[s2,s4,s5]].

use nalgebra::Vector6;

use super::{Mat3, Vec3};

/// A symmetric 3x3 matrix as six numbers.
pub type Sym3 = Vector6<f64>;

/// The number that each of the six counts for in a Frobenius product: off-diagonals twice.
pub const MULTIPLICITY: [f64; 6] = [1.0, 2.0, 2.0, 1.0, 2.0, 1.0];

/// Row and column of each of the six numbers.
const PLACE: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// The full matrix.
pub fn to_matrix(s: &Sym3) -> Mat3 {
    Mat3::new(s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5])
}

/// The six numbers of the symmetric part of `m`.
pub fn from_matrix(m: &Mat3) -> Sym3 {
    Sym3::from_fn(|p, _| {
        let (i, j) = PLACE[p];
        0.5 * (m[(i, j)] + m[(j, i)])
    })
}

/// The matrix with ones where number `p` stands.
pub fn unit(p: usize) -> Mat3 {
    let (i, j) = PLACE[p];
    let mut m = Mat3::zeros();
    m[(i, j)] = 1.0;
    m[(j, i)] = 1.0;
    m
}

/// Eigenvalues and the orthonormal eigenvectors (columns), in no particular order.
pub fn eigen(m: &Mat3) -> (Vec3, Mat3) {
    let e = m.symmetric_eigen();
    (e.eigenvalues, e.eigenvectors)
}

/// exp(S), and with it its derivatives with respect to the six numbers of S.
pub fn exp_with_derivatives(s: &Sym3) -> (Mat3, [Mat3; 6]) {
    let (lambda, q) = eigen(&to_matrix(s));
    let e = lambda.map(libm::exp);
    // Daleckii-Krein: divided differences of exp in the eigenbasis.
    let gamma = Mat3::from_fn(|i, j| {
        let half_difference = 0.5 * (lambda[i] - lambda[j]);
        libm::exp(0.5 * (lambda[i] + lambda[j])) * sinh_over(half_difference)
    });
    let value = q * Mat3::from_diagonal(&e) * q.transpose();
    let derivatives = std::array::from_fn(|p| {
        let inner = q.transpose() * unit(p) * q;
        q * gamma.component_mul(&inner) * q.transpose()
    });
    (value, derivatives)
}

/// exp(S).
pub fn exp(s: &Sym3) -> Mat3 {
    let (lambda, q) = eigen(&to_matrix(s));
    q * Mat3::from_diagonal(&lambda.map(libm::exp)) * q.transpose()
}

/// log of a symmetric positive definite matrix.
pub fn log(m: &Mat3) -> Sym3 {
    let (lambda, q) = eigen(m);
    from_matrix(&(q * Mat3::from_diagonal(&lambda.map(libm::log)) * q.transpose()))
}

/// sinh(x)/x, exact at 0.
fn sinh_over(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 + x * x / 6.0 } else { libm::sinh(x) / x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::derivative_check::order_of_convergence;

    #[test]
    fn log_inverts_exp() {
        let s = Sym3::new(0.3, -0.2, 0.1, -0.5, 0.4, 0.2);
        assert!((log(&exp(&s)) - s).norm() < 1e-13);
    }

    #[test]
    fn exp_derivatives_converge_at_second_order() {
        let cases = [Sym3::new(0.3, -0.2, 0.1, -0.5, 0.4, 0.2), Sym3::zeros()];
        for s in cases {
            let (_, derivatives) = exp_with_derivatives(&s);
            let ds = Sym3::new(0.5, 0.3, -0.7, 0.2, -0.4, 0.6);
            let slope: Mat3 = (0..6).map(|p| derivatives[p] * ds[p]).sum();
            let order = order_of_convergence(|h| {
                (exp(&(s + ds * h)) - exp(&(s - ds * h))) / (2.0 * h) - slope
            });
            assert!(order > 1.9, "order {order}");
        }
    }
}
