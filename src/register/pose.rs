//! Bones carried to their targets as rigid bodies under the limits of their joints.
//!
//! [G] section 3.4: sequential projections, joint after joint, on bone moments, so that a visit of
//! a joint costs the same for any number of vertices.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion};
use rayon::prelude::*;

use super::joint_limits::JointLimits;
use super::rotation::{PairSums, best_rotation, renormalized, rotation_vector, turned_about};
use super::skeleton::{Joint, Skeleton};
use crate::math::{Mat3, Vec3};

/// Rotation beyond its limit that still counts as inside, radians.
const ANGLE_TOLERANCE: f64 = 1e-7;
/// Shift beyond its limit that still counts as inside, relative to the limit plus bone size.
const SHIFT_TOLERANCE: f64 = 1e-9;

/// Mass, centre and second moment of one bone's vertices.
#[derive(Clone, Copy, Debug)]
pub struct BoneMoments {
    /// Sum of the vertex masses.
    pub mass: f64,
    /// Centre of mass.
    pub centre: Vec3,
    /// Sum of m (x - centre)(x - centre)^T.
    pub spread: Mat3,
}

impl BoneMoments {
    /// Moments of points with masses.
    pub fn new(points: &[Vec3], masses: &[f64]) -> Self {
        let mass: f64 = masses.iter().sum();
        let first = points.first().copied().unwrap_or_default();
        let offset: Vec3 = points.iter().zip(masses).map(|(p, &m)| m * (p - first)).sum();
        let centre = if mass > 0.0 { first + offset / mass } else { first };
        let spread = points
            .iter()
            .zip(masses)
            .map(|(p, &m)| m * (p - centre) * (p - centre).transpose())
            .sum();
        Self { mass, centre, spread }
    }

    /// sum m (T* x - a)(T x - a')^T for the target motion T* and the present motion T.
    fn cross(&self, target: &Isometry3<f64>, now: &Isometry3<f64>, a: Vec3, a_now: Vec3) -> Mat3 {
        let rotated = target.rotation.to_rotation_matrix()
            * self.spread
            * now.rotation.to_rotation_matrix().inverse();
        rotated
            + self.mass
                * (moved(target, &self.centre) - a)
                * (moved(now, &self.centre) - a_now).transpose()
    }
}

/// Of all bones.
pub(super) fn moments(reference: &Skeleton, masses: &[f64]) -> Vec<BoneMoments> {
    reference
        .bones
        .par_iter()
        .map(|b| {
            let range = b.vertices.clone();
            BoneMoments::new(&reference.points[range.clone()], &masses[range])
        })
        .collect()
}

/// The bone with the largest mass.
pub(super) fn heaviest(moments: &[BoneMoments]) -> usize {
    (0..moments.len()).max_by(|&a, &b| moments[a].mass.total_cmp(&moments[b].mass)).unwrap_or(0)
}

/// Result of [`project_pose`].
#[derive(Clone, Debug)]
pub struct ProjectedPose {
    /// Motion of every bone from the reference.
    pub transforms: Vec<Isometry3<f64>>,
    /// Sweeps over all joints that were made.
    pub sweeps: usize,
    /// Joints still outside their limits.
    pub violated: usize,
}

/// How far a joint's transform stands from its limits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LimitState {
    /// Share of the rotation ellipsoid used (1 = on the limit).
    pub rotation_usage: f64,
    /// Rotation beyond the limit, radians.
    pub rotation_excess: f64,
    /// Distance of the two joint points, template unit.
    pub shift: f64,
    /// Shift beyond the limit, template unit.
    pub shift_excess: f64,
}

/// Measures the joint transform `child frame seen from parent frame` against its limits.
pub fn limit_state(limits: &JointLimits, transform: &Isometry3<f64>) -> LimitState {
    let r = rotation_vector(&transform.rotation);
    let shift = transform.translation.vector.norm();
    LimitState {
        rotation_usage: limits.usage(&r),
        rotation_excess: limits.excess(&r),
        shift,
        shift_excess: (shift - limits.shift).max(0.0),
    }
}

