//! Joint frames follow a change of their bone's shape.
//!
//! [G] section 3.4: the orientation follows the whole bone, the centre a rigid moving least-squares fit (Schaefer,
//! McPhail, Warren 2006); at the end ours is affine. The weights are area / distance^2: the paper's 1/distance
//! hardly localises on a surface.

use nalgebra::{Isometry3, Translation3};
use rayon::prelude::*;

use super::pose::{moved, rigid_targets};
use super::rotation::{best_rotation, renormalized};
use super::skeleton::Skeleton;
use crate::math::{Mat3, Vec3, median};

/// Share of the points' spread by which the affine fit is held to the rigid one: enough for what a flat bone
/// does not tell.
const HOLD: f64 = 1e-6;

/// Size of the rigid map against that of the skeleton's middle bone: joints that hold bones a little too close.
const CLOSER: f64 = 0.95;

/// How a joint point goes with the surface near it.
#[derive(Clone, Copy, Debug)]
pub enum Fit {
    /// As with a rigid body a little smaller than the skeleton's middle bone has become: it lags where the bone grows
    /// more than the others. So it draws a bone that is seen in part onto what there is of it, over which its neighbour
    /// would grow otherwise.
    Rigid,
    /// Affinely: where the bone's true shape has it.
    Affine,
}

/// Lets every bone of `skeleton` take its part of `shape`, where it lies: the template's bone, carried as well as a
/// rigid motion can, stays where it was. Joint frames and paths become those that the template's bones carry
/// into this shape, whatever shapes came between. `areas` are those of the template's vertices.
pub fn take_shape(
    skeleton: &mut Skeleton,
    template: &Skeleton,
    shape: &[Vec3],
    areas: &[f64],
    fit: Fit,
) {
    let motions = |to: &[Vec3]| -> Vec<Isometry3<f64>> {
        let motions = rigid_targets(template, &template.points, to, areas);
        motions.into_iter().map(Option::unwrap_or_default).collect()
    };
    let [lie, shaped] = [&skeleton.points, shape].map(motions);
    let put: Vec<Isometry3<f64>> = lie.iter().zip(&shaped).map(|(l, s)| l * s.inverse()).collect();
    let shapes = |b: usize| {
        let own = template.bones[b].vertices.clone();
        ([&template.points[own.clone()], &shape[own.clone()]], &areas[own])
    };
    let growths: Vec<f64> = (0..template.bones.len()).map(|b| growth(shapes(b))).collect();
    let middle = median(growths.iter().copied()).unwrap_or(1.0);
    let size = if matches!(fit, Fit::Rigid) { CLOSER * middle } else { middle };
    let carried = |b: usize, frame: &Isometry3<f64>| {
        let centre = carried_point(&frame.translation.vector, shapes(b), fit, size);
        let rotation = renormalized(lie[b].rotation * frame.rotation);
        Isometry3::from_parts(Translation3::from(moved(&put[b], &centre)), rotation)
    };
    let frames: Vec<[Isometry3<f64>; 2]> = template
        .joints
        .par_iter()
        .map(|j| [carried(j.parent, &j.parent_frame), carried(j.child, &j.child_frame)])
        .collect();
    let given = template.joints.iter().zip(frames);
    for (joint, (given, [parent_frame, child_frame])) in skeleton.joints.iter_mut().zip(given) {
        joint.parent_frame = parent_frame;
        joint.child_frame = child_frame;
        joint.path.clone_from(&given.path);
        if let Some(path) = &mut joint.path {
            path.scale(growths[given.parent]);
        }
    }
    for (bone, put) in template.bones.iter().zip(&put) {
        let own = bone.vertices.clone();
        let places = skeleton.points[own.clone()].iter_mut().zip(&shape[own]);
        places.for_each(|(place, point)| *place = moved(put, point));
    }
}

/// Where a point goes with points that go from `before` to `after`: the map that is best near it. `areas` are those
/// of `before`, `size` is that of the rigid map.
fn carried_point(
    centre: &Vec3,
    ([before, after], areas): ([&[Vec3]; 2], &[f64]),
    fit: Fit,
    size: f64,
) -> Vec3 {
    let far = before.iter().map(|p| (p - centre).norm_squared()).fold(0.0, f64::max);
    // A joint point that lies on a vertex would get an infinite weight.
    let weight = |p: &Vec3, area: &f64| area / ((p - centre).norm_squared() + 1e-12 * far);
    let weights: Vec<f64> = before.iter().zip(areas).map(|(p, area)| weight(p, area)).collect();
    let total: f64 = weights.iter().sum();
    let middle = |of: &[Vec3]| of.iter().zip(&weights).map(|(p, w)| p * *w).sum::<Vec3>() / total;
    let [from, to] = [middle(before), middle(after)];
    let about = |of: &[Vec3], middle: &Vec3| -> Mat3 {
        let places = before.iter().zip(of).zip(&weights);
        places.map(|((p, q), w)| *w * (q - middle) * (p - from).transpose()).sum()
    };
    let product = about(after, &to);
    let rigid = size * best_rotation(&product).unwrap_or_default().to_rotation_matrix().matrix();
    let map = match fit {
        Fit::Rigid => rigid,
        Fit::Affine => {
            let spread = about(before, &from);
            let hold = HOLD * spread.trace();
            let inverse = (spread + Mat3::identity() * hold).try_inverse();
            inverse.map_or(rigid, |inverse| (product + hold * rigid) * inverse)
        }
    };
    to + map * (centre - from)
}

