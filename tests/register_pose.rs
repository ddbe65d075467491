//! Poses under joint limits: a finger, and a whole hand whose carpal bones are joined in loops.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use moulage::job::read_skeleton;
use moulage::math::Vec3;
use moulage::register::areas::vertex_areas;
use moulage::register::pose::{BoneMoments, limit_state, project_pose};
use moulage::register::pose_at_once::nearest_pose;
use moulage::register::rotation::{rotation_vector, turned_about};
use moulage::register::{Joint, JointLimits, Skeleton};
use nalgebra::{DMatrix, DVector, Isometry3, Point3, Translation3, UnitQuaternion};

/// Numbers between -1 and 1, the same on every run.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

fn limits(neg: [f64; 3], pos: [f64; 3], shift: f64) -> JointLimits {
    let radians = |v: [f64; 3]| Vec3::from(v).map(f64::to_radians);
    JointLimits::new(radians(neg), radians(pos), shift).unwrap()
}

/// The hand of the example: 27 bones, and besides the joints of its tree eleven between neighbouring
/// carpal and metacarpal bones.
fn hand() -> Skeleton {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand/skeleton.json");
    let mut hand = read_skeleton(&path).unwrap().skeleton;
    let finger = limits([20.0, 10.0, 5.0], [120.0, 10.0, 5.0], 1.0);
    for joint in &mut hand.joints {
        joint.limits.shift = 1.0;
        if joint.coordinates.len() == 1 {
            joint.limits = finger;
        }
    }
    let loops = [
        ("scaphoid", "trapezium"),
        ("scaphoid", "trapezoid"),
        ("scaphoid", "capitate"),
        ("trapezium", "trapezoid"),
        ("triquetrum", "hamate"),
        ("triquetrum", "pisiform"),
        ("lunate", "hamate"),
        ("2mc", "3mc"),
        ("3mc", "4mc"),
        ("4mc", "5mc"),
        ("trapezium", "2mc"),
    ];
    for (a, b) in loops {
        let [parent, child] = [a, b].map(|name| hand.bone_index(name).unwrap());
        let frame = Translation3::from((middle(&hand, parent) + middle(&hand, child)) / 2.0).into();
        hand.joints.push(Joint {
            name: format!("{a}-{b}"),
            parent,
            child,
            parent_frame: frame,
            child_frame: frame,
            limits: limits([10.0; 3], [10.0; 3], 1.0),
            in_tree: false,
            coordinates: Vec::new(),
            path: None,
        });
    }
    hand
}

fn middle(skeleton: &Skeleton, b: usize) -> Vec3 {
    let range = skeleton.bones[b].vertices.clone();
    let count = range.len() as f64;
    skeleton.points[range].iter().sum::<Vec3>() / count
}

/// The index finger of the hand: the first bones from the knuckle on.
fn finger(hand: &Skeleton, count: usize) -> Skeleton {
    let names = ["2proxph", "2midph", "2distph"];
    let bones: Vec<usize> = names[..count].iter().map(|n| hand.bone_index(n).unwrap()).collect();
    let surface = |&b: &usize| (hand.bones[b].name.clone(), hand.bone_surface(b, &hand.points));
    let joints = hand.joints.iter().filter_map(|joint| {
        let end = |b: usize| bones.iter().position(|&own| own == b);
        let mut joint = joint.clone();
        (joint.parent, joint.child) = (end(joint.parent)?, end(joint.child)?);
        joint.limits = limits([20.0, 10.0, 5.0], [120.0, 10.0, 5.0], 1.0);
        Some(joint)
    });
    Skeleton::new(bones.iter().map(surface).collect(), joints.collect()).unwrap()
}

fn moments(skeleton: &Skeleton) -> Vec<BoneMoments> {
    let areas = vertex_areas(&skeleton.points, &skeleton.triangles);
    let of = |range: std::ops::Range<usize>| {
        BoneMoments::new(&skeleton.points[range.clone()], &areas[range])
    };
    skeleton.bones.iter().map(|b| of(b.vertices.clone())).collect()
}

