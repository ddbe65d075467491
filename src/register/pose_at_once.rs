//! The best pose under the limits of all joints at once.
//!
//! [G] section 3.4 projects one joint after the other. That is quick far from the limits, but it
//! crawls where joints form tight loops, and ends beside the best pose. Here a few steps of sequential
//! quadratic programming follow: the limits are linearised, with their curvature in the quadratic
//! model, and the least movement of all bones' vertices that meets them is found at once.

use nalgebra::{DMatrix, DVector, Isometry3, Matrix6};

use super::coupled_bones::CoupledBones;
use super::pose::{BoneMoments, ProjectedPose, is_valid, limit_state, moved, project_pose};
use super::pose_rows::{LONGEST_TURN, Row, Twist, rows, twist, twisted};
use super::skeleton::{Joint, Skeleton};
use crate::math::{Mat3, Vec3};
use crate::solve::BlockMatrix;

/// At rest when no bone's step moves its vertices by more than this share of its size.
const REST: f64 = 1e-7;
/// Changes of the set of limits in force in one step at most.
const MAX_CHANGES: usize = 40;
/// Rounds of the first step: the curvature of a limit counts only once its force is known.
const FIRST_ROUNDS: usize = 3;
/// Added to the diagonal of the limits' matrix as a share of it: around loops limits may repeat
/// each other.
const RIDGE: f64 = 1e-13;

/// One bone as a rigid body.
struct Body {
    mass: f64,
    inertia: Mat3,
    /// The step that would take the bone to its goal.
    free: Twist,
}

/// Carries bones as near to `goals` (one rigid motion per bone) as the joints allow: `sweeps` sweeps of
/// [`project_pose`], then at most `steps` steps for all joints at once. Where these fail, as for limits
/// that contradict each other, the pose of the sweeps is returned.
pub fn nearest_pose(
    skeleton: &Skeleton,
    moments: &[BoneMoments],
    goals: &[Isometry3<f64>],
    sweeps: usize,
    steps: usize,
) -> ProjectedPose {
    let start = project_pose(skeleton, moments, goals, sweeps);
    if steps == 0 || start.sweeps == 0 && start.violated == 0 {
        return start;
    }
    let centres: Vec<Vec3> = moments.iter().map(|m| m.centre).collect();
    let Ok(coupled) = CoupledBones::new(&centres, skeleton) else {
        return start;
    };
    let mut pose = start.transforms.clone();
    let mut forces = None;
    for _ in 0..steps {
        let Some((twists, next)) = step(skeleton, &coupled, (moments, goals), &pose, forces) else {
            return start;
        };
        forces = Some(next);
        if move_bones(&mut pose, &twists, moments) {
            break;
        }
    }
    let violated = skeleton.joints.iter().filter(|j| !is_valid(j, moments, &pose)).count();
    let [before, after] = [&start.transforms, &pose].map(|p| excess(skeleton, moments, p));
    // An undefined number is not less than anything.
    if violated == 0 || after < before {
        return ProjectedPose { transforms: pose, sweeps: start.sweeps, violated };
    }
    start
}

/// How far all joints together are beyond their limits, as a length.
fn excess(skeleton: &Skeleton, moments: &[BoneMoments], pose: &[Isometry3<f64>]) -> f64 {
    let of = |joint: &Joint| {
        let child = &moments[joint.child];
        let arm = (joint.child_frame.translation.vector - child.centre).norm();
        let transform = joint.transform(&pose[joint.parent], &pose[joint.child]);
        let state = limit_state(&joint.limits, &transform);
        arm * state.rotation_excess + state.shift_excess
    };
    skeleton.joints.iter().map(of).sum()
}

