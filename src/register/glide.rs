//! The path of a bone that glides on its parent while a third one pulls it: a knee cap on the thigh, held by
//! its tendon to the shin.
//!
//! At each value of the leading angle the bone turns about the leader's axis and moves towards the axis until
//! it is as near to the parent as at first. It turns so far that its tether, the shortest line to the bone
//! that the leader moves, keeps its length.

use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion};

use super::animation::{posed, present_angle};
use super::joint_path::JointPath;
use super::skeleton::Skeleton;
use crate::error::{Error, Result};
use crate::locate::ClosestPoints;
use crate::math::Vec3;
use crate::mesh::diagonal;

/// Radians between the places of the path at most.
const STEP: f64 = 0.1;
/// Vertices of the bone that are kept off the parent.
const VERTICES: usize = 150;
/// Steps towards the parent, and halvings of an angle.
const STEPS: usize = 60;
const HALVINGS: usize = 14;
/// Distances are met to this share of the bone's diagonal.
const PRECISION: f64 = 1e-4;

/// The path of joint `j` whose child glides on its parent, led by the angle named `leader` of another joint
/// with the same parent.
pub fn gliding_path(skeleton: &Skeleton, j: usize, leader: &str) -> Result<JointPath> {
    let glide = Glide::new(skeleton, j, leader)?;
    let [low, high] = glide.range;
    // From where the skeleton stands up to each end, each place from the one before.
    let side = |end: f64| {
        let count = ((end - glide.now).abs() / STEP).ceil();
        let mut lag = 0.0;
        let angles = (1..=count as usize).map(|k| (end - glide.now) * k as f64 / count);
        angles
            .map(|angle| {
                let (place, own_lag) = glide.place(angle, lag)?;
                lag = own_lag;
                Ok((glide.now + angle, place))
            })
            .collect::<Result<Vec<_>>>()
    };
    let mut stations = side(low.min(glide.now))?;
    stations.reverse();
    stations.push((glide.now, glide.joint_place(&Isometry3::identity())));
    stations.extend(side(high.max(glide.now))?);
    JointPath::new(leader.into(), stations)
}

struct Glide<'a> {
    skeleton: &'a Skeleton,
    joint: usize,
    leader: &'a str,
    /// The bone that the leader moves.
    puller: usize,
    /// The leader's range, and its value as the skeleton lies.
    range: [f64; 2],
    now: f64,
    /// The leader's axis.
    centre: Vec3,
    axis: Unit<Vec3>,
    /// Away from the axis, through the middle of the bone.
    outwards: Vec3,
    parent: ClosestPoints,
    vertices: Vec<Vec3>,
    gap: f64,
    size: f64,
    /// Ends of the tether on the bone and on the puller.
    tether: [Vec3; 2],
}

impl<'a> Glide<'a> {
    fn new(skeleton: &'a Skeleton, j: usize, leader: &'a str) -> Result<Self> {
        let joint = &skeleton.joints[j];
        let others = skeleton.joints.iter().filter(|other| other.parent == joint.parent);
        let (leading, coordinate) = others
            .flat_map(|joint| joint.coordinates.iter().map(move |c| (joint, c)))
            .find(|(other, c)| c.name == leader && other.child != joint.child)
            .ok_or_else(|| {
                Error::invalid(format!(
                    "it glides as {leader} says, but that is no angle between its parent and another bone"
                ))
            })?;
        let centre = leading.parent_frame.translation.vector;
        let axis = Unit::new_normalize(leading.parent_frame * coordinate.axis);
        let surface = |b: usize| {
            let bone = skeleton.bone_surface(b, &skeleton.points);
            ClosestPoints::new(&bone.points, &bone.triangles)
        };
        let points = &skeleton.points[skeleton.bones[joint.child].vertices.clone()];
        let every = points.len().div_ceil(VERTICES).max(1);
        let vertices: Vec<Vec3> = points.iter().copied().step_by(every).collect();
        let middle = points.iter().sum::<Vec3>() / points.len() as f64 - centre;
        let outwards = (middle - axis.dot(&middle) * axis.into_inner()).try_normalize(1e-9);
        let outwards =
            outwards.ok_or_else(|| Error::invalid("it lies on the axis that leads it"))?;
        let puller = surface(leading.child);
        let ends = vertices.iter().filter_map(|p| Some((*p, puller.closest(p)?)));
        let (from, to) = ends
            .min_by(|a, b| a.1.distance.total_cmp(&b.1.distance))
            .ok_or_else(|| Error::invalid("a bone has no surface to glide on"))?;
        let mut glide = Self {
            skeleton,
            joint: j,
            leader,
            puller: leading.child,
            range: coordinate.range.map(|x| x.clamp(-std::f64::consts::PI, std::f64::consts::PI)),
            now: present_angle(skeleton, leader).unwrap_or_default(),
            centre,
            axis,
            outwards,
            parent: surface(joint.parent),
            vertices,
            gap: 0.0,
            size: diagonal(points),
            tether: [from, to.position],
        };
        glide.gap = glide.distance(&Isometry3::identity());
        Ok(glide)
    }

