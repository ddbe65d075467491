//! Best rigid motion and best similarity between paired points.
//!
//! B. K. P. Horn, Closed-form solution of absolute orientation using unit quaternions (1987): the
//! rotation is the eigenvector of the largest eigenvalue of a symmetric 4x4 matrix, so it is never
//! a reflection. Scale as S. Umeyama (1991): least squares in the space of `to`.

use nalgebra::{Matrix4, Quaternion, SymmetricEigen, UnitQuaternion, Vector4};

use crate::error::{Error, Result};
use crate::math::{Mat3, Vec3};

/// Eigenvalues this close to the largest one (relative) leave the rotation open.
const SAME_EIGENVALUE: f64 = 1e-10;

/// x -> rotation x + translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rigid {
    /// A rotation (determinant +1).
    pub rotation: Mat3,
    /// Added after rotating.
    pub translation: Vec3,
}

impl Rigid {
    /// Leaves all points where they are.
    pub fn identity() -> Self {
        Self { rotation: Mat3::identity(), translation: Vec3::zeros() }
    }

    /// Where the point `p` goes.
    pub fn apply(&self, p: &Vec3) -> Vec3 {
        self.rotation * p + self.translation
    }

    /// First `inner`, then `self`.
    #[must_use]
    pub fn compose(&self, inner: &Self) -> Self {
        Self {
            rotation: self.rotation * inner.rotation,
            translation: self.apply(&inner.translation),
        }
    }

    /// The inverse.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, translation: -(rotation * self.translation) }
    }
}

/// x -> scale rotation x + translation, with scale > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// The same in all directions, above 0.
    pub scale: f64,
    /// A rotation (determinant +1).
    pub rotation: Mat3,
    /// Added after scaling and rotating.
    pub translation: Vec3,
}

impl From<Rigid> for Similarity {
    fn from(rigid: Rigid) -> Self {
        Self { scale: 1.0, rotation: rigid.rotation, translation: rigid.translation }
    }
}

impl Similarity {
    /// Leaves all points where they are.
    pub fn identity() -> Self {
        Rigid::identity().into()
    }

    /// Where the point `p` goes.
    pub fn apply(&self, p: &Vec3) -> Vec3 {
        self.rotation * p * self.scale + self.translation
    }

    /// As a 4x4 matrix, for points as columns (x, y, z, 1).
    pub fn matrix(&self) -> Matrix4<f64> {
        (self.rotation * self.scale).to_homogeneous().append_translation(&self.translation)
    }

    /// First `inner`, then `self`.
    #[must_use]
    pub fn compose(&self, inner: &Self) -> Self {
        Self {
            scale: self.scale * inner.scale,
            rotation: self.rotation * inner.rotation,
            translation: self.apply(&inner.translation),
        }
    }

    /// The inverse.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let (scale, rotation) = (1.0 / self.scale, self.rotation.transpose());
        Self { scale, rotation, translation: -(rotation * self.translation) * scale }
    }
}

/// The rigid motion that brings `from` closest to `to` in the weighted least-squares sense.
///
/// Weights default to 1. Where points leave the rotation open (one point, points on one line, or no
/// weight at all) it is the smallest of the best ones: one point gives a pure translation, no point
/// the identity. Fails when lengths differ, or for weights below 0 or values that are not finite.
pub fn best_rigid(from: &[Vec3], to: &[Vec3], weights: Option<&[f64]>) -> Result<Rigid> {
    let moments = Moments::new(from, to, weights)?;
    let (rotation, _) = moments.best_rotation();
    Ok(Rigid { rotation, translation: moments.mean_to - rotation * moments.mean_from })
}

/// The similarity that brings `from` closest to `to` in the weighted least-squares sense.
///
/// As [`best_rigid`]; the scale is 1 where it is open (all of `from` in one place) and it fails
/// where the best scale is 0 (all of `to` in one place, or `to` a mirror image without likeness).
pub fn best_similarity(from: &[Vec3], to: &[Vec3], weights: Option<&[f64]>) -> Result<Similarity> {
    let moments = Moments::new(from, to, weights)?;
    let (rotation, agreement) = moments.best_rotation();
    let scale = if moments.spread_from > 0.0 { agreement / moments.spread_from } else { 1.0 };
    if scale <= 0.0 || !scale.is_finite() {
        return Err(Error::invalid(
            "the paired points allow no similarity: the target points lie in one place; check the pairs or fit a rigid motion",
        ));
    }
    let translation = moments.mean_to - rotation * moments.mean_from * scale;
    Ok(Similarity { scale, rotation, translation })
}