/// Carries bones as near to `targets` (one rigid motion per bone) as the joints allow, in at most
/// `sweeps` sweeps over all joints. Deterministic; the order is that of the joints.
pub fn project_pose(
    skeleton: &Skeleton,
    moments: &[BoneMoments],
    targets: &[Isometry3<f64>],
    sweeps: usize,
) -> ProjectedPose {
    let mut goals = targets.to_vec();
    let mut violated = 0;
    for sweep in 0..sweeps {
        violated = 0;
        for joint in &skeleton.joints {
            violated += usize::from(project_joint(joint, moments, &mut goals));
        }
        for goal in &mut goals {
            goal.rotation = renormalized(goal.rotation);
        }
        if violated == 0 {
            return ProjectedPose { transforms: goals, sweeps: sweep, violated };
        }
    }
    if sweeps > 0 {
        violated = skeleton.joints.iter().filter(|j| !is_valid(j, moments, &goals)).count();
    }
    ProjectedPose { transforms: goals, sweeps, violated }
}

/// Clamps the joints of a spanning tree exactly, from `root` outwards, moving the outer bone.
/// Joints that close loops keep what the sweeps of [`project_pose`] reached.
pub fn settle_tree(skeleton: &Skeleton, root: usize, transforms: &mut [Isometry3<f64>]) {
    for (j, to_child) in skeleton.spanning_forest(root) {
        let joint = &skeleton.joints[j];
        let (parent, child) = (transforms[joint.parent], transforms[joint.child]);
        let transform = joint.transform(&parent, &child);
        let clamped = clamp(&joint.limits, &transform);
        if to_child {
            transforms[joint.child] =
                parent * joint.parent_frame * clamped * joint.child_frame.inverse();
        } else {
            transforms[joint.parent] =
                child * joint.child_frame * clamped.inverse() * joint.parent_frame.inverse();
        }
    }
}

fn clamp(limits: &JointLimits, transform: &Isometry3<f64>) -> Isometry3<f64> {
    let r = limits.nearest_admissible(&rotation_vector(&transform.rotation));
    let shift = transform.translation.vector;
    let scale = if shift.norm() > limits.shift { limits.shift / shift.norm() } else { 1.0 };
    Isometry3::from_parts(Translation3::from(shift * scale), UnitQuaternion::from_scaled_axis(r))
}

pub(super) fn is_valid(joint: &Joint, moments: &[BoneMoments], now: &[Isometry3<f64>]) -> bool {
    let state = limit_state(&joint.limits, &joint.transform(&now[joint.parent], &now[joint.child]));
    let reach = (joint.parent_frame.translation.vector - moments[joint.parent].centre).norm();
    state.rotation_excess <= ANGLE_TOLERANCE
        && state.shift_excess <= SHIFT_TOLERANCE * (joint.limits.shift + reach)
}

/// One visit of a joint; returns whether it was outside its limits. `goals` holds the target pose
/// x* on entry and the projected pose, which replaces the target, on return.
fn project_joint(joint: &Joint, moments: &[BoneMoments], goals: &mut [Isometry3<f64>]) -> bool {
    if is_valid(joint, moments, goals) {
        return false;
    }
    let (p, c) = (joint.parent, joint.child);
    let (goal_p, goal_c) = (goals[p], goals[c]);
    let (mut now_p, mut now_c) = (goal_p, goal_c);
    let at = |now: &Isometry3<f64>, frame: &Isometry3<f64>| moved(now, &frame.translation.vector);

    // 1. Close the gap down to the allowed shift, the lighter bone moving more. [G] Eq. (2), with
    //    the sign that closes the gap; the paper prints the one that opens it.
    let gap = at(&now_p, &joint.parent_frame) - at(&now_c, &joint.child_frame);
    if gap.norm() > joint.limits.shift {
        let (m_p, m_c) = (moments[p].mass, moments[c].mass);
        let total = m_p + m_c;
        let share = if total > 0.0 { m_c / total } else { 0.5 };
        let excess = gap * (1.0 - joint.limits.shift / gap.norm());
        now_p.translation.vector -= share * excess;
        now_c.translation.vector += (1.0 - share) * excess;
    }
    // 2. Turn each bone about its own joint point back to its target: the gap stays as it is.
    for (now, goal, frame, bone) in [
        (&mut now_p, &goal_p, &joint.parent_frame, p),
        (&mut now_c, &goal_c, &joint.child_frame, c),
    ] {
        let a = at(now, frame);
        if let Some(rotation) = best_rotation(&moments[bone].cross(goal, now, a, a)) {
            *now = turned_about(now, &a, rotation);
        }
    }
    // 3. Turn the child so that the joint has the nearest admissible rotation. The rotation is set,
    //    not multiplied on: errors of orthogonality would grow around loops.
    let r = rotation_vector(&joint.transform(&now_p, &now_c).rotation);
    let admissible = UnitQuaternion::from_scaled_axis(joint.limits.nearest_admissible(&r));
    let b = at(&now_c, &joint.child_frame);
    let parent_rotation = now_p.rotation * joint.parent_frame.rotation;
    let child_rotation = parent_rotation * admissible * joint.child_frame.rotation.inverse();
    let translation = b - child_rotation * joint.child_frame.translation.vector;
    now_c = Isometry3::from_parts(Translation3::from(translation), child_rotation);
    // 4. Carry both bones together, as one body, back to their targets.
    let together = best_common_motion(moments, [(p, &goal_p, &now_p), (c, &goal_c, &now_c)]);
    goals[p] = together * now_p;
    goals[c] = together * now_c;
    true
}

