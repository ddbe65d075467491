//! The pose of a skeleton whose bones hang on springs: near its data with as little bending as possible.
//!
//! Bones hang on each other by stiff springs at their joints, joints are turned back by springs that are
//! as soft as their ranges are wide, and the data pull: a nonlinear least-squares problem in the
//! rigid motions of all bones and the size they have in common, solved by Gauss and Newton's method. Bones
//! without data of their own go where those around them take them.

use std::sync::Arc;

use nalgebra::Isometry3;

use super::coupled_bones::CoupledBones;
use super::pose_rows::LONGEST_TURN;
use super::skeleton::Skeleton;
use super::springs::{Posed, Pull, Springs};
use crate::error::Result;
use crate::math::{Mat3, Vec3};
use crate::solve::{BlockMatrix, BlockPattern, SymbolicFactor};

/// What holds a bone where nothing else does: a shift by so many diagonals, and a turn by so many radians,
/// count as much as a joint turned by its whole range.
const HOLD: [f64; 2] = [5.0, 1000.0];
/// Logarithm of a change of size that counts as much as a joint turned by its whole range.
const SIZE: f64 = 0.5;
const MOST_STEPS: usize = 60;
const MOST_HALVINGS: i32 = 8;
/// At rest when a step saves less than this share.
const REST: f64 = 1e-6;

/// Derivatives of the energy: first in the bones' twists, last in the logarithm of the size.
struct Derivatives {
    gradient: Vec<f64>,
    /// Gauss and Newton's matrix of the twists,
    matrix: BlockMatrix,
    /// its column of the size, and its last entry.
    by_size: Vec<f64>,
    by_size_twice: f64,
}

impl Derivatives {
    /// Newton's step, up the slope.
    fn step(mut self, symbolic: &Arc<SymbolicFactor>) -> Result<Vec<f64>> {
        let factor = symbolic.factor(&self.matrix)?;
        let along = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut follow = self.by_size.clone();
        factor.solve(&mut follow);
        let size = self.gradient.pop().unwrap_or(0.0);
        let step_of_size = (size - along(&follow, &self.gradient))
            / (self.by_size_twice - along(&follow, &self.by_size));
        factor.solve(&mut self.gradient);
        self.gradient.iter_mut().zip(&follow).for_each(|(g, f)| *g -= step_of_size * f);
        self.gradient.push(step_of_size);
        Ok(self.gradient)
    }
}

/// The springs of a skeleton and its data.
pub(super) struct SpringPose<'a> {
    skeleton: &'a Skeleton,
    diagonal: f64,
    /// The joints' rotation vectors at which their springs are at rest.
    rest: &'a [Vec3],
    pulls: Vec<Pull>,
    centres: Vec<Vec3>,
    /// Whether the bones may change their size.
    sized: bool,
}

impl<'a> SpringPose<'a> {
    pub(super) fn new(
        skeleton: &'a Skeleton,
        diagonal: f64,
        rest: &'a [Vec3],
        pulls: Vec<Pull>,
        sized: bool,
    ) -> Self {
        let centre = |range: std::ops::Range<usize>| {
            let count = range.len().max(1) as f64;
            skeleton.points[range].iter().sum::<Vec3>() / count
        };
        let centres = skeleton.bones.iter().map(|b| centre(b.vertices.clone())).collect();
        Self { skeleton, diagonal, rest, pulls, centres, sized }
    }