fn disturbed(
    noise: &mut Noise,
    moments: &[BoneMoments],
    degrees: f64,
    shift: f64,
) -> Vec<Isometry3<f64>> {
    let mut one = |m: &BoneMoments| {
        let turn = UnitQuaternion::from_scaled_axis(noise.vector() * degrees.to_radians());
        Translation3::from(noise.vector() * shift)
            * turned_about(&Isometry3::identity(), &m.centre, turn)
    };
    moments.iter().map(&mut one).collect()
}

/// The largest rotation (degrees) and shift beyond a limit.
fn worst(skeleton: &Skeleton, pose: &[Isometry3<f64>]) -> (f64, f64) {
    skeleton
        .joints
        .iter()
        .map(|j| limit_state(&j.limits, &j.transform(&pose[j.parent], &pose[j.child])))
        .fold((0.0, 0.0), |(angle, shift), s| {
            (f64::max(angle, s.rotation_excess.to_degrees()), f64::max(shift, s.shift_excess))
        })
}

/// Root mean square distance of the bones' vertices from where they want to go.
fn distance(moments: &[BoneMoments], pose: &[Isometry3<f64>], goals: &[Isometry3<f64>]) -> f64 {
    let at = |t: &Isometry3<f64>, p: &Vec3| (t * Point3::from(*p)).coords;
    let of = |m: &BoneMoments, t: &Isometry3<f64>, g: &Isometry3<f64>| {
        let turned = (t.rotation.to_rotation_matrix() * m.spread)
            .dot(g.rotation.to_rotation_matrix().matrix());
        m.mass * (at(t, &m.centre) - at(g, &m.centre)).norm_squared()
            + 2.0 * (m.spread.trace() - turned)
    };
    let squares: f64 = moments.iter().zip(pose).zip(goals).map(|((m, t), g)| of(m, t, g)).sum();
    (squares / moments.iter().map(|m| m.mass).sum::<f64>()).sqrt()
}

#[test]
fn a_finger_comes_inside_its_limits_at_once() {
    let hand = hand();
    let mut noise = Noise(7);
    for count in [2, 3] {
        let finger = finger(&hand, count);
        assert_eq!(finger.joints.len(), count - 1);
        let moments = moments(&finger);
        for (degrees, shift) in [(10.0, 1.5), (25.0, 4.0)] {
            for _ in 0..10 {
                let goals = disturbed(&mut noise, &moments, degrees, shift);
                let swept = project_pose(&finger, &moments, &goals, 10);
                assert!(
                    worst(&finger, &swept.transforms) < (0.02, 0.002),
                    "{:?}",
                    worst(&finger, &swept.transforms)
                );
                let found = nearest_pose(&finger, &moments, &goals, 10, 30);
                assert_eq!(found.violated, 0, "{:?}", worst(&finger, &found.transforms));
                assert!(
                    distance(&moments, &found.transforms, &goals)
                        <= 1.001 * distance(&moments, &swept.transforms, &goals)
                );
            }
        }
    }
}

#[test]
fn the_pose_of_a_finger_is_the_best_one() {
    let finger = finger(&hand(), 3);
    let moments = moments(&finger);
    let mut noise = Noise(23);
    for (degrees, shift) in [(10.0, 1.5), (25.0, 4.0)] {
        for _ in 0..4 {
            let goals = disturbed(&mut noise, &moments, degrees, shift);
            let found = nearest_pose(&finger, &moments, &goals, 10, 30);
            let found = distance(&moments, &found.transforms, &goals);
            let best = best_distance(&finger, &moments, &goals);
            assert!(found <= 1.002 * best, "{found} against {best}");
        }
    }
}

#[test]
fn a_hand_with_loops_comes_inside_its_limits() {
    let hand = hand();
    assert_eq!((hand.bones.len(), hand.joints.len()), (27, 37));
    let moments = moments(&hand);
    let mut noise = Noise(11);
    for (degrees, shift) in [(10.0, 1.5), (25.0, 4.0)] {
        for _ in 0..5 {
            let goals = disturbed(&mut noise, &moments, degrees, shift);
            let before = worst(&hand, &goals);
            assert!(before.0 > 5.0 && before.1 > 1.0, "{before:?}");
            let found = nearest_pose(&hand, &moments, &goals, 10, 30);
            let (angle, gap) = worst(&hand, &found.transforms);
            assert!(angle < 0.001 && gap < 1e-4, "{angle} {gap}");
            let swept = project_pose(&hand, &moments, &goals, 50);
            for t in found.transforms.iter().chain(&swept.transforms) {
                let r = t.rotation.to_rotation_matrix().into_inner();
                assert!((r.transpose() * r - nalgebra::Matrix3::identity()).norm() < 1e-12);
            }
        }
    }
}

