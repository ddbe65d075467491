//! The springs that a skeleton hangs on, each with how the bones' motions and their common size change it.

use nalgebra::{Isometry3, Matrix3x6};

use super::pose::moved;
use super::pose_rows::{Twist, bent, carried, twisted};
use super::rotation::rotation_vector;
use super::skeleton::{Joint, Skeleton};
use crate::math::Vec3;

/// Distance of the two sides of a joint that counts as much as a joint turned by its whole range, as a
/// share of the template's diagonal.
const JOINT_GAP: f64 = 0.0005;
/// Ranges are taken as at least and at most so wide, radians.
const RANGES: [f64; 2] = [0.05, 1.5];

/// Where bones are carried: each is made larger about its own centre, then moved.
#[derive(Clone)]
pub(super) struct Posed {
    pub(super) motions: Vec<Isometry3<f64>>,
    pub(super) size: f64,
    pub(super) centres: Vec<Vec3>,
}

impl Posed {
    fn at(&self, bone: usize, place: &Vec3) -> Vec3 {
        let centre = &self.centres[bone];
        moved(&self.motions[bone], &(centre + self.size * (place - centre)))
    }

    fn centre(&self, bone: usize) -> Vec3 {
        moved(&self.motions[bone], &self.centres[bone])
    }

    /// Carries the skeleton there.
    pub(super) fn carry(&self, skeleton: &mut Skeleton) {
        skeleton.scale_bones(&self.centres, self.size);
        skeleton.move_bones(&self.motions);
    }

    /// A share of a step: the bones' twists, and last the logarithm of the size.
    pub(super) fn stepped(&self, step: &[f64], share: f64) -> Self {
        let (twists, size) = step.split_at(6 * self.centres.len());
        let bones = self.motions.iter().zip(&self.centres).zip(twists.chunks(6));
        let motions = bones.map(|((motion, centre), step)| {
            twisted(motion, centre, &(Twist::from_column_slice(step) * share))
        });
        let size = self.size * libm::exp(size[0] * share);
        Self { motions: motions.collect(), size, centres: self.centres.clone() }
    }
}

/// A place of a bone that is drawn to where the data have it.
pub(super) struct Pull {
    pub(super) bone: usize,
    /// On the skeleton, before all motions.
    pub(super) place: Vec3,
    pub(super) goal: Vec3,
    /// Of the squared distance; 1 over the square of the distance that counts as much as a joint turned by
    /// its whole range.
    pub(super) weight: f64,
}

/// Three springs: their elongations, weights, and how the bones' twists (shift, and turn about the
/// bone's centre) change them.
pub(super) struct Springs {
    pub(super) bones: [usize; 2],
    pub(super) parts: [Matrix3x6<f64>; 2],
    /// How the logarithm of the size changes them.
    pub(super) by_size: Vec3,
    pub(super) elongation: Vec3,
    pub(super) weights: Vec3,
}

/// The rotation vectors of all joints.
pub(super) fn joint_turns(skeleton: &Skeleton) -> Vec<Vec3> {
    let still = Isometry3::identity();
    let turn = |joint: &Joint| rotation_vector(&joint.transform(&still, &still).rotation);
    skeleton.joints.iter().map(turn).collect()
}

impl Springs {
    /// A place of a bone comes to where the data have it.
    pub(super) fn pull(pull: &Pull, pose: &Posed) -> Self {
        let at = pose.at(pull.bone, &pull.place);
        let centre = pose.centre(pull.bone);
        Self {
            bones: [pull.bone, pull.bone],
            parts: [carried(&at, &centre), Matrix3x6::zeros()],
            by_size: at - centre,
            elongation: at - pull.goal,
            weights: Vec3::repeat(pull.weight),
        }
    }

    /// The two sides of a joint come to the same place.
    pub(super) fn gap(joint: &Joint, diagonal: f64, pose: &Posed) -> Self {
        let bones = [joint.parent, joint.child];
        let centres = bones.map(|b| pose.centre(b));
        let at_parent = pose.at(joint.parent, &joint.parent_frame.translation.vector);
        let at_child = pose.at(joint.child, &joint.child_frame.translation.vector);
        Self {
            bones,
            parts: [-carried(&at_parent, &centres[0]), carried(&at_child, &centres[1])],
            by_size: (at_child - centres[1]) - (at_parent - centres[0]),
            elongation: at_child - at_parent,
            weights: Vec3::repeat((JOINT_GAP * diagonal).powi(-2)),
        }
    }

    /// A joint turns back to where it is at rest.
    pub(super) fn turn(joint: &Joint, rest: &Vec3, pose: &Posed) -> Self {
        let pose = &pose.motions;
        let transform = joint.transform(&pose[joint.parent], &pose[joint.child]);
        let r = rotation_vector(&transform.rotation);
        let parent = (pose[joint.parent] * joint.parent_frame).rotation;
        let range = joint.limits.half_axes(&(r - rest)).map(|e| e.clamp(RANGES[0], RANGES[1]));
        Self {
            bones: [joint.parent, joint.child],
            parts: bent(&r, &parent),
            by_size: Vec3::zeros(),
            elongation: r - rest,
            weights: range.map(|e| e.powi(-2)),
        }
    }
}