/// Moves the bones, held back where a turn is long; whether they are at rest.
fn move_bones(pose: &mut [Isometry3<f64>], twists: &[Twist], moments: &[BoneMoments]) -> bool {
    let turn = twists.iter().map(|t| t.fixed_rows::<3>(3).norm()).fold(0.0, f64::max);
    let share = if turn > LONGEST_TURN { LONGEST_TURN / turn } else { 1.0 };
    let mut resting = share >= 1.0;
    for ((motion, twist), m) in pose.iter_mut().zip(twists).zip(moments) {
        let (shift, turn) = (twist.fixed_rows::<3>(0) * share, twist.fixed_rows::<3>(3) * share);
        let size = if m.mass > 0.0 { (m.spread.trace() / m.mass).sqrt() } else { 0.0 };
        resting &= shift.norm() + turn.norm() * size <= REST * size.max(f64::MIN_POSITIVE);
        *motion = twisted(motion, &m.centre, &(twist * share));
    }
    resting
}

/// The least movement of all bones towards their goals inside the linearised limits, and the limits'
/// forces; `forces` are those of the step before.
fn step(
    skeleton: &Skeleton,
    coupled: &CoupledBones,
    (moments, goals): (&[BoneMoments], &[Isometry3<f64>]),
    pose: &[Isometry3<f64>],
    forces: Option<DVector<f64>>,
) -> Option<(Vec<Twist>, DVector<f64>)> {
    let floor = [
        1e-9 * moments.iter().map(|m| m.mass).sum::<f64>(),
        1e-9 * moments.iter().map(|m| m.spread.trace()).sum::<f64>(),
    ];
    let bodies: Vec<Body> =
        (0..pose.len()).map(|b| body(&moments[b], &goals[b], &pose[b], floor)).collect();
    let centres: Vec<Vec3> =
        pose.iter().zip(moments).map(|(now, m)| moved(now, &m.centre)).collect();
    let rows: Vec<Row> = skeleton.joints.iter().flat_map(|j| rows(j, pose, &centres)).collect();
    let rounds = if forces.is_some() { 1 } else { FIRST_ROUNDS };
    let mut forces = forces.unwrap_or_else(|| DVector::zeros(rows.len()));
    let mut twists = Vec::new();
    for _ in 0..rounds {
        (twists, forces) = solve(&rows, &bodies, coupled, &forces)?;
    }
    Some((twists, forces))
}

fn body(
    moments: &BoneMoments,
    goal: &Isometry3<f64>,
    now: &Isometry3<f64>,
    [least_mass, least_spread]: [f64; 2],
) -> Body {
    let rotation = now.rotation.to_rotation_matrix();
    let spread = rotation * moments.spread * rotation.inverse();
    let inertia = Mat3::identity() * (spread.trace() + least_spread) - spread;
    // sum m (x - centre) x (wanted - its centre)
    let k = goal.rotation.to_rotation_matrix() * moments.spread * rotation.inverse();
    let torque = Vec3::new(k.m32 - k.m23, k.m13 - k.m31, k.m21 - k.m12);
    let turn = inertia.try_inverse().map_or_else(Vec3::zeros, |inverse| inverse * torque);
    let shift = moved(goal, &moments.centre) - moved(now, &moments.centre);
    Body { mass: moments.mass + least_mass, inertia, free: twist(shift, turn) }
}

