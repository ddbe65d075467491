//! The pose of a skeleton whose bones hang on springs: near its data with as little bending as possible.
//!
//! Bones hang on each other by stiff springs at their joints, joints are turned back by springs that are
//! as soft as their ranges are wide, and the data pull: a nonlinear least-squares problem in the
//! rigid motions of all bones, solved by Gauss and Newton's method. Bones without data of their own
//! go where those around them take them.

use nalgebra::{Isometry3, Matrix3x6};

use super::pose::moved;
use super::pose_rows::{LONGEST_TURN, Twist, bent, carried, twisted};
use super::rotation::rotation_vector;
use super::skeleton::{Joint, Skeleton};
use crate::error::Result;
use crate::math::{Mat3, Vec3};
use crate::solve::{BlockMatrix, BlockPattern, SymbolicFactor};

/// Distance of the two sides of a joint that counts as much as a joint turned by its whole range, as a
/// share of the template's diagonal.
const JOINT_GAP: f64 = 0.0005;
/// Ranges are taken as at least and at most so wide, radians.
const RANGES: [f64; 2] = [0.05, 1.5];
/// What holds a bone where nothing else does: a shift by so many diagonals, and a turn by so many radians,
/// count as much as a joint turned by its whole range.
const HOLD: [f64; 2] = [5.0, 1000.0];
const MOST_STEPS: usize = 60;
const MOST_HALVINGS: i32 = 8;
/// At rest when a step saves less than this share.
const REST: f64 = 1e-6;

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
struct Springs {
    bones: [usize; 2],
    parts: [Matrix3x6<f64>; 2],
    elongation: Vec3,
    weights: Vec3,
}

/// The springs of a skeleton and its data.
pub(super) struct SpringPose<'a> {
    skeleton: &'a Skeleton,
    diagonal: f64,
    /// The joints' rotation vectors at which their springs are at rest.
    rest: &'a [Vec3],
    pulls: Vec<Pull>,
    centres: Vec<Vec3>,
}

/// The rotation vectors of all joints.
pub(super) fn joint_turns(skeleton: &Skeleton) -> Vec<Vec3> {
    let still = Isometry3::identity();
    let turn = |joint: &Joint| rotation_vector(&joint.transform(&still, &still).rotation);
    skeleton.joints.iter().map(turn).collect()
}

impl<'a> SpringPose<'a> {
    pub(super) fn new(
        skeleton: &'a Skeleton,
        diagonal: f64,
        rest: &'a [Vec3],
        pulls: Vec<Pull>,
    ) -> Self {
        let centre = |range: std::ops::Range<usize>| {
            let count = range.len().max(1) as f64;
            skeleton.points[range].iter().sum::<Vec3>() / count
        };
        let centres = skeleton.bones.iter().map(|b| centre(b.vertices.clone())).collect();
        Self { skeleton, diagonal, rest, pulls, centres }
    }

    /// The motions of all bones.
    pub(super) fn solve(&self) -> Result<Vec<Isometry3<f64>>> {
        let links: Vec<(u32, u32)> =
            self.skeleton.joints.iter().map(|j| (j.parent as u32, j.child as u32)).collect();
        let pattern = BlockPattern::of_links(&self.centres, &links, 6);
        let symbolic = SymbolicFactor::new(&pattern)?;
        let mut pose = vec![Isometry3::identity(); self.centres.len()];
        let mut energy = self.energy(&pose);
        for _ in 0..MOST_STEPS {
            let (mut step, matrix) = self.gradient_and_matrix(&pattern, &pose);
            symbolic.factor(&matrix)?.solve(&mut step);
            let turn =
                step.chunks(6).map(|s| Vec3::new(s[3], s[4], s[5]).norm()).fold(0.0, f64::max);
            let longest = -(LONGEST_TURN / turn).min(1.0);
            let mut tried = (0..=MOST_HALVINGS).map(|halvings| {
                let next = self.stepped(&pose, &step, longest * 0.5_f64.powi(halvings));
                (self.energy(&next), next)
            });
            let Some((after, next)) = tried.find(|(after, _)| *after < energy) else {
                break;
            };
            let before = std::mem::replace(&mut energy, after);
            pose = next;
            if before - after < REST * before {
                break;
            }
        }
        Ok(pose)
    }

