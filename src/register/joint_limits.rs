//! Limits of a joint: an asymmetric ellipsoid of rotation vectors and a largest shift.
//!
//! [G] section 3.4. The rotation vector r of a joint is admissible inside the ellipsoid whose half
//! axes are the six one-sided maxima, chosen per octant by the signs of r.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::math::Vec3;

/// Newton steps at most; F is convex and falling, so about ten are needed.
const MAX_NEWTON_STEPS: usize = 60;

/// How far a joint may go from its neutral position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointLimits {
    /// Largest rotation in the negative sense about x, y, z of the joint frame; radians, >= 0,
    /// infinite = free.
    pub negative: Vec3,
    /// Largest rotation in the positive sense; radians, >= 0, infinite = free.
    pub positive: Vec3,
    /// Largest distance between the two joint points; the template's unit, >= 0.
    pub shift: f64,
    /// What they are to a registration; none: what its options say.
    pub rule: Option<Limits>,
}

/// What the joints' limits are to a registration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum Limits {
    /// Knowledge: where the data insist, a joint turns up to 10 degrees further.
    #[default]
    Soft,
    /// Walls where the skeleton says.
    Hard,
    /// Joints turn freely; the bones still hang together.
    None,
}

impl Limits {
    const ALL: [Self; 3] = [Self::Soft, Self::Hard, Self::None];

    /// Its name: soft, hard, none.
    pub fn name(self) -> &'static str {
        match self {
            Self::Soft => "soft",
            Self::Hard => "hard",
            Self::None => "none",
        }
    }

    /// The one of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|limits| limits.name() == name)
    }
}

impl JointLimits {
    /// Rotations may go further by so many radians on every side, and the shift by so much.
    pub(super) fn widened(&self, turn: f64, shift: f64) -> Self {
        let [negative, positive] = [self.negative, self.positive].map(|side| side.add_scalar(turn));
        Self { negative, positive, shift: self.shift + shift, ..*self }
    }

    /// Limits from radians and the template's unit; negative or undefined numbers are an error.
    pub fn new(negative: Vec3, positive: Vec3, shift: f64) -> Result<Self> {
        let valid = |x: f64| x >= 0.0;
        if !negative.iter().chain(positive.iter()).all(|&x| valid(x)) || !valid(shift) {
            return Err(Error::invalid(
                "joint limits must be numbers from 0 upwards: give the size of the range on each side",
            ));
        }
        Ok(Self { negative, positive, shift, rule: None })
    }

    /// Half axes of the octant that `r` lies in.
    pub(super) fn half_axes(&self, r: &Vec3) -> Vec3 {
        Vec3::from_fn(|k, _| if r[k] < 0.0 { self.negative[k] } else { self.positive[k] })
    }

    /// Share of the ellipsoid used by `r`: 1 on its surface, infinite for a turn about an axis
    /// without freedom.
    pub fn usage(&self, r: &Vec3) -> f64 {
        let e = self.half_axes(r);
        let squares: f64 = (0..3)
            .filter(|&k| r[k] != 0.0 && e[k].is_finite())
            .map(|k| if e[k] > 0.0 { (r[k] / e[k]).powi(2) } else { f64::INFINITY })
            .sum();
        squares.sqrt()
    }

    /// Angle in radians by which the rotation vector `r` lies outside; 0 inside.
    pub fn excess(&self, r: &Vec3) -> f64 {
        (self.closest(r) - r).norm().min((self.closest(&equivalent(r)) - equivalent(r)).norm())
    }

    /// The admissible rotation vector nearest to `r` or to its equivalent r - 2 pi r/|r|.
    ///
    /// The paper prints -(pi + theta) u for the equivalent, which is another rotation.
    pub fn nearest_admissible(&self, r: &Vec3) -> Vec3 {
        self.closest(&self.nearer_vector(r))
    }

    /// Of `r` and its equivalent the one that lies nearer to the ellipsoid.
    pub(super) fn nearer_vector(&self, r: &Vec3) -> Vec3 {
        let other = equivalent(r);
        let far = |v: &Vec3| (self.closest(v) - v).norm();
        if far(&other) < far(r) { other } else { *r }
    }

