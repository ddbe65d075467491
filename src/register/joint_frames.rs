//! Joint frames follow a change of their bone's shape.
//!
//! [G] section 3.4: the orientation follows the whole bone, the centre a moving least-squares fit (Schaefer,
//! McPhail, Warren 2006). The paper's fit is rigid; ours is affine, so that the centre of a head that has grown
//! stays its centre. The weights are area / distance^2: the paper's 1/distance hardly localises on a surface.

use nalgebra::{Isometry3, Translation3};
use rayon::prelude::*;

use super::rotation::{PairSums, best_rotation, renormalized};
use super::skeleton::Skeleton;
use crate::math::{Mat3, Vec3};

/// Share of the points' spread by which the affine fit is held to the rigid one: enough for what a flat bone
/// does not tell.
const HOLD: f64 = 1e-4;

/// A joint frame on a bone whose vertices go from `before` to `after`; `areas` are those of `before`.
fn carried(
    frame: &Isometry3<f64>,
    [before, after]: [&[Vec3]; 2],
    areas: &[f64],
) -> Option<Isometry3<f64>> {
    let centre = frame.translation.vector;
    let mut whole = PairSums::new(centre);
    for ((from, to), area) in before.iter().zip(after).zip(areas) {
        whole.add(from, to, *area);
    }
    let rotation = renormalized(whole.best_rigid()?.rotation * frame.rotation);
    let place = carried_point(&centre, [before, after], areas)?;
    Some(Isometry3::from_parts(Translation3::from(place), rotation))
}

/// The same of a point: the affine map that is best near it.
fn carried_point(centre: &Vec3, [before, after]: [&[Vec3]; 2], areas: &[f64]) -> Option<Vec3> {
    let far = before.iter().map(|p| (p - centre).norm_squared()).fold(0.0, f64::max);
    // A joint point that lies on a vertex would get an infinite weight.
    let weight = |p: &Vec3, area: &f64| area / ((p - centre).norm_squared() + 1e-12 * far);
    let weights: Vec<f64> = before.iter().zip(areas).map(|(p, area)| weight(p, area)).collect();
    let total: f64 = weights.iter().sum();
    let middle = |of: &[Vec3]| of.iter().zip(&weights).map(|(p, w)| p * *w).sum::<Vec3>() / total;
    let [from, to] = [middle(before), middle(after)];
    let (mut product, mut spread) = (Mat3::zeros(), Mat3::zeros());
    for ((p, q), weight) in before.iter().zip(after).zip(&weights) {
        product += *weight * (q - to) * (p - from).transpose();
        spread += *weight * (p - from) * (p - from).transpose();
    }
    let rigid = best_rotation(&product).unwrap_or_default().to_rotation_matrix();
    let hold = HOLD * spread.trace();
    let map =
        (product + hold * rigid.matrix()) * (spread + Mat3::identity() * hold).try_inverse()?;
    Some(to + map * (centre - from))
}

/// Lets `skeleton` take the shape `after` of the template's bones. Its joint frames and paths become those of
/// the template as bones of this shape carry them, whatever shapes came between.
pub fn take_shape(skeleton: &mut Skeleton, template: &Skeleton, after: Vec<Vec3>, areas: &[f64]) {
    let follow = |b: usize, frame: &Isometry3<f64>| {
        let own = template.bones[b].vertices.clone();
        let shapes = [&template.points[own.clone()], &after[own.clone()]];
        carried(frame, shapes, &areas[own]).unwrap_or(*frame)
    };
    let frames: Vec<[Isometry3<f64>; 2]> = template
        .joints
        .par_iter()
        .map(|j| [follow(j.parent, &j.parent_frame), follow(j.child, &j.child_frame)])
        .collect();
    let given = template.joints.iter().zip(frames);
    for (joint, (given, [parent_frame, child_frame])) in skeleton.joints.iter_mut().zip(given) {
        joint.parent_frame = parent_frame;
        joint.child_frame = child_frame;
        joint.path.clone_from(&given.path);
        if let Some(path) = &mut joint.path {
            let own = template.bones[given.parent].vertices.clone();
            path.scale(growth([&template.points[own.clone()], &after[own.clone()]], &areas[own]));
        }
    }
    skeleton.points = after;
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
    use crate::locate::test_shapes::Noise;
    use crate::register::areas::vertex_areas;
    use crate::register::joint_limits::JointLimits;
    use crate::register::joint_path::JointPath;
    use crate::register::pose::moved;
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
        take_shape(&mut skeleton, &before, points, &areas);
        let still = before.joints[0].parent_frame.inv_mul(&skeleton.joints[0].parent_frame);
        assert!(still.translation.vector.norm() < 1e-12 && still.rotation.angle() < 1e-12);
        let motion = Isometry3::new(Vec3::new(3.0, -2.0, 30.0), Vec3::new(0.4, -2.0, 1.1));
        let after = before.points.iter().map(|p| moved(&motion, p)).collect();
        take_shape(&mut skeleton, &before, after, &areas);
        let rest = (motion * before.joints[0].child_frame).inv_mul(&skeleton.joints[0].child_frame);
        assert!(rest.translation.vector.norm() < 1e-9 && rest.rotation.angle() < 1e-9);
    }

    #[test]
    fn the_centre_follows_the_end_it_lies_in() {
        let mut skeleton = bone();
        let before = skeleton.clone();
        let areas = vertex_areas(&skeleton.points, &skeleton.triangles);
        // The first bone grows by a tenth, so its end goes from x = 10 to 11.
        let grown = |p: &Vec3| if p.x <= 10.5 { Vec3::new(p.x * 1.1, p.y, p.z) } else { *p };
        let after = skeleton.points.iter().map(grown).collect();
        take_shape(&mut skeleton, &before, after, &areas);
        let centre = skeleton.joints[0].parent_frame.translation.vector;
        assert!((centre.x - 11.0).abs() < 1e-3, "{centre}");
        // A path is as much longer as the bone along which it goes: not quite a tenth, by its long side.
        let path = skeleton.joints[0].path.as_ref().unwrap();
        assert!((path.at(1.0).translation.x - 2.2).abs() < 0.01, "{path:?}");
        assert!(centre.y.abs() < 1e-9);
    }

    #[test]
    fn frames_depend_on_the_shape_and_not_on_the_shapes_between() {
        let template = bone();
        let areas = vertex_areas(&template.points, &template.triangles);
        let mut skeleton = template.clone();
        let mut noise = Noise::new(3);
        let astray = template.points.iter().map(|p| p + noise.vector()).collect();
        take_shape(&mut skeleton, &template, astray, &areas);
        let grown: Vec<Vec3> = template.points.iter().map(|p| 1.4 * p).collect();
        take_shape(&mut skeleton, &template, grown.clone(), &areas);
        let mut at_once = template.clone();
        take_shape(&mut at_once, &template, grown, &areas);
        assert_eq!(skeleton, at_once);
        let centre = skeleton.joints[0].parent_frame.translation.vector;
        assert!((centre - Vec3::new(14.0, 0.0, 0.0)).norm() < 1e-3, "{centre}");
    }
}