    /// The place on the joint's path at a turn of the leader from where it is now, and how far the bone's own
    /// turn lags behind; `lag`: of the place before.
    fn place(&self, angle: f64, lag: f64) -> Result<(Isometry3<f64>, f64)> {
        let leader = |name: &str| (name == self.leader).then_some(self.now + angle);
        let parent = self.skeleton.joints[self.joint].parent;
        let pulled = posed(self.skeleton, parent, leader)[self.puller];
        let end = pulled * Point3::from(self.tether[1]);
        let [start, tether] = [self.tether[0], self.tether[0] - self.tether[1]];
        // Whether the bone comes away from the puller where it stays behind a positive turn.
        let side = -tether.dot(&self.axis.cross(&(start - self.centre))).signum();
        // Above 0 where it lags too much.
        let stretch = |lag: f64| {
            let motion = self.in_contact(angle - lag)?;
            Ok::<_, Error>(side * ((motion * Point3::from(start) - end).norm() - tether.norm()))
        };
        let (mut low, mut high) = (lag - STEP, lag + STEP);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(low, high);
            *(if stretch(middle)? > 0.0 { &mut high } else { &mut low }) = middle;
        }
        let lag = f64::midpoint(low, high);
        Ok((self.joint_place(&self.in_contact(angle - lag)?), lag))
    }

    /// The motion of the bone that turns it and brings it as near to the parent as it was, from outside.
    fn in_contact(&self, turn: f64) -> Result<Isometry3<f64>> {
        let rotation = UnitQuaternion::from_axis_angle(&self.axis, turn);
        let about = self.centre - rotation * self.centre;
        let outwards = rotation * self.outwards;
        let at =
            |out: f64| Isometry3::from_parts(Translation3::from(about + out * outwards), rotation);
        let mut out = 2.0 * self.size;
        for _ in 0..STEPS {
            // No vertex comes nearer than it moves, so this never goes too far.
            let more = self.distance(&at(out)) - self.gap;
            out -= more;
            if more < PRECISION * self.size {
                return Ok(at(out));
            }
        }
        Err(Error::invalid(format!(
            "turned by {:.0} degrees it does not meet its parent",
            turn.to_degrees()
        )))
    }

    fn distance(&self, motion: &Isometry3<f64>) -> f64 {
        let moved = self.vertices.iter().map(|p| (motion * Point3::from(*p)).coords);
        let distances = moved.filter_map(|p| self.parent.closest(&p)).map(|hit| hit.distance);
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Where the child's frame is then, seen from the parent's.
    fn joint_place(&self, motion: &Isometry3<f64>) -> Isometry3<f64> {
        self.skeleton.joints[self.joint].transform(&Isometry3::identity(), motion)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::sphere;
    use crate::mesh::TriMesh;
    use crate::register::joint_limits::JointLimits;
    use crate::register::skeleton::Coordinate;
    use crate::register::skeleton::tests::{block, joint_at};

    /// A ball with a block below it that turns about the ball's middle, and a small one at its side.
    fn knee() -> Skeleton {
        let free = Vec3::repeat(f64::INFINITY);
        let limits = JointLimits::new(free, free, 1.0).unwrap();
        let (points, triangles) = sphere(24, 48);
        let ball = TriMesh { points: points.iter().map(|p| p * 10.0).collect(), triangles };
        let shin = block(Vec3::new(0.0, 0.0, -18.0), Vec3::new(6.0, 3.0, 6.0), 12);
        let cap = block(Vec3::new(12.0, 0.0, 0.0), Vec3::new(1.0, 2.0, 2.0), 4);
        let bones = [("thigh", ball), ("shin", shin), ("cap", cap)];
        let mut knee = joint_at("knee", [0, 1], Vec3::zeros(), limits);
        knee.coordinates =
            vec![Coordinate { name: "bend".into(), axis: Vec3::y(), range: [-0.5, 2.0] }];
        let groove = joint_at("groove", [0, 2], Vec3::new(12.0, 0.0, 0.0), limits);
        let bones = bones.map(|(name, mesh)| (name.to_string(), mesh)).to_vec();
        Skeleton::new(bones, vec![knee, groove]).unwrap()
    }

    #[test]
    fn a_cap_goes_round_a_ball_with_the_bone_that_pulls_it() {
        let skeleton = knee();
        let path = gliding_path(&skeleton, 1, "bend").unwrap();
        let start = path.at(0.0);
        assert!(start.translation.vector.norm() < 1e-12 && start.rotation.angle() < 1e-12);
        let frame = skeleton.joints[1].parent_frame;
        for angle in [-0.5, -0.2, 0.3, 1.0, 1.7, 2.0] {
            let motion = frame * path.at(angle) * frame.inverse();
            // Around a ball everything turns as one.
            let turned = UnitQuaternion::from_axis_angle(&Vec3::y_axis(), angle);
            let off = motion * Point3::new(12.0, 0.0, 0.0) - turned * Point3::new(12.0, 0.0, 0.0);
            assert!(off.norm() < 0.2, "{angle}: {off}");
            assert!(motion.rotation.angle_to(&turned).to_degrees() < 1.0, "{angle}");
        }
    }

    #[test]
    fn what_cannot_glide_is_said() {
        let mut skeleton = knee();
        let said =
            |skeleton: &Skeleton, j| gliding_path(skeleton, j, "bend").unwrap_err().to_string();
        assert!(said(&skeleton, 0).contains("no angle between its parent and another bone"));
        skeleton.points.iter_mut().skip(skeleton.bones[2].vertices.start).for_each(|p| p.x -= 12.0);
        assert!(said(&skeleton, 1).contains("on the axis"));
    }
}
