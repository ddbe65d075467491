//! Signed singular value decomposition of 3x3 matrices.

use super::{Mat3, Vec3};

/// F = U diag(s) V^T with det U = det V = 1; the last singular value carries the sign of det F.
#[derive(Clone, Copy, Debug)]
pub struct SignedSvd {
    /// Left rotation.
    pub u: Mat3,
    /// Singular values by falling magnitude; only the last may be negative.
    pub s: Vec3,
    /// Right rotation.
    pub v: Mat3,
}

/// Signed SVD by one-sided Jacobi rotations: accurate for small singular values too, which an
/// eigendecomposition of F^T F is not.
pub fn signed_svd(f: &Mat3) -> SignedSvd {
    let (mut b, mut v) = (*f, Mat3::identity());
    for _ in 0..30 {
        let mut off = 0.0_f64;
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            off = off.max(orthogonalize(&mut b, &mut v, i, j));
        }
        if off < 1e-15 {
            break;
        }
    }
    sort_columns(&mut b, &mut v);
    if v.determinant() < 0.0 {
        let (flipped_v, flipped_b) = (-v.column(2), -b.column(2));
        v.set_column(2, &flipped_v);
        b.set_column(2, &flipped_b);
    }
    let (u0, u1) = left_pair(&b);
    let u2 = u0.cross(&u1);
    let s = Vec3::new(b.column(0).norm(), b.column(1).dot(&u1), b.column(2).dot(&u2));
    SignedSvd { u: Mat3::from_columns(&[u0, u1, u2]), s, v }
}

/// The rotation nearest to `f` (det = +1).
pub fn nearest_rotation(f: &Mat3) -> Mat3 {
    let svd = signed_svd(f);
    svd.u * svd.v.transpose()
}

/// Rotates columns i and j of b (and v) until they are orthogonal; returns how far they were.
fn orthogonalize(b: &mut Mat3, v: &mut Mat3, i: usize, j: usize) -> f64 {
    let (alpha, beta) = (b.column(i).norm_squared(), b.column(j).norm_squared());
    let gamma = b.column(i).dot(&b.column(j));
    let off = gamma.abs() / (alpha * beta).sqrt().max(f64::MIN_POSITIVE);
    if gamma == 0.0 || off < 1e-16 {
        return 0.0;
    }
    let zeta = (beta - alpha) / (2.0 * gamma);
    let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
    let c = 1.0 / (1.0 + t * t).sqrt();
    let s = c * t;
    for m in [b, v] {
        let (p, q) = (m.column(i).into_owned(), m.column(j).into_owned());
        m.set_column(i, &(p * c - q * s));
        m.set_column(j, &(p * s + q * c));
    }
    off
}

/// Longest column first, keeping the determinants' signs.
fn sort_columns(b: &mut Mat3, v: &mut Mat3) {
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if b.column(i).norm_squared() < b.column(j).norm_squared() {
            for m in [&mut *b, &mut *v] {
                let (p, q) = (m.column(i).into_owned(), m.column(j).into_owned());
                m.set_column(i, &q);
                m.set_column(j, &-p);
            }
        }
    }
}

/// Directions of the first two columns, completed where they vanish.
fn left_pair(b: &Mat3) -> (Vec3, Vec3) {
    let u0 = b.column(0).try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vec3::x);
    let raw = b.column(1) - u0 * u0.dot(&b.column(1));
    let u1 = raw.try_normalize(1e-300).unwrap_or_else(|| {
        let axis = if u0.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() };
        (axis - u0 * u0.dot(&axis)).normalize()
    });
    (u0, u1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(f: Mat3) {
        let SignedSvd { u, s, v } = signed_svd(&f);
        assert!(
            (u * Mat3::from_diagonal(&s) * v.transpose() - f).norm() < 1e-13 * (1.0 + f.norm())
        );
        assert!((u.determinant() - 1.0).abs() < 1e-13 && (v.determinant() - 1.0).abs() < 1e-13);
        assert!(s[0] >= s[1] && s[1] >= s[2].abs() - 1e-15);
    }

    #[test]
    fn rebuilds_regular_inverted_and_degenerate_matrices() {
        check(Mat3::new(1.0, 0.2, -0.4, 0.3, 0.9, 0.1, 0.0, 0.5, 1.3));
        check(Mat3::new(1.0, 0.2, -0.4, 0.3, 0.9, 0.1, 0.0, 0.5, -1.3));
        check(Mat3::identity());
        check(-Mat3::identity());
        check(Mat3::zeros());
        check(Mat3::new(1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 3.0, 6.0, 9.0));
        check(Mat3::from_diagonal(&Vec3::new(1e-9, 1.0, 1e-5)));
    }
}