/// How much larger a bone has become: the ratio of its radii of gyration.
fn growth((points, areas): ([&[Vec3]; 2], &[f64])) -> f64 {
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

    /// The largest difference in points and frames.
    fn far(one: &Skeleton, other: &Skeleton) -> f64 {
        let points = one.points.iter().zip(&other.points).map(|(p, q)| (p - q).norm());
        let frames = one.joints.iter().zip(&other.joints).flat_map(|(a, b)| {
            [a.parent_frame.inv_mul(&b.parent_frame), a.child_frame.inv_mul(&b.child_frame)]
        });
        let frames = frames.map(|f| f.translation.vector.norm() + f.rotation.angle());
        points.chain(frames).fold(0.0, f64::max)
    }

    #[test]
    fn the_templates_own_shape_changes_nothing_wherever_both_lie() {
        let template = bone();
        let areas = vertex_areas(&template.points, &template.triangles);
        let motion = |x: f64| Isometry3::new(Vec3::new(x, -2.0, 30.0), Vec3::new(0.4, -2.0, x));
        let mut skeleton = template.clone();
        skeleton.move_bones(&[motion(1.0), motion(3.0)]);
        let before = skeleton.clone();
        let elsewhere: Vec<Vec3> = template.points.iter().map(|p| moved(&motion(2.0), p)).collect();
        take_shape(&mut skeleton, &template, &elsewhere, &areas, Fit::Affine);
        assert!(far(&before, &skeleton) < 1e-9);
    }

    #[test]
    fn the_centre_follows_the_end_it_lies_in() {
        let mut skeleton = bone();
        let before = skeleton.clone();
        let areas = vertex_areas(&skeleton.points, &skeleton.triangles);
        // The first bone grows by a tenth, so its end goes from x = 10 to 11.
        let grown = |p: &Vec3| if p.x <= 10.5 { Vec3::new(p.x * 1.1, p.y, p.z) } else { *p };
        let after: Vec<Vec3> = skeleton.points.iter().map(grown).collect();
        take_shape(&mut skeleton, &before, &after, &areas, Fit::Affine);
        let centre = skeleton.joints[0].parent_frame.translation.vector;
        assert!((centre.x - 11.0).abs() < 1e-4, "{centre}");
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
        let astray: Vec<Vec3> = template.points.iter().map(|p| p + noise.vector()).collect();
        take_shape(&mut skeleton, &template, &astray, &areas, Fit::Affine);
        let grown: Vec<Vec3> = template.points.iter().map(|p| 1.4 * p).collect();
        take_shape(&mut skeleton, &template, &grown, &areas, Fit::Affine);
        let mut at_once = template.clone();
        take_shape(&mut at_once, &template, &grown, &areas, Fit::Affine);
        assert!(far(&skeleton, &at_once) < 1e-9);
        let centre = at_once.joints[0].parent_frame.translation.vector;
        assert!((centre - Vec3::new(14.0, 0.0, 0.0)).norm() < 1e-4, "{centre}");
    }

    #[test]
    fn joint_points_grow_as_the_skeleton_does_by_either_fit() {
        let mut template = bone();
        template.joints[0].parent_frame.translation.vector.x = 12.0;
        let areas = vertex_areas(&template.points, &template.triangles);
        let centre = |size: f64, fit: Fit| {
            let shape: Vec<Vec3> = template.points.iter().map(|p| size * p).collect();
            let mut skeleton = template.clone();
            take_shape(&mut skeleton, &template, &shape, &areas, fit);
            skeleton.joints[0].parent_frame.translation.vector
        };
        for fit in [Fit::Rigid, Fit::Affine] {
            let [usual, small] = [1.0, 0.6].map(|size| centre(size, fit));
            assert!((small - 0.6 * usual).norm() < 1e-9, "{fit:?}: {small} {usual}");
        }
        // In the loop a little too near to the bone's middle.
        let [rigid, affine] = [Fit::Rigid, Fit::Affine].map(|fit| centre(1.0, fit).x);
        assert!((affine - 12.0).abs() < 1e-9 && (11.5..11.95).contains(&rigid), "{rigid} {affine}");
    }
}