    /// Closest point of the solid ellipsoid to `r`.
    fn closest(&self, r: &Vec3) -> Vec3 {
        let e = self.half_axes(r);
        // Axes without freedom are clamped first: the Newton iteration divides by e^2.
        let y = Vec3::from_fn(|k, _| if e[k] > 0.0 { r[k].abs() } else { 0.0 });
        let bounded = |k: usize| e[k] > 0.0 && e[k].is_finite();
        let level = |t: f64| -> (f64, f64) {
            let (mut value, mut slope) = (-1.0, 0.0);
            for k in (0..3).filter(|&k| bounded(k)) {
                let denominator = t + e[k] * e[k];
                let ratio = e[k] * y[k] / denominator;
                value += ratio * ratio;
                slope -= 2.0 * ratio * ratio / denominator;
            }
            (value, slope)
        };
        let mut t = 0.0;
        for _ in 0..MAX_NEWTON_STEPS {
            let (value, slope) = level(t);
            if value <= 1e-14 || slope == 0.0 {
                break;
            }
            t -= value / slope;
        }
        Vec3::from_fn(|k, _| {
            let size = if bounded(k) { e[k] * e[k] * y[k] / (t + e[k] * e[k]) } else { y[k] };
            size.copysign(r[k])
        })
    }
}

/// The other rotation vector of the same rotation: (theta - 2 pi) u.
fn equivalent(r: &Vec3) -> Vec3 {
    let angle = r.norm();
    if angle < 1e-12 { *r } else { r * ((angle - TAU) / angle) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn degrees(negative: [f64; 3], positive: [f64; 3]) -> JointLimits {
        let radians = |v: [f64; 3]| Vec3::from(v).map(f64::to_radians);
        JointLimits::new(radians(negative), radians(positive), 1.0).unwrap()
    }

    #[test]
    fn the_closest_point_agrees_with_brute_force() {
        let limits = degrees([20.0, 10.0, 5.0], [120.0, 10.0, 5.0]);
        let mut seed = 7_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        for _ in 0..20 {
            let r = Vec3::new(random() * 4.0, random(), random());
            let found = limits.closest(&r);
            if limits.usage(&r) <= 1.0 {
                assert!((found - r).norm() < 1e-12);
                continue;
            }
            assert!((limits.usage(&found) - 1.0).abs() < 1e-6);
            // A fine net of the whole ellipsoid's surface has no point clearly nearer.
            let mut best = f64::INFINITY;
            for i in 0..=400 {
                for j in 0..800 {
                    let (polar, azimuth) =
                        (f64::from(i) * 0.5 / 400.0 * TAU, f64::from(j) / 800.0 * TAU);
                    let u = Vec3::new(
                        libm::cos(polar),
                        libm::sin(polar) * libm::cos(azimuth),
                        libm::sin(polar) * libm::sin(azimuth),
                    );
                    best = best.min((limits.half_axes(&u).component_mul(&u) - r).norm());
                }
            }
            assert!((found - r).norm() <= best + 1e-9 && (found - r).norm() > best - 1e-3);
        }
    }

    #[test]
    fn far_over_flexion_returns_on_the_nearer_side() {
        let limits = degrees([20.0, 10.0, 5.0], [120.0, 10.0, 5.0]);
        let r = Vec3::new((-175_f64).to_radians(), 0.0, 0.0);
        assert!((limits.nearest_admissible(&r).x.to_degrees() - 120.0).abs() < 1e-9);
        assert!((limits.excess(&r).to_degrees() - 65.0).abs() < 1e-9);
    }

    #[test]
    fn hinges_clamp_and_free_axes_stay() {
        let hinge = degrees([0.0, 0.0, 0.0], [90.0, 0.0, 0.0]);
        let r = Vec3::new(0.4, 0.1, -0.3);
        assert_eq!(hinge.nearest_admissible(&r), Vec3::new(0.4, 0.0, 0.0));
        assert_eq!(hinge.nearest_admissible(&-r), Vec3::zeros());
        assert!(hinge.usage(&r).is_infinite());
        let free = degrees([0.0, f64::INFINITY, 10.0], [0.0, f64::INFINITY, 10.0]);
        let kept = free.nearest_admissible(&Vec3::new(0.2, 1.5, 0.1));
        assert_eq!(kept, Vec3::new(0.0, 1.5, 0.1));
        assert!(JointLimits::new(Vec3::repeat(-1.0), Vec3::zeros(), 1.0).is_err());
    }
}
