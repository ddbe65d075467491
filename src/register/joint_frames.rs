//! Joint frames follow a change of their bone's shape.
//!
//! [G] section 3.4: the orientation follows the whole bone; the centre follows a rigid moving
//! least-squares fit (Schaefer, McPhail, Warren 2006). The weights are area / distance^2: the
//! paper's 1/distance hardly localises on a surface.

use nalgebra::{Isometry3, Translation3};
use rayon::prelude::*;

use super::pose::moved;
use super::rotation::{PairSums, renormalized};
use super::skeleton::Skeleton;
use crate::math::Vec3;

/// The frame carried by bone `b` after its vertices went from `before` to `after` (positions of the
/// whole skeleton; `areas` are the vertex areas).
pub fn follow_shape(
    skeleton: &Skeleton,
    b: usize,
    frame: &Isometry3<f64>,
    [before, after]: [&[Vec3]; 2],
    areas: &[f64],
) -> Isometry3<f64> {
    let centre = frame.translation.vector;
    let (mut whole, mut local) = (PairSums::new(centre), PairSums::new(centre));
    // A joint point that lies on a vertex would get an infinite weight.
    let floor = 1e-12
        * skeleton.bones[b]
            .vertices
            .clone()
            .map(|i| (before[i] - centre).norm_squared())
            .fold(0.0, f64::max);
    for i in skeleton.bones[b].vertices.clone() {
        let (from, to) = (before[i], after[i]);
        whole.add(&from, &to, areas[i]);
        local.add(&from, &to, areas[i] / ((from - centre).norm_squared() + floor));
    }
    match (whole.best_rigid(), local.best_rigid()) {
        (Some(whole), Some(local)) => Isometry3::from_parts(
            Translation3::from(moved(&local, &centre)),
            renormalized(whole.rotation * frame.rotation),
        ),
        _ => *frame,
    }
}

/// Lets all joint frames of `skeleton` follow the change of its bones to `after`, and takes the
/// new points.
pub fn take_shape(skeleton: &mut Skeleton, after: Vec<Vec3>, areas: &[f64]) {
    let follow = |b: usize, frame: &Isometry3<f64>| {
        follow_shape(skeleton, b, frame, [&skeleton.points, &after], areas)
    };
    let frames: Vec<[Isometry3<f64>; 2]> = skeleton
        .joints
        .par_iter()
        .map(|j| [follow(j.parent, &j.parent_frame), follow(j.child, &j.child_frame)])
        .collect();
    let Skeleton { bones, joints, points, .. } = skeleton;
    for (joint, [parent_frame, child_frame]) in joints.iter_mut().zip(frames) {
        joint.parent_frame = parent_frame;
        joint.child_frame = child_frame;
        if let Some(path) = &mut joint.path {
            let own = bones[joint.parent].vertices.clone();
            path.scale(growth([&points[own.clone()], &after[own.clone()]], &areas[own]));
        }
    }
    *points = after;
}

/// How much larger a bone has become: the ratio of its radii of gyration.
fn growth(points: [&[Vec3]; 2], areas: &[f64]) -> f64 {
    let total: f64 = areas.iter().sum();
    let [before, after] = points.map(|points| {
        let middle = points.iter().zip(areas).map(|(p, a)| p * *a).sum::<Vec3>() / total;
        points.iter().zip(areas).map(|(p, a)| a * (p - middle).norm_squared()).sum::<f64>()
    });
    let ratio = (after / before).sqrt();
    if ratio.is_finite() { ratio } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::register::areas::vertex_areas;
    use crate::register::joint_limits::JointLimits;
    use crate::register::joint_path::JointPath;
    use crate::register::skeleton::tests::{block, joint_at};

    fn bone() -> Skeleton {
        let limits = JointLimits::new(Vec3::zeros(), Vec3::zeros(), 1.0).unwrap();
        let a = block(Vec3::zeros(), Vec3::new(10.0, 1.0, 1.0), 12);
        let b = block(Vec3::new(21.0, 0.0, 0.0), Vec3::new(10.0, 1.0, 1.0), 12);
        let mut joint = joint_at("ab", [0, 1], Vec3::new(10.0, 0.0, 0.0), limits);
        let way = [(0.0, Isometry3::identity()), (1.0, Isometry3::translation(2.0, 0.0, 0.0))];
        joint.path = Some(JointPath::new("slide".into(), way.to_vec()).unwrap());
        Skeleton::new(vec![("a".into(), a), ("b".into(), b)], vec![joint]).unwrap()
    }

    #[test]
    fn frames_follow_a_rigid_motion_exactly_and_stay_when_nothing_moves() {
        let mut skeleton = bone();
        let areas = vertex_areas(&skeleton.points, &skeleton.triangles);
        let before = skeleton.clone();
        let points = skeleton.points.clone();
        take_shape(&mut skeleton, points, &areas);
        let still = before.joints[0].parent_frame.inv_mul(&skeleton.joints[0].parent_frame);
        assert!(still.translation.vector.norm() < 1e-12 && still.rotation.angle() < 1e-12);
        let motion = Isometry3::new(Vec3::new(3.0, -2.0, 30.0), Vec3::new(0.4, -2.0, 1.1));
        let after = before.points.iter().map(|p| moved(&motion, p)).collect();
        take_shape(&mut skeleton, after, &areas);
        let rest = (motion * before.joints[0].child_frame).inv_mul(&skeleton.joints[0].child_frame);
        assert!(rest.translation.vector.norm() < 1e-9 && rest.rotation.angle() < 1e-9);
    }

    #[test]
    fn the_centre_follows_the_end_it_lies_in() {
        let mut skeleton = bone();
        let areas = vertex_areas(&skeleton.points, &skeleton.triangles);
        // The first bone grows by a tenth, so its end goes from x = 10 to 11.
        let grown = |p: &Vec3| if p.x <= 10.5 { Vec3::new(p.x * 1.1, p.y, p.z) } else { *p };
        let after = skeleton.points.iter().map(grown).collect();
        take_shape(&mut skeleton, after, &areas);
        let centre = skeleton.joints[0].parent_frame.translation.vector;
        assert!((centre.x - 11.0).abs() < 0.35, "{centre}");
        // A path is as much longer as the bone along which it goes: not quite a tenth, by its long side.
        let path = skeleton.joints[0].path.as_ref().unwrap();
        assert!((path.at(1.0).translation.x - 2.2).abs() < 0.01, "{path:?}");
        assert!(centre.y.abs() < 1e-9);
    }
}
