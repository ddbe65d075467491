//! Landmarks: places of bones that are known on the person.
//!
//! They lay the template on the target, and then stay as data beside its surface: a landmark counts as
//! much as the surface of one cluster around it. So it carries whole bones at first, less and less of
//! them later, and once each bone has found its place the surface alone says where it is: a landmark that
//! is some millimetres off does not dent it.

use std::f64::consts::PI;

use nalgebra::{Isometry3, SymmetricEigen};

use super::areas::vertex_areas;
use super::pairs::{Pair, Side};
use super::pose::{BoneMoments, moved};
use super::rotation::PairSums;
use super::skeleton::Skeleton;
use crate::error::{Error, Result};
use crate::locate::ClosestPoints;
use crate::math::Vec3;

/// A landmark further from its bone than this share of the bone's size is a mistake.
const OFF_BONE: f64 = 0.1;
/// Landmarks lay the template on the target when they spread so far to two sides, root mean square, as a
/// share of the template's diagonal.
const SPREAD: f64 = 0.03;

/// A place of a bone that is known on the person.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmark {
    /// Index of the bone.
    pub bone: usize,
    /// Where it is on the template, in its pose; on the bone's surface.
    pub place: Vec3,
    /// Where it is on the person.
    pub target: Vec3,
    /// Against others; 1 counts as much as the surface around it.
    pub weight: f64,
}

/// A landmark as a place of the template's surface.
#[derive(Clone, Debug)]
pub(super) struct PlacedLandmark {
    pub(super) bone: usize,
    vertices: [u32; 3],
    shares: [f64; 3],
    pub(super) target: Vec3,
    pub(super) weight: f64,
    /// Of its bone.
    area: f64,
}

impl Landmark {
    /// Whether it is on its bone, and its numbers are numbers. The error's sentence goes on after the
    /// landmark's name.
    pub fn check(&self, skeleton: &Skeleton) -> Result<()> {
        PlacedLandmark::new(skeleton, self).map(|_| ())
    }
}

impl PlacedLandmark {
    pub(super) fn new(skeleton: &Skeleton, landmark: &Landmark) -> Result<Self> {
        let bone = skeleton.bones.get(landmark.bone).ok_or_else(|| {
            let count = skeleton.bones.len();
            Error::invalid(format!("is on bone {}; the skeleton has {count}", landmark.bone))
        })?;
        let numbers = landmark.place.iter().chain(&landmark.target);
        if !numbers.chain([&landmark.weight]).all(|x| x.is_finite()) || landmark.weight < 0.0 {
            return Err(Error::invalid(
                "needs coordinates that are numbers, and a weight from 0 up",
            ));
        }
        let surface = skeleton.bone_surface(landmark.bone, &skeleton.points);
        let found =
            ClosestPoints::new(&surface.points, &surface.triangles).closest(&landmark.place);
        let distance = found.as_ref().map_or(f64::INFINITY, |found| found.distance);
        let Some(found) = found.filter(|_| distance <= OFF_BONE * surface.diagonal()) else {
            return Err(Error::invalid(format!(
                "lies {distance:.3} from the surface of its bone, {}; it must be a place on that bone of the template",
                bone.name
            )));
        };
        let first = bone.vertices.start as u32;
        Ok(Self {
            bone: landmark.bone,
            vertices: surface.triangles[found.triangle as usize].map(|v| v + first),
            shares: found.barycentric,
            target: landmark.target,
            weight: landmark.weight,
            area: vertex_areas(&surface.points, &surface.triangles).iter().sum(),
        })
    }

    /// Where it is on the template whose vertices are at `points`.
    pub(super) fn place(&self, points: &[Vec3]) -> Vec3 {
        let corners = self.vertices.iter().zip(self.shares);
        corners.map(|(&v, share)| points[v as usize] * share).sum()
    }

    /// Its distance from where it should be.
    pub(super) fn distance(&self, points: &[Vec3]) -> f64 {
        (self.target - self.place(points)).norm()
    }

    /// As a pair that counts as much as the surface of a cluster of `radius`.
    pub(super) fn pair(&self, points: &[Vec3], radius: f64) -> Pair {
        Pair {
            vertices: self.vertices,
            shares: self.shares,
            area: self.weight * self.area.min(PI * radius * radius),
            pull: self.target - self.place(points),
            cosine: 1.0,
            side: Side::Landmark,
        }
    }

    /// The same on the mirrored person.
    pub(super) fn mirrored(&self) -> Self {
        let target = Vec3::new(-self.target.x, self.target.y, self.target.z);
        Self { target, ..self.clone() }
    }
}