/// Weighted first and second moments of the pairs.
struct Moments {
    mean_from: Vec3,
    mean_to: Vec3,
    /// Mean of (to - mean)(from - mean)^T.
    covariance: Mat3,
    /// Mean of |from - mean|^2.
    spread_from: f64,
}

impl Moments {
    fn new(from: &[Vec3], to: &[Vec3], weights: Option<&[f64]>) -> Result<Self> {
        let n = from.len();
        if to.len() != n || weights.is_some_and(|w| w.len() != n) {
            return Err(Error::invalid(format!(
                "a fit needs pairs: {n} points, {} targets, {} weights",
                to.len(),
                weights.map_or(n, <[f64]>::len)
            )));
        }
        let weight = |i: usize| weights.map_or(1.0, |w| w[i]);
        let bad = |i: &usize| {
            let numbers = from[*i].iter().chain(to[*i].iter());
            !(numbers.sum::<f64>().is_finite() && weight(*i) >= 0.0 && weight(*i).is_finite())
        };
        if let Some(i) = (0..n).find(bad) {
            return Err(Error::invalid(format!(
                "pair {i} of a fit has a negative weight or a number that is not finite"
            )));
        }
        let total: f64 = (0..n).map(weight).sum();
        let mean = |value: &dyn Fn(usize) -> Vec3| {
            (0..n).map(|i| value(i) * weight(i)).sum::<Vec3>() / total
        };
        let zero = Self {
            mean_from: Vec3::zeros(),
            mean_to: Vec3::zeros(),
            covariance: Mat3::zeros(),
            spread_from: 0.0,
        };
        if total == 0.0 {
            return Ok(zero);
        }
        let mut moments = Self { mean_from: mean(&|i| from[i]), mean_to: mean(&|i| to[i]), ..zero };
        for i in 0..n {
            let (a, b) = (from[i] - moments.mean_from, to[i] - moments.mean_to);
            moments.covariance += b * a.transpose() * (weight(i) / total);
            moments.spread_from += a.norm_squared() * (weight(i) / total);
        }
        if !(moments.covariance.norm() + moments.spread_from).is_finite() {
            return Err(Error::invalid(
                "the points of a fit lie too far apart to be computed with; check their unit",
            ));
        }
        Ok(moments)
    }

    /// The rotation r of largest tr(r^T covariance), and that largest value.
    fn best_rotation(&self) -> (Mat3, f64) {
        let scale = self.covariance.norm();
        if scale == 0.0 {
            return (Mat3::identity(), 0.0);
        }
        // Horn's s_ab is the transposed covariance; the quaternion is (w, x, y, z).
        let s = self.covariance.transpose() / scale;
        let z = Vec3::new(s.m23 - s.m32, s.m31 - s.m13, s.m12 - s.m21);
        let mut n = Matrix4::zeros();
        n[(0, 0)] = s.trace();
        n.fixed_view_mut::<3, 1>(1, 0).copy_from(&z);
        n.fixed_view_mut::<1, 3>(0, 1).copy_from(&z.transpose());
        let rest = s + s.transpose() - Mat3::identity() * s.trace();
        n.fixed_view_mut::<3, 3>(1, 1).copy_from(&rest);
        let eigen = SymmetricEigen::new(n);
        let largest = eigen.eigenvalues.max();
        let q = nearest_to_identity(&eigen, largest);
        let q = UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]));
        (q.to_rotation_matrix().into_inner(), largest * scale)
    }
}