/// The rigid motion that carries two bones together from their present to their target poses.
fn best_common_motion(
    moments: &[BoneMoments],
    bones: [(usize, &Isometry3<f64>, &Isometry3<f64>); 2],
) -> Isometry3<f64> {
    let total: f64 = bones.iter().map(|(b, ..)| moments[*b].mass).sum();
    if total <= 0.0 {
        return Isometry3::identity();
    }
    let place =
        |b: usize, motion: &Isometry3<f64>| moments[b].mass * moved(motion, &moments[b].centre);
    let goal_mean = bones.iter().map(|(b, goal, _)| place(*b, goal)).sum::<Vec3>() / total;
    let now_mean = bones.iter().map(|(b, _, now)| place(*b, now)).sum::<Vec3>() / total;
    let h: Mat3 =
        bones.iter().map(|(b, goal, now)| moments[*b].cross(goal, now, goal_mean, now_mean)).sum();
    let rotation = best_rotation(&h).unwrap_or_else(UnitQuaternion::identity);
    Isometry3::from_parts(Translation3::from(goal_mean - rotation * now_mean), rotation)
}

/// The best rigid motion of each bone from `reference` to `wanted` under vertex masses; a bone
/// without mass gets none.
pub fn rigid_targets(
    skeleton: &Skeleton,
    reference: &[Vec3],
    wanted: &[Vec3],
    masses: &[f64],
) -> Vec<Option<Isometry3<f64>>> {
    skeleton
        .bones
        .par_iter()
        .map(|bone| {
            let mut sums = PairSums::new(reference[bone.vertices.start]);
            for i in bone.vertices.clone() {
                sums.add(&reference[i], &wanted[i], masses[i]);
            }
            sums.best_rigid()
        })
        .collect()
}