/// The rigid motion that carries `points` nearest to the landmarks; none where they do not tell it.
pub(super) fn rigid_motion(
    landmarks: &[PlacedLandmark],
    points: &[Vec3],
    diagonal: f64,
) -> Option<Isometry3<f64>> {
    if landmarks.len() < 3 {
        return None;
    }
    let places: Vec<Vec3> = landmarks.iter().map(|l| l.place(points)).collect();
    let moments = BoneMoments::new(&places, &vec![1.0; places.len()]);
    let mut sizes = SymmetricEigen::new(moments.spread / moments.mass).eigenvalues;
    sizes.as_mut_slice().sort_by(f64::total_cmp);
    if sizes[1] <= (SPREAD * diagonal).powi(2) {
        return None;
    }
    let mut sums = PairSums::new(moments.centre);
    for (landmark, place) in landmarks.iter().zip(&places) {
        sums.add(place, &landmark.target, landmark.weight);
    }
    sums.best_rigid()
}

/// Root mean square distance from the landmarks after a motion.
pub(super) fn rms_after(
    landmarks: &[PlacedLandmark],
    points: &[Vec3],
    motion: &Isometry3<f64>,
) -> f64 {
    let squares =
        landmarks.iter().map(|l| (moved(motion, &l.place(points)) - l.target).norm_squared());
    (squares.sum::<f64>() / landmarks.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;
    use crate::register::joint_limits::JointLimits;
    use crate::register::options::Options;
    use crate::register::register;
    use crate::register::rotation::turned_about;
    use crate::register::skeleton::tests::{block, joint_at};
    use crate::register::target::Target;
    use crate::run::Run;

    /// Two blocks with a hinge, and their corners.
    fn two_bones() -> (Skeleton, Vec<Landmark>) {
        let limits = JointLimits::new(Vec3::repeat(0.1), Vec3::new(0.1, 0.1, 1.2), 0.5).unwrap();
        let a = block(Vec3::zeros(), Vec3::new(10.0, 2.0, 3.0), 10);
        let b = block(Vec3::new(18.0, 0.0, 0.0), Vec3::new(7.0, 1.5, 2.5), 10);
        let joint = joint_at("ab", [0, 1], Vec3::new(10.5, 0.0, 0.0), limits);
        let skeleton = Skeleton::new(vec![("a".into(), a), ("b".into(), b)], vec![joint]).unwrap();
        let corner =
            |bone: usize, place: Vec3| Landmark { bone, place, target: place, weight: 1.0 };
        let landmarks = vec![
            corner(0, Vec3::new(-10.0, 2.0, 3.0)),
            corner(0, Vec3::new(-10.0, -2.0, 3.0)),
            corner(0, Vec3::new(10.0, 2.0, -3.0)),
            corner(1, Vec3::new(25.0, 1.5, 2.5)),
        ];
        (skeleton, landmarks)
    }

    #[test]
    fn landmarks_tell_apart_the_ways_to_lie_on_a_target() {
        let (template, mut landmarks) = two_bones();
        let away = Isometry3::new(Vec3::new(40.0, -20.0, 5.0), Vec3::new(0.5, 1.0, 2.5));
        let turn = UnitQuaternion::from_scaled_axis(Vec3::new(0.0, 0.0, 0.9));
        let bend = turned_about(&Isometry3::identity(), &Vec3::new(10.5, 0.0, 0.0), turn);
        let truth = [away, away * bend];
        let mut person = template.clone();
        person.move_bones(&truth);
        for landmark in &mut landmarks {
            landmark.target = moved(&truth[landmark.bone], &landmark.place);
        }
        let surface =
            crate::mesh::TriMesh::new(person.points.clone(), person.triangles.clone()).unwrap();
        let target = Target::whole(surface).unwrap();
        let off = |target: &Target| {
            let found = register(&template, target, &Options::default(), &Run::new()).unwrap();
            let moves =
                found.skeleton.points.iter().zip(&person.points).map(|(p, q)| (p - q).norm());
            (moves.fold(0.0, f64::max), found)
        };
        let with = target.with_landmarks(&template, &landmarks).unwrap();
        let (worst, found) = off(&with);
        assert!(worst < 0.1, "{worst}");
        assert!(found.landmarks.len() == 4 && found.landmarks.iter().all(|d| *d < 0.1));
        // Landmarks that say something else than the surface are named.
        landmarks[3].target += Vec3::new(0.0, 0.0, 6.0);
        let (_, found) = off(&with.with_landmarks(&template, &landmarks).unwrap());
        let reasons = found.bones[1].reasons.join(" ");
        assert!(reasons.contains("its landmark is"), "{reasons} {:?}", found.landmarks);
    }

    #[test]
    fn landmarks_that_cannot_be_are_refused() {
        let (template, landmarks) = two_bones();
        let wrong = |change: &dyn Fn(&mut Landmark)| {
            let mut landmark = landmarks[0].clone();
            change(&mut landmark);
            landmark.check(&template).unwrap_err().to_string()
        };
        assert!(landmarks[0].check(&template).is_ok());
        assert_eq!(wrong(&|l| l.bone = 2), "is on bone 2; the skeleton has 2");
        assert!(
            wrong(&|l| l.place.x = -20.0)
                .starts_with("lies 10.000 from the surface of its bone, a")
        );
        assert!(wrong(&|l| l.weight = -1.0).contains("a weight from 0 up"));
        assert!(wrong(&|l| l.target.y = f64::NAN).contains("coordinates that are numbers"));
    }
}