    fn stepped(&self, pose: &[Isometry3<f64>], step: &[f64], share: f64) -> Vec<Isometry3<f64>> {
        let bones = pose.iter().zip(&self.centres).zip(step.chunks(6));
        let stepped = bones.map(|((motion, centre), step)| {
            twisted(motion, centre, &(Twist::from_column_slice(step) * share))
        });
        stepped.collect()
    }

    fn energy(&self, pose: &[Isometry3<f64>]) -> f64 {
        let of = |s: &Springs| s.elongation.component_mul(&s.elongation).dot(&s.weights) / 2.0;
        self.springs(pose).iter().map(of).sum()
    }

    /// First derivative of the energy in the bones' twists, and Gauss and Newton's matrix.
    fn gradient_and_matrix(
        &self,
        pattern: &BlockPattern,
        pose: &[Isometry3<f64>],
    ) -> (Vec<f64>, BlockMatrix) {
        let mut gradient = vec![0.0; pattern.size()];
        let mut values = vec![0.0; pattern.row_idx.len()];
        let hold = [HOLD[0] * self.diagonal, HOLD[1]].map(|far| far.powi(-2));
        for b in 0..self.centres.len() as u32 {
            for k in 0..6 {
                values[pattern.entry(b, b, k, k)] += hold[k / 3];
            }
        }
        for springs in self.springs(pose) {
            let weighted = Mat3::from_diagonal(&springs.weights);
            let sides = || springs.bones.iter().zip(&springs.parts);
            for (&b, part) in sides() {
                let pull = part.tr_mul(&(weighted * springs.elongation));
                gradient[6 * b..6 * b + 6].iter_mut().zip(&pull).for_each(|(g, p)| *g += p);
                for (&c, other) in sides().filter(|(c, _)| **c <= b) {
                    let block = part.tr_mul(&(weighted * other));
                    for column in 0..6 {
                        for row in if b == c { column } else { 0 }..6 {
                            values[pattern.entry(b as u32, c as u32, row, column)] +=
                                block[(row, column)];
                        }
                    }
                }
            }
        }
        (gradient, BlockMatrix { values })
    }

    fn springs(&self, pose: &[Isometry3<f64>]) -> Vec<Springs> {
        let mut springs: Vec<Springs> =
            self.pulls.iter().map(|pull| self.pull(pull, pose)).collect();
        for (joint, rest) in self.skeleton.joints.iter().zip(self.rest) {
            springs.push(self.gap(joint, pose));
            springs.push(turn(joint, rest, pose));
        }
        springs
    }

    /// How the point `at` goes with a bone's twist.
    fn carried(&self, bone: usize, at: &Vec3, pose: &[Isometry3<f64>]) -> Matrix3x6<f64> {
        carried(at, &moved(&pose[bone], &self.centres[bone]))
    }

    fn pull(&self, pull: &Pull, pose: &[Isometry3<f64>]) -> Springs {
        let at = moved(&pose[pull.bone], &pull.place);
        Springs {
            bones: [pull.bone, pull.bone],
            parts: [self.carried(pull.bone, &at, pose), Matrix3x6::zeros()],
            elongation: at - pull.goal,
            weights: Vec3::repeat(pull.weight),
        }
    }

    /// The two sides of a joint come to the same place.
    fn gap(&self, joint: &Joint, pose: &[Isometry3<f64>]) -> Springs {
        let (p, c) = (joint.parent, joint.child);
        let at_parent = moved(&pose[p], &joint.parent_frame.translation.vector);
        let at_child = moved(&pose[c], &joint.child_frame.translation.vector);
        Springs {
            bones: [p, c],
            parts: [-self.carried(p, &at_parent, pose), self.carried(c, &at_child, pose)],
            elongation: at_child - at_parent,
            weights: Vec3::repeat((JOINT_GAP * self.diagonal).powi(-2)),
        }
    }
}