/// The least distance that a chain of bones can reach: Levenberg-Marquardt over the pose of the first
/// bone and, for every joint, a rotation vector and a shift that are put inside the limits.
fn best_distance(chain: &Skeleton, moments: &[BoneMoments], goals: &[Isometry3<f64>]) -> f64 {
    let pose = |x: &DVector<f64>| -> Vec<Isometry3<f64>> {
        let three = |k: usize| Vec3::new(x[k], x[k + 1], x[k + 2]);
        let start = turned_about(
            &Isometry3::identity(),
            &moments[0].centre,
            UnitQuaternion::from_scaled_axis(three(3)),
        );
        let mut pose = vec![Translation3::from(three(0)) * start];
        for (j, joint) in chain.joints.iter().enumerate() {
            let r = joint.limits.nearest_admissible(&three(6 + 6 * j));
            let shift = three(9 + 6 * j);
            let shift = shift * (joint.limits.shift / shift.norm()).min(1.0);
            let transform = Isometry3::from_parts(
                Translation3::from(shift),
                UnitQuaternion::from_scaled_axis(r),
            );
            let parent = pose[joint.parent] * joint.parent_frame;
            pose.push(parent * transform * joint.child_frame.inverse());
        }
        pose
    };
    let points: Vec<(usize, Vec3)> = (0..chain.bones.len())
        .flat_map(|b| {
            // Six points with the moments of the bone.
            let eigen = nalgebra::SymmetricEigen::new(moments[b].spread);
            (0..6).map(move |k| {
                let length = (eigen.eigenvalues[k / 2] / moments[b].mass * 3.0).sqrt();
                let side = if k % 2 == 0 { length } else { -length };
                (b, moments[b].centre + eigen.eigenvectors.column(k / 2) * side)
            })
        })
        .collect();
    let residual = |x: &DVector<f64>| -> DVector<f64> {
        let pose = pose(x);
        let apart = points.iter().flat_map(|(b, p)| {
            let p = Point3::from(*p);
            let far = (pose[*b] * p - goals[*b] * p) * (moments[*b].mass / 6.0).sqrt();
            [far.x, far.y, far.z]
        });
        DVector::from_iterator(3 * points.len(), apart)
    };
    let n = 6 + 6 * chain.joints.len();
    let mut x = DVector::zeros(n);
    for (k, joint) in chain.joints.iter().enumerate() {
        let present = joint.transform(&goals[joint.parent], &goals[joint.child]);
        x.fixed_rows_mut::<3>(6 + 6 * k).copy_from(&rotation_vector(&present.rotation));
        x.fixed_rows_mut::<3>(9 + 6 * k).copy_from(&present.translation.vector);
    }
    distance(moments, &pose(&minimum(residual, x)), goals)
}

/// Where the sum of squares of the residuals is least, from `x` downhill.
fn minimum(residual: impl Fn(&DVector<f64>) -> DVector<f64>, mut x: DVector<f64>) -> DVector<f64> {
    let n = x.len();
    let mut now = residual(&x);
    let mut damping = 1e-3;
    for _ in 0..300 {
        let mut jacobian = DMatrix::zeros(now.len(), n);
        for k in 0..n {
            let mut moved = x.clone();
            moved[k] += 1e-6;
            jacobian.set_column(k, &((residual(&moved) - &now) / 1e-6));
        }
        let gradient = jacobian.tr_mul(&now);
        let mut normal = jacobian.tr_mul(&jacobian);
        let size = normal.diagonal().max();
        for k in 0..n {
            normal[(k, k)] += damping * size;
        }
        let next = &x - normal.cholesky().unwrap().solve(&gradient);
        let then = residual(&next);
        if then.norm() < now.norm() {
            (x, now) = (next, then);
            damping = f64::max(damping / 4.0, 1e-12);
        } else {
            damping *= 4.0;
        }
    }
    x
}
