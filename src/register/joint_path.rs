//! A joint that moves as an angle says: a knee that rolls as it bends, a knee cap in its groove.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use super::rotation::rotation_vector;
use crate::error::{Error, Result};
use crate::math::Vec3;

/// Below this turn between two places of a path, radians, the child goes straight.
const STRAIGHT: f64 = 1e-9;

/// Where the child frame of a joint stands, seen from the parent frame, at values of an angle. Between them
/// it goes by screws, and beyond them on with the first or the last one.
#[derive(Clone, Debug, PartialEq)]
pub struct JointPath {
    leader: String,
    angles: Vec<f64>,
    places: Vec<Isometry3<f64>>,
}

impl JointPath {
    /// A path of at least two `places` at rising values, radians, of the angle named `leader`.
    pub fn new(leader: String, stations: Vec<(f64, Isometry3<f64>)>) -> Result<Self> {
        let (angles, places): (Vec<f64>, Vec<Isometry3<f64>>) = stations.into_iter().unzip();
        let finite = |place: &Isometry3<f64>| place.to_homogeneous().iter().all(|x| x.is_finite());
        if angles.len() < 2
            || !angles.iter().all(|a| a.is_finite())
            || angles.windows(2).any(|pair| pair[0] >= pair[1])
            || !places.iter().all(finite)
        {
            return Err(Error::invalid(format!(
                "a path needs at least two places, at rising values of the angle {leader}"
            )));
        }
        Ok(Self { leader, angles, places })
    }

    /// The name of the angle that leads.
    pub fn leader(&self) -> &str {
        &self.leader
    }

    /// Values of the angle, and the places.
    pub fn stations(&self) -> impl Iterator<Item = (f64, &Isometry3<f64>)> {
        self.angles.iter().copied().zip(&self.places)
    }

    /// The place at a value of the angle.
    pub fn at(&self, angle: f64) -> Isometry3<f64> {
        let last = self.angles.len() - 2;
        let k = self.angles.partition_point(|a| *a <= angle).saturating_sub(1).min(last);
        let share = (angle - self.angles[k]) / (self.angles[k + 1] - self.angles[k]);
        let step = self.places[k].inv_mul(&self.places[k + 1]);
        self.places[k] * part_of_screw(&step, share)
    }

    /// How a child that stands at `present` goes when the angle goes from `now` to `next`.
    pub fn led(&self, present: &Isometry3<f64>, now: f64, next: f64) -> Isometry3<f64> {
        self.at(next) * self.at(now).inverse() * present
    }

    /// Makes the way longer, for a parent that is larger.
    pub(super) fn scale(&mut self, factor: f64) {
        for place in &mut self.places {
            place.translation.vector *= factor;
        }
    }
}

/// A share of a rigid motion: of its turn about its axis and its way along it.
fn part_of_screw(motion: &Isometry3<f64>, share: f64) -> Isometry3<f64> {
    let way = motion.translation.vector;
    let turn = rotation_vector(&motion.rotation);
    let angle = turn.norm();
    let rotation = UnitQuaternion::from_scaled_axis(share * turn);
    if angle < STRAIGHT {
        return Isometry3::from_parts(Translation3::from(share * way), rotation);
    }
    let axis = turn / angle;
    let along = axis * axis.dot(&way);
    let across = way - along;
    // A point of the axis: across = (1 - R) point.
    let point: Vec3 = (across + axis.cross(&across) / libm::tan(angle / 2.0)) / 2.0;
    Isometry3::from_parts(Translation3::from(share * along + point - rotation * point), rotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn far(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
        let between = a.inv_mul(b);
        between.translation.vector.norm() + between.rotation.angle()
    }

    #[test]
    fn two_places_are_a_screw_that_goes_on() {
        let axis = UnitQuaternion::from_scaled_axis(Vec3::new(0.6, -0.8, 0.3));
        let point = Vec3::new(3.0, 1.0, -2.0);
        let along = axis.axis().unwrap();
        let screw = |angle: f64| {
            let turn = UnitQuaternion::from_axis_angle(&along, angle);
            let shift = point - turn * point + along.into_inner() * (0.4 * angle);
            Isometry3::from_parts(shift.into(), turn)
        };
        let start = Isometry3::new(Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.3, 0.2, -0.9));
        let stations = [0.2, 1.9].map(|a| (a, screw(a) * start));
        let path = JointPath::new("bend".into(), stations.to_vec()).unwrap();
        for angle in [-1.0, 0.2, 0.7, 1.9, 3.0] {
            assert!(far(&path.at(angle), &(screw(angle) * start)) < 1e-12, "{angle}");
        }
        // A child that does not stand on the path goes beside it.
        let beside = screw(0.5) * Isometry3::translation(0.0, 0.1, 0.0);
        let led = path.led(&beside, 0.5, 1.5);
        assert!(far(&led, &(screw(1.0) * beside)) < 1e-12);
        let straight = [(0.0, Isometry3::identity()), (2.0, Isometry3::translation(4.0, 0.0, 0.0))];
        let path = JointPath::new("slide".into(), straight.to_vec()).unwrap();
        assert!(far(&path.at(3.0), &Isometry3::translation(6.0, 0.0, 0.0)) < 1e-12);
    }

    #[test]
    fn many_places_come_near_a_curve_as_their_steps_squared() {
        let curve = |a: f64| {
            Isometry3::new(Vec3::new(libm::sin(a), a * a, 0.3), Vec3::new(0.2 * a * a, 0.0, a))
        };
        let error = |steps: u32| {
            let stations = (0..=steps).map(|k| f64::from(k) * 2.0 / f64::from(steps));
            let path = JointPath::new("a".into(), stations.map(|a| (a, curve(a))).collect());
            let path = path.unwrap();
            let tried = (0..200).map(|k| f64::from(k) / 100.0);
            tried.map(|a| far(&path.at(a), &curve(a))).fold(0.0, f64::max)
        };
        let [coarse, fine] = [16, 32].map(error);
        assert!((3.5..4.5).contains(&(coarse / fine)), "{coarse} {fine}");
    }

    #[test]
    fn paths_that_do_not_rise_are_refused() {
        let place = Isometry3::identity();
        for angles in [vec![0.0], vec![1.0, 1.0], vec![0.0, f64::NAN]] {
            let stations = angles.into_iter().map(|a| (a, place)).collect();
            assert!(JointPath::new("a".into(), stations).is_err());
        }
    }
}