    /// The motions of all bones and their size.
    pub(super) fn solve(&self) -> Result<Posed> {
        let CoupledBones { pattern, symbolic } = CoupledBones::new(&self.centres, self.skeleton)?;
        let mut pose = self.still();
        let mut energy = self.energy(&pose);
        for _ in 0..MOST_STEPS {
            let step = self.derivatives(&pattern, &pose).step(&symbolic)?;
            let turns = step.chunks_exact(6).map(|s| Vec3::new(s[3], s[4], s[5]).norm());
            let turn = turns.fold(step.last().map_or(0.0, |size| size.abs()), f64::max);
            let longest = -(LONGEST_TURN / turn).min(1.0);
            let mut tried = (0..=MOST_HALVINGS).map(|halvings| {
                let next = pose.stepped(&step, longest * 0.5_f64.powi(halvings));
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

    fn still(&self) -> Posed {
        let motions = vec![Isometry3::identity(); self.centres.len()];
        Posed { motions, size: 1.0, centres: self.centres.clone() }
    }

    fn energy(&self, pose: &Posed) -> f64 {
        let of = |s: &Springs| s.elongation.component_mul(&s.elongation).dot(&s.weights) / 2.0;
        let springs: f64 = self.springs(pose).iter().map(of).sum();
        springs + (libm::log(pose.size) / SIZE).powi(2) / 2.0
    }

    fn derivatives(&self, pattern: &BlockPattern, pose: &Posed) -> Derivatives {
        let mut gradient = vec![0.0; pattern.size() + 1];
        let mut matrix = BlockMatrix { values: vec![0.0; pattern.row_idx.len()] };
        let mut by_size = vec![0.0; pattern.size()];
        let mut by_size_twice = SIZE.powi(-2);
        gradient[pattern.size()] = libm::log(pose.size) / SIZE.powi(2);
        let hold = [HOLD[0] * self.diagonal, HOLD[1]].map(|far| far.powi(-2));
        for b in 0..self.centres.len() as u32 {
            for k in 0..6 {
                matrix.values[pattern.entry(b, b, k, k)] += hold[k / 3];
            }
        }
        for springs in self.springs(pose) {
            let weighted = Mat3::from_diagonal(&springs.weights);
            let sides = || springs.bones.iter().zip(&springs.parts);
            gradient[pattern.size()] += springs.by_size.dot(&(weighted * springs.elongation));
            by_size_twice += springs.by_size.dot(&(weighted * springs.by_size));
            for (&b, part) in sides() {
                let own = 6 * b..6 * b + 6;
                let pull = part.tr_mul(&(weighted * springs.elongation));
                gradient[own.clone()].iter_mut().zip(&pull).for_each(|(g, p)| *g += p);
                let coupled = part.tr_mul(&(weighted * springs.by_size));
                by_size[own].iter_mut().zip(&coupled).for_each(|(g, p)| *g += p);
                for (&c, other) in sides().filter(|(c, _)| **c <= b) {
                    pattern.add(&mut matrix, [b, c], &part.tr_mul(&(weighted * other)));
                }
            }
        }
        if !self.sized {
            gradient[pattern.size()] = 0.0;
            by_size.fill(0.0);
        }
        Derivatives { gradient, matrix, by_size, by_size_twice }
    }

    fn springs(&self, pose: &Posed) -> Vec<Springs> {
        let mut springs: Vec<Springs> =
            self.pulls.iter().map(|pull| Springs::pull(pull, pose)).collect();
        for (joint, rest) in self.skeleton.joints.iter().zip(self.rest) {
            springs.push(Springs::gap(joint, self.diagonal, pose));
            springs.push(Springs::turn(joint, rest, pose));
        }
        springs
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;
    use crate::math::derivative_check::order_of_convergence;
    use crate::register::joint_limits::JointLimits;
    use crate::register::pose::moved;
    use crate::register::rotation::turned_about;
    use crate::register::skeleton::tests::{block, joint_at};
    use crate::register::springs::joint_turns;

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
        let found = SpringPose::new(&skeleton, 40.0, &rest, pulls, false).solve().unwrap();
        for (b, bone) in skeleton.bones.iter().enumerate() {
            for p in &skeleton.points[bone.vertices.clone()] {
                let off = (moved(&found.motions[b], p) - moved(&truth[b], p)).norm();
                assert!(off < 0.3, "{b} {off}");
            }
        }
    }

    #[test]
    fn a_person_of_another_size_is_found_where_bones_may_change_theirs() {
        let skeleton = chain();
        let (middle, rest) = (Vec3::new(16.5, 0.0, 0.0), joint_turns(&skeleton));
        let size_of = |size: f64, sized: bool| {
            let at = |bone: usize, x: f64| {
                let place = Vec3::new(x, if x > 0.0 { 1.0 } else { 2.0 }, 0.0);
                Pull { bone, place, goal: middle + size * (place - middle), weight: 25.0 }
            };
            let pulls = vec![at(0, -5.0), at(0, 5.0), at(3, 30.0), at(3, 36.0)];
            SpringPose::new(&skeleton, 40.0, &rest, pulls, sized).solve().unwrap().size
        };
        for size in [0.6, 1.5] {
            let found = size_of(size, true);
            assert!((found / size - 1.0).abs() < 0.02, "{size} {found}");
            assert!((size_of(size, false) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_energy() {
        let skeleton = chain();
        let motion = |k: usize| {
            let (x, y) = (0.1 * k as f64, 0.2 - 0.07 * k as f64);
            Isometry3::new(Vec3::new(x, y, -x), Vec3::new(y, -x, 0.3 * x))
        };
        let pulls = pulls(&skeleton, &[Isometry3::translation(0.5, 0.1, -0.2); 4]);
        let rest = joint_turns(&skeleton);
        let problem = SpringPose::new(&skeleton, 40.0, &rest, pulls, true);
        let motions = (0..4).map(motion).collect();
        let pose = Posed { motions, size: 1.2, ..problem.still() };
        let pattern = CoupledBones::new(&problem.centres, &skeleton).unwrap().pattern;
        let gradient = problem.derivatives(&pattern, &pose).gradient;
        let direction: Vec<f64> =
            (0..25).map(|k| f64::from((7 * k + 3) % 11) / 11.0 - 0.4).collect();
        let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
        let order = order_of_convergence(|h| {
            let [ahead, back] = [h, -h].map(|h| problem.energy(&pose.stepped(&direction, h)));
            nalgebra::Vector1::new((ahead - back) / (2.0 * h) / slope - 1.0)
        });
        assert!(order > 1.9, "{order}");
    }
}