/// A joint turns back to where it is at rest.
fn turn(joint: &Joint, rest: &Vec3, pose: &[Isometry3<f64>]) -> Springs {
    let transform = joint.transform(&pose[joint.parent], &pose[joint.child]);
    let r = rotation_vector(&transform.rotation);
    let parent = (pose[joint.parent] * joint.parent_frame).rotation;
    let range = joint.limits.half_axes(&(r - rest)).map(|e| e.clamp(RANGES[0], RANGES[1]));
    Springs {
        bones: [joint.parent, joint.child],
        parts: bent(&r, &parent),
        elongation: r - rest,
        weights: range.map(|e| e.powi(-2)),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;
    use crate::math::derivative_check::order_of_convergence;
    use crate::register::joint_limits::JointLimits;
    use crate::register::rotation::turned_about;
    use crate::register::skeleton::tests::{block, joint_at};

    /// Four blocks in a row, the joint in the middle wide, the others narrow.
    fn chain() -> Skeleton {
        let half = Vec3::new(5.0, 2.0, 1.0);
        let bone = |k: usize| block(Vec3::new(11.0 * k as f64, 0.0, 0.0), half, 3);
        let joint = |k: usize| {
            let range = Vec3::repeat(if k == 1 { 1.2 } else { 0.1 });
            let at = Vec3::new(11.0 * k as f64 + 5.5, 0.0, 0.0);
            let limits = JointLimits::new(range, range, 0.1).unwrap();
            joint_at(&format!("joint {k}"), [k, k + 1], at, limits)
        };
        let bones = (0..4).map(|k| (format!("bone {k}"), bone(k))).collect();
        Skeleton::new(bones, (0..3).map(joint).collect()).unwrap()
    }

    /// Draws two places of the first bone and two of the last to where `motions` carry them.
    fn pulls(skeleton: &Skeleton, motions: &[Isometry3<f64>]) -> Vec<Pull> {
        let pull = |k: usize| {
            let bone = [0, 3][k / 2];
            let range = skeleton.bones[bone].vertices.clone();
            let place = skeleton.points[[range.start, range.end - 1][k % 2]];
            Pull { bone, place, goal: moved(&motions[bone], &place), weight: 25.0 }
        };
        (0..4).map(pull).collect()
    }

    #[test]
    fn the_joint_with_the_widest_range_bends_and_the_bones_between_follow() {
        let skeleton = chain();
        let still = Isometry3::identity();
        let turn = UnitQuaternion::from_scaled_axis(Vec3::new(0.0, 0.0, 0.9));
        let bend = turned_about(&still, &Vec3::new(16.5, 0.0, 0.0), turn);
        let away = Isometry3::new(Vec3::new(3.0, -2.0, 1.0), Vec3::new(0.1, 0.2, -0.1));
        let truth = [away, away, away * bend, away * bend];
        let rest = joint_turns(&skeleton);
        let pulls = pulls(&skeleton, &truth);
        let found = SpringPose::new(&skeleton, 40.0, &rest, pulls).solve().unwrap();
        for (b, bone) in skeleton.bones.iter().enumerate() {
            for p in &skeleton.points[bone.vertices.clone()] {
                let off = (moved(&found[b], p) - moved(&truth[b], p)).norm();
                assert!(off < 0.3, "{b} {off}");
            }
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_energy() {
        let skeleton = chain();
        let motion = |k: usize| {
            let (x, y) = (0.1 * k as f64, 0.2 - 0.07 * k as f64);
            Isometry3::new(Vec3::new(x, y, -x), Vec3::new(y, -x, 0.3 * x))
        };
        let pose: Vec<_> = (0..4).map(motion).collect();
        let pulls = pulls(&skeleton, &[Isometry3::translation(0.5, 0.1, -0.2); 4]);
        let rest = joint_turns(&skeleton);
        let problem = SpringPose::new(&skeleton, 40.0, &rest, pulls);
        let links: Vec<_> = (0..3).map(|k| (k, k + 1)).collect();
        let pattern = BlockPattern::of_links(&problem.centres, &links, 6);
        let (gradient, _) = problem.gradient_and_matrix(&pattern, &pose);
        let direction: Vec<f64> =
            (0..24).map(|k| f64::from((7 * k + 3) % 11) / 11.0 - 0.4).collect();
        let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
        let order = order_of_convergence(|h| {
            let [ahead, back] =
                [h, -h].map(|h| problem.energy(&problem.stepped(&pose, &direction, h)));
            nalgebra::Vector1::new((ahead - back) / (2.0 * h) / slope - 1.0)
        });
        assert!(order > 1.9, "{order}");
    }
}