/// Of all quaternions with the largest eigenvalue the one of the smallest angle.
fn nearest_to_identity(
    eigen: &SymmetricEigen<f64, nalgebra::Const<4>>,
    largest: f64,
) -> Vector4<f64> {
    let open: Vec<usize> =
        (0..4).filter(|&k| eigen.eigenvalues[k] >= largest - SAME_EIGENVALUE).collect();
    let projected: Vector4<f64> =
        open.iter().map(|&k| eigen.eigenvectors.column(k) * eigen.eigenvectors[(0, k)]).sum();
    if projected.norm() > 1e-8 {
        projected
    } else {
        // Half a turn: all the best ones are equally far from the identity.
        eigen.eigenvectors.column(open[0]).into_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::Noise;
    use nalgebra::Rotation3;

    fn cloud(seed: u64) -> Vec<Vec3> {
        let mut noise = Noise::new(seed);
        (0..20).map(|_| noise.vector()).collect()
    }

    fn turned() -> Rigid {
        Rigid {
            rotation: Rotation3::from_euler_angles(0.4, -1.1, 2.3).into_inner(),
            translation: Vec3::new(3.0, -20.0, 0.5),
        }
    }

    #[test]
    fn finds_exact_motions_and_similarities() {
        let from = cloud(1);
        let truth = Similarity { scale: 0.3, ..turned().into() };
        let to: Vec<Vec3> = from.iter().map(|p| turned().apply(p)).collect();
        let found = best_rigid(&from, &to, None).unwrap();
        assert!((found.rotation - turned().rotation).norm() < 1e-13);
        assert!((found.translation - turned().translation).norm() < 1e-13);
        let to: Vec<Vec3> = from.iter().map(|p| truth.apply(p)).collect();
        let found = best_similarity(&from, &to, None).unwrap();
        assert!((found.scale - truth.scale).abs() < 1e-14);
        assert!((found.rotation - truth.rotation).norm() < 1e-13);
    }

    #[test]
    fn weights_drop_outliers_and_no_nearby_motion_is_better() {
        let from = cloud(2);
        let mut noise = Noise::new(5);
        let mut to: Vec<Vec3> =
            from.iter().map(|p| turned().apply(p) + noise.vector() * 0.1).collect();
        to[3] += Vec3::repeat(50.0);
        let mut weights: Vec<f64> = (0..20).map(|i| 1.0 + f64::from(i % 3)).collect();
        weights[3] = 0.0;
        let error = |r: &Rigid| -> f64 {
            (0..20).map(|i| weights[i] * (r.apply(&from[i]) - to[i]).norm_squared()).sum()
        };
        let best = best_rigid(&from, &to, Some(&weights)).unwrap();
        for _ in 0..50 {
            let turn = Rotation3::from_scaled_axis(noise.vector() * 1e-3).into_inner();
            let other = Rigid {
                rotation: turn * best.rotation,
                translation: best.translation + noise.vector() * 1e-3,
            };
            assert!(error(&best) < error(&other));
        }
    }

    #[test]
    fn a_mirror_image_is_never_matched_by_a_reflection() {
        let from = cloud(3);
        let to: Vec<Vec3> = from.iter().map(|p| Vec3::new(-p.x, p.y, p.z)).collect();
        let found = best_rigid(&from, &to, None).unwrap();
        assert!((found.rotation.determinant() - 1.0).abs() < 1e-13);
    }

    #[test]
    fn open_rotations_are_the_smallest() {
        let line: Vec<Vec3> = (0..5).map(|i| Vec3::x() * f64::from(i)).collect();
        let up: Vec<Vec3> = (0..5).map(|i| Vec3::y() * f64::from(i) + Vec3::z()).collect();
        let found = best_rigid(&line, &up, None).unwrap();
        let quarter = Rotation3::from_axis_angle(&Vec3::z_axis(), 0.5 * std::f64::consts::PI);
        assert!((found.rotation - quarter.into_inner()).norm() < 1e-7);
        let one = best_rigid(&line[1..2], &up[1..2], None).unwrap();
        assert_eq!(one.rotation, Mat3::identity());
        assert_eq!(one.apply(&line[1]), up[1]);
        assert_eq!(best_rigid(&[], &[], None).unwrap(), Rigid::identity());
        let back: Vec<Vec3> = line.iter().map(|p| -p).collect();
        let half = best_rigid(&line, &back, None).unwrap();
        assert!((half.apply(&line[4]) - back[4]).norm() < 1e-12);
    }

    #[test]
    fn bad_pairs_are_named() {
        let p = [Vec3::zeros(), Vec3::x()];
        assert!(best_rigid(&p, &p[..1], None).is_err());
        assert!(best_rigid(&p, &p, Some(&[1.0, -1.0])).is_err());
        assert!(best_rigid(&p, &[Vec3::zeros(), Vec3::repeat(f64::NAN)], None).is_err());
        assert!(best_similarity(&p, &[Vec3::x(), Vec3::x()], None).is_err());
    }

    #[test]
    fn composition_and_inverse_undo_each_other() {
        let s = Similarity { scale: 2.5, ..turned().into() };
        let p = Vec3::new(0.3, 0.2, -0.9);
        assert!((s.inverse().compose(&s).apply(&p) - p).norm() < 1e-13);
        assert!((turned().inverse().compose(&turned()).apply(&p) - p).norm() < 1e-13);
        assert!((s.compose(&s).apply(&p) - s.apply(&s.apply(&p))).norm() < 1e-12);
    }

    #[test]
    fn points_too_far_apart_for_their_squares_are_refused() {
        let far = [Vec3::repeat(1e200), Vec3::repeat(-1e200), Vec3::x() * 1e200];
        for fit in
            [best_rigid(&far, &far, None).map(Similarity::from), best_similarity(&far, &far, None)]
        {
            assert!(fit.unwrap_err().to_string().contains("too far apart"));
        }
    }
}
