//! Rotations of least-squares fits, and rotation vectors.

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion};

use crate::math::{Mat3, Vec3};

/// The rotation R that maximises tr(R^T A), from the singular value decomposition of A with the
/// sign of the weakest direction turned so that det R = +1. `None` when A is (nearly) of rank
/// below two, or not finite, so that R is not determined.
pub fn best_rotation(a: &Mat3) -> Option<UnitQuaternion<f64>> {
    let size = a.amax();
    if !size.is_finite() || size == 0.0 {
        return None;
    }
    let svd = (a / size).svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let weakest = svd.singular_values.imin();
    let largest = svd.singular_values.max();
    let middle = svd.singular_values.sum() - largest - svd.singular_values[weakest];
    if middle <= 1e-9 * largest {
        return None;
    }
    let mut signs = Vec3::repeat(1.0);
    signs[weakest] = (u * v_t).determinant().signum();
    let matrix = u * Mat3::from_diagonal(&signs) * v_t;
    Some(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix)))
}

/// The rotation vector (axis times angle, angle in [0, pi]) of a rotation.
pub fn rotation_vector(q: &UnitQuaternion<f64>) -> Vec3 {
    let imaginary = q.imag();
    let sine = imaginary.norm();
    if sine < 1e-12 {
        // q and -q are one rotation; near the identity the vector is twice the imaginary part.
        return 2.0 * imaginary * q.w.signum();
    }
    let angle = 2.0 * libm::atan2(sine, q.w.abs());
    imaginary * (angle / sine) * if q.w < 0.0 { -1.0 } else { 1.0 }
}

/// Turns `isometry` about `point` by `rotation` (all in one frame).
pub fn turned_about(
    isometry: &Isometry3<f64>,
    point: &Vec3,
    rotation: UnitQuaternion<f64>,
) -> Isometry3<f64> {
    let translation = rotation * (isometry.translation.vector - point) + point;
    Isometry3::from_parts(
        Translation3::from(translation),
        renormalized(rotation * isometry.rotation),
    )
}

/// Keeps rounding from growing over many products.
pub fn renormalized(q: UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(q.into_inner())
}

/// Weighted sums of a point set paired with its image, from which the best rigid motion follows.
/// Points are taken relative to an `origin` near them, so that large scanner coordinates keep
/// their digits.
#[derive(Clone, Copy, Debug)]
pub struct PairSums {
    origin: Vec3,
    weight: f64,
    from: Vec3,
    to: Vec3,
    product: Mat3,
}

impl PairSums {
    /// Empty sums around `origin`.
    pub fn new(origin: Vec3) -> Self {
        let zero = Vec3::zeros();
        Self { origin, weight: 0.0, from: zero, to: zero, product: Mat3::zeros() }
    }

    /// Adds the pair `from` -> `to`.
    pub fn add(&mut self, from: &Vec3, to: &Vec3, weight: f64) {
        let (from, to) = (from - self.origin, to - self.origin);
        self.weight += weight;
        self.from += weight * from;
        self.to += weight * to;
        self.product += weight * to * from.transpose();
    }

    /// Sum of weights.
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// The rigid motion that carries `from` best to `to`; a pure translation where the points do
    /// not fix a rotation, `None` without weight.
    pub fn best_rigid(&self) -> Option<Isometry3<f64>> {
        if self.weight <= 0.0 {
            return None;
        }
        let (from, to) = (self.from / self.weight, self.to / self.weight);
        let covariance = self.product - self.weight * to * from.transpose();
        let rotation = best_rotation(&covariance).unwrap_or_else(UnitQuaternion::identity);
        let translation = to + self.origin - rotation * (from + self.origin);
        Some(Isometry3::from_parts(Translation3::from(translation), rotation))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rigid_motion_is_found_again_far_from_the_origin() {
        let motion = Isometry3::new(Vec3::new(3.0, -2.0, 900.0), Vec3::new(0.4, -2.0, 1.1));
        let points = [[0., 0., 0.], [10., 1., 0.], [0., 7., 2.], [3., 3., -5.]];
        let origin = Vec3::new(500.0, -700.0, 300.0);
        let mut sums = PairSums::new(origin);
        for p in points {
            let p = Vec3::from(p) + origin;
            sums.add(&p, &(motion * nalgebra::Point3::from(p)).coords, 2.0);
        }
        let found = sums.best_rigid().unwrap();
        assert!(found.rotation.angle_to(&motion.rotation) < 1e-10);
        let p = origin;
        let gap = found * nalgebra::Point3::from(p) - motion * nalgebra::Point3::from(p);
        assert!(gap.norm() < 1e-9);
    }

    #[test]
    fn a_mirrored_set_still_gives_a_rotation_and_a_line_gives_none() {
        let mirrored = Mat3::from_diagonal(&Vec3::new(3.0, 2.0, -1.0));
        let r = best_rotation(&mirrored).unwrap();
        assert!((r.to_rotation_matrix().matrix().determinant() - 1.0).abs() < 1e-12);
        assert!(best_rotation(&Mat3::from_diagonal(&Vec3::new(3.0, 0.0, 0.0))).is_none());
        assert!(best_rotation(&Mat3::repeat(f64::NAN)).is_none());
    }

    #[test]
    fn rotation_vectors_survive_the_way_there_and_back() {
        for v in [[0.1, 0.2, -3.0], [0.0, 0.0, 0.0], [1e-14, 0.0, 0.0], [-2.0, 2.0, 0.3]] {
            let v = Vec3::from(v);
            let q = UnitQuaternion::from_scaled_axis(v);
            assert!((rotation_vector(&q) - v).norm() < 1e-9);
            let minus = UnitQuaternion::new_unchecked(-q.into_inner());
            assert!((rotation_vector(&minus) - v).norm() < 1e-9);
        }
    }
}