pub(super) fn moved(motion: &Isometry3<f64>, point: &Vec3) -> Vec3 {
    (motion * Point3::from(*point)).coords
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::locate::test_shapes::Noise;
    use crate::register::areas::vertex_areas;
    use crate::register::pose_at_once::nearest_pose;
    use crate::register::skeleton::tests::{block, joint_at};

    /// A ring of five bones joined to a loop, with a sixth on a hinge; each joint with its limits.
    fn ring() -> (Skeleton, Vec<BoneMoments>) {
        let limits = |n: [f64; 3], p: [f64; 3]| {
            let radians = |v: [f64; 3]| Vec3::from(v).map(f64::to_radians);
            JointLimits::new(radians(n), radians(p), 0.3).unwrap()
        };
        let centre = |k: f64| {
            let angle = k / 5.0 * std::f64::consts::TAU;
            Vec3::new(libm::cos(angle), libm::sin(angle), 0.0) * 10.0
        };
        let mut surfaces: Vec<_> = (0..5)
            .map(|k| (format!("b{k}"), block(centre(f64::from(k)), Vec3::new(4.0, 2.0, 1.0), 3)))
            .collect();
        surfaces
            .push(("tip".into(), block(Vec3::new(20.0, 0.0, 0.0), Vec3::new(5.0, 1.0, 1.0), 3)));
        let mut joints: Vec<_> = (0..5)
            .map(|k| {
                let bones = [k, (k + 1) % 5];
                let small = limits([8.0, 5.0, 3.0], [8.0, 5.0, 3.0]);
                joint_at(&format!("j{k}"), bones, centre(k as f64 + 0.5), small)
            })
            .collect();
        let hinge = limits([20.0, 0.0, 0.0], [90.0, 0.0, 0.0]);
        joints.push(joint_at("tip", [0, 5], Vec3::new(14.5, 0.0, 0.0), hinge));
        let skeleton = Skeleton::new(surfaces, joints).unwrap();
        let areas = vertex_areas(&skeleton.points, &skeleton.triangles);
        let moments = skeleton
            .bones
            .iter()
            .map(|b| {
                let range = b.vertices.clone();
                BoneMoments::new(&skeleton.points[range.clone()], &areas[range])
            })
            .collect();
        (skeleton, moments)
    }

    fn disturbed(noise: &mut Noise, moments: &[BoneMoments], degrees: f64) -> Vec<Isometry3<f64>> {
        moments
            .iter()
            .map(|m| {
                let turn = UnitQuaternion::from_scaled_axis(noise.vector() * degrees.to_radians());
                let moved = turned_about(&Isometry3::identity(), &m.centre, turn);
                Translation3::from(noise.vector() * 1.5) * moved
            })
            .collect()
    }

    fn worst(skeleton: &Skeleton, pose: &[Isometry3<f64>]) -> (f64, f64) {
        let states = skeleton
            .joints
            .iter()
            .map(|j| limit_state(&j.limits, &j.transform(&pose[j.parent], &pose[j.child])));
        states.fold((0.0, 0.0), |(angle, shift), s| {
            (f64::max(angle, s.rotation_excess.to_degrees()), f64::max(shift, s.shift_excess))
        })
    }

    #[test]
    fn disturbed_bones_come_inside_their_limits_around_a_loop() {
        let (skeleton, moments) = ring();
        let mut noise = Noise::new(11);
        for degrees in [10.0, 25.0] {
            let targets = disturbed(&mut noise, &moments, degrees);
            let before = worst(&skeleton, &targets);
            let ten = project_pose(&skeleton, &moments, &targets, 10);
            let after = worst(&skeleton, &ten.transforms);
            assert!(before.0 > 3.0 && after.0 < 1.5 && after.1 < 0.2, "{before:?} {after:?}");
            // Sweeps crawl around a bare ring of tight joints.
            let many = nearest_pose(&skeleton, &moments, &targets, 10, 10);
            let late = worst(&skeleton, &many.transforms);
            assert!(late.0 < 1e-4 && late.1 < 1e-6, "{late:?}");
            for t in &many.transforms {
                let r = t.rotation.to_rotation_matrix().into_inner();
                assert!((r.transpose() * r - Mat3::identity()).norm() < 1e-12);
            }
        }
    }

    #[test]
    fn an_admissible_pose_stays_and_a_tree_settles_exactly() {
        let (skeleton, moments) = ring();
        let still = vec![Isometry3::identity(); 6];
        let kept = project_pose(&skeleton, &moments, &still, 10);
        assert_eq!((kept.sweeps, kept.violated), (0, 0));
        assert_eq!(kept.transforms, still);
        let mut pose = disturbed(&mut Noise::new(5), &moments, 30.0);
        settle_tree(&skeleton, 0, &mut pose);
        let hinge = &skeleton.joints[5];
        let state = limit_state(&hinge.limits, &hinge.transform(&pose[0], &pose[5]));
        assert!(state.rotation_excess < 1e-9 && state.shift_excess < 1e-9);
    }

    #[test]
    fn the_projection_moves_little_more_than_the_best_pose() {
        // One joint with a shift limit only: the optimum is known, both bones share the way.
        let (skeleton, moments) = ring();
        let mut two = skeleton.clone();
        two.joints = vec![skeleton.joints[5].clone()];
        two.joints[0].limits = JointLimits::new(Vec3::repeat(9.0), Vec3::repeat(9.0), 0.0).unwrap();
        let mut targets = vec![Isometry3::identity(); 6];
        targets[5] = Isometry3::translation(2.0, 0.0, 0.0);
        let found = project_pose(&two, &moments, &targets, 10);
        let moved = |b: usize| {
            let d = targets[b].translation.vector - found.transforms[b].translation.vector;
            moments[b].mass * d.norm_squared()
        };
        let (m, n) = (moments[0].mass, moments[5].mass);
        let best = m * n / (m + n) * 4.0;
        assert!(moved(0) + moved(5) <= 1.08 * best, "{} {best}", moved(0) + moved(5));
    }
}