/// The quadratic programme of one step; `before` are the forces that weigh the limits' curvature.
fn solve(
    rows: &[Row],
    bodies: &[Body],
    coupled: &CoupledBones,
    before: &DVector<f64>,
) -> Option<(Vec<Twist>, DVector<f64>)> {
    let CoupledBones { pattern, symbolic } = coupled;
    let mut hessian = BlockMatrix { values: vec![0.0; pattern.row_idx.len()] };
    // Row-major: the bones' pulls in the first column, then the limits' normals; solved in place.
    let width = 1 + rows.len();
    let mut eased = vec![0.0; pattern.size() * width];
    for (b, body) in bodies.iter().enumerate() {
        let mut block = Matrix6::zeros();
        block.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(body.mass);
        block.fixed_view_mut::<3, 3>(3, 3).copy_from(&body.inertia);
        pattern.add(&mut hessian, [b, b], &block);
        for (k, pull) in (block * body.free).iter().enumerate() {
            eased[(6 * b + k) * width] = *pull;
        }
    }
    for (i, row) in rows.iter().enumerate() {
        for (&b, part) in row.bones.iter().zip(&row.parts) {
            for (k, normal) in part.iter().enumerate() {
                eased[(6 * b + k) * width + 1 + i] = *normal;
            }
        }
        let Some((motion, curvature)) = row.curve.as_ref().filter(|_| before[i] > 0.0) else {
            continue;
        };
        for (&b, left) in row.bones.iter().zip(motion) {
            for (&c, right) in row.bones.iter().zip(motion).filter(|(c, _)| **c <= b) {
                let block = left.tr_mul(&(before[i] * curvature * right));
                pattern.add(&mut hessian, [b, c], &block);
            }
        }
    }
    symbolic.factor(&hessian).ok()?.solve_rows(&mut eased, width);
    let along = |row: &Row, column: usize| -> f64 {
        let of = |(&b, part): (&usize, &Twist)| -> f64 {
            (0..6).map(|k| part[k] * eased[(6 * b + k) * width + column]).sum()
        };
        row.bones.iter().zip(&row.parts).map(of).sum()
    };
    let coupling = DMatrix::from_fn(rows.len(), rows.len(), |i, j| along(&rows[i], 1 + j));
    let excess = DVector::from_fn(rows.len(), |i, _| along(&rows[i], 0) - rows[i].room);
    let forces = limit_forces(rows, coupling, &excess)?;
    let found =
        |row: &[f64]| row[0] - row[1..].iter().zip(&forces).map(|(e, f)| e * f).sum::<f64>();
    let found: Vec<f64> = eased.chunks_exact(width).map(found).collect();
    Some((found.chunks_exact(6).map(Twist::from_column_slice).collect(), forces))
}

/// The forces of the limits: none where a limit is not reached, never pulling outwards.
fn limit_forces(
    rows: &[Row],
    mut coupling: DMatrix<f64>,
    excess: &DVector<f64>,
) -> Option<DVector<f64>> {
    let n = rows.len();
    let largest = (0..n).map(|i| coupling[(i, i)]).fold(0.0, f64::max);
    for i in 0..n {
        coupling[(i, i)] += RIDGE * largest;
    }
    let mut in_force: Vec<bool> = (0..n).map(|i| rows[i].equality || excess[i] > 0.0).collect();
    let mut forces = DVector::zeros(n);
    for change in 0..MAX_CHANGES {
        let chosen: Vec<usize> = (0..n).filter(|&i| in_force[i]).collect();
        let matrix = coupling.select_rows(&chosen).select_columns(&chosen);
        let solved = matrix.cholesky()?.solve(&excess.select_rows(&chosen));
        forces.fill(0.0);
        for (&i, force) in chosen.iter().zip(solved.iter()) {
            forces[i] = *force;
        }
        let left = excess - &coupling * &forces;
        let scale = 1e-10 * excess.amax();
        let pulling = |i: usize| in_force[i] && !rows[i].equality && forces[i] < 0.0;
        let missed = |i: usize| !in_force[i] && left[i] > scale;
        let wrong: Vec<usize> = (0..n).filter(|&i| pulling(i) || missed(i)).collect();
        if wrong.is_empty() {
            return Some(forces);
        }
        // All wrong ones change at first, later one by one, which cannot go round in circles.
        let count = if change < MAX_CHANGES / 2 { wrong.len() } else { 1 };
        for &i in &wrong[..count] {
            in_force[i] = !in_force[i];
        }
    }
    // Not settled: forces that pull outwards are left out, the next step starts nearer.
    for i in 0..n {
        if !rows[i].equality && forces[i] < 0.0 {
            forces[i] = 0.0;
        }
    }
    Some(forces)
}
