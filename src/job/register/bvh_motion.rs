//! Motions of a skeleton as BVH trees and back.
//!
//! A BVH node turns about its origin, seen from its parent's axes; the skeleton as it lies is the pose
//! in which all turns are zero. Nodes carry the names of bones. Angles are those of the joints'
//! coordinates, so a motion that was made on one person fits another's frames.

use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion};

use crate::error::{Error, Result};
use crate::io::bvh::{BvhChannel, BvhDocument, BvhNode};
use crate::math::Vec3;
use crate::register::Skeleton;
use crate::register::animation::{Motion, animate, joint_angles};

/// A joint point that stays this near to its bone's neighbour, as a share of its distance from the
/// root's, needs no position channels.
const STILL: f64 = 1e-9;

/// A bone's place in the tree: the bone it hangs on and the point it turns about.
struct Hang {
    bone: usize,
    near: Option<usize>,
    pivot: Vec3,
}

/// The bones in the order of the tree from bone 0 on; parts that no joint connects hang on bone 0.
fn tree(skeleton: &Skeleton) -> Vec<Hang> {
    let mut hangs = vec![Hang { bone: 0, near: None, pivot: Vec3::zeros() }];
    let forest = skeleton.spanning_forest(0);
    let reached = |b: usize| {
        forest.iter().any(|&(j, to_child)| {
            let joint = &skeleton.joints[j];
            b == joint.ends(to_child).1
        })
    };
    let loose = (1..skeleton.bones.len()).filter(|&b| !reached(b));
    hangs.extend(loose.map(|bone| Hang { bone, near: Some(0), pivot: Vec3::zeros() }));
    for &(j, to_child) in &forest {
        let joint = &skeleton.joints[j];
        hangs.push(if to_child {
            let pivot = joint.child_frame.translation.vector;
            Hang { bone: joint.child, near: Some(joint.parent), pivot }
        } else {
            let pivot = joint.parent_frame.translation.vector;
            Hang { bone: joint.parent, near: Some(joint.child), pivot }
        });
    }
    hangs
}

/// The motion as a tree of the skeleton's bones, in the skeleton's unit and frame.
pub fn bvh_of_motion(skeleton: &Skeleton, motion: &Motion) -> Result<BvhDocument> {
    let poses = animate(skeleton, 0, motion)?;
    let hangs = tree(skeleton);
    let index = |b: usize| hangs.iter().position(|h| h.bone == b);
    let mut nodes = Vec::new();
    let mut frames = vec![Vec::new(); poses.len()];
    for hang in &hangs {
        let origin = hang.near.and_then(index).map_or(Vec3::zeros(), |n| hangs[n].pivot);
        let relative: Vec<Isometry3<f64>> = poses
            .iter()
            .map(|pose| {
                hang.near.map_or(pose[hang.bone], |near| pose[near].inv_mul(&pose[hang.bone]))
            })
            .collect();
        let offset = hang.pivot - origin;
        let moved = |motion: &Isometry3<f64>| (motion * nalgebra::Point3::from(hang.pivot)).coords;
        let wander = relative.iter().map(|m| (moved(m) - hang.pivot).norm()).fold(0.0, f64::max);
        let shifts = hang.near.is_none() || wander > STILL * offset.norm();
        let mut channels = Vec::new();
        if shifts {
            channels.extend([0, 1, 2].map(BvhChannel::Position));
        }
        channels.extend([2, 0, 1].map(BvhChannel::Rotation));
        for (frame, motion) in frames.iter_mut().zip(&relative) {
            if shifts {
                frame.extend((moved(motion) - origin).iter());
            }
            frame.extend(turns_zxy(&motion.rotation).map(f64::to_degrees));
        }
        let bone = &skeleton.bones[hang.bone];
        let end = middle(&skeleton.points[bone.vertices.clone()]) - hang.pivot;
        let is_last = !hangs.iter().any(|h| h.near == Some(hang.bone));
        nodes.push(BvhNode {
            name: bone.name.clone(),
            parent: hang.near.and_then(index),
            offset: offset.into(),
            channels,
            ends: if is_last { vec![(2.0 * end).into()] } else { Vec::new() },
        });
    }
    let frame_seconds = match motion.times.as_slice() {
        [first, .., last] => (last - first) / (motion.times.len() - 1) as f64,
        _ => 1.0 / 30.0,
    };
    Ok(in_file_order(&BvhDocument { nodes, frame_seconds, frames }))
}

fn middle(points: &[Vec3]) -> Vec3 {
    points.iter().sum::<Vec3>() / points.len().max(1) as f64
}

/// A file lists a node's children before its next sibling, and frames follow that order.
fn in_file_order(document: &BvhDocument) -> BvhDocument {
    let mut order = Vec::new();
    let mut left: Vec<usize> = vec![0];
    while let Some(n) = left.pop() {
        order.push(n);
        let children = (0..document.nodes.len()).rev();
        left.extend(children.filter(|&c| document.nodes[c].parent == Some(n)));
    }
    let starts: Vec<usize> = document
        .nodes
        .iter()
        .scan(0, |sum, n| Some(std::mem::replace(sum, *sum + n.channels.len())))
        .collect();
    let nodes = order.iter().map(|&n| {
        let node = &document.nodes[n];
        let parent = node.parent.and_then(|p| order.iter().position(|&o| o == p));
        BvhNode { parent, ..node.clone() }
    });
    let frames = document.frames.iter().map(|frame| {
        let part = |&n: &usize| &frame[starts[n]..starts[n] + document.nodes[n].channels.len()];
        order.iter().flat_map(part).copied().collect()
    });
    BvhDocument {
        nodes: nodes.collect(),
        frame_seconds: document.frame_seconds,
        frames: frames.collect(),
    }
}

/// The joint angles of a BVH motion whose nodes are named as the skeleton's bones; joints whose bones
/// it does not have keep their pose. `path` is for error messages.
pub fn motion_of_bvh(skeleton: &Skeleton, document: &BvhDocument, path: &Path) -> Result<Motion> {
    let bone_of: Vec<Option<usize>> =
        document.nodes.iter().map(|n| skeleton.bone_index(&n.name)).collect();
    let has = |b: usize| bone_of.contains(&Some(b));
    let joints: Vec<_> = skeleton
        .joints
        .iter()
        .filter(|j| !j.coordinates.is_empty() && has(j.parent) && has(j.child))
        .collect();
    if joints.is_empty() {
        return Err(Error::parse(
            path,
            None,
            format!(
                "no joint of the skeleton has both its bones in the motion; name its nodes as the bones, such as {}",
                skeleton.bones[0].name
            ),
        ));
    }
    let names = joints.iter().flat_map(|j| &j.coordinates).map(|c| c.name.clone()).collect();
    let mut motion = Motion { names, ..Motion::default() };
    for (k, frame) in document.frames.iter().enumerate() {
        let turns = world_turns(document, frame);
        let of = |b: usize| {
            let node = bone_of.iter().position(|own| *own == Some(b));
            node.map_or_else(UnitQuaternion::identity, |n| turns[n])
        };
        let angles = joints.iter().flat_map(|joint| {
            let parent = of(joint.parent) * joint.parent_frame.rotation;
            let child = of(joint.child) * joint.child_frame.rotation;
            joint_angles(joint, &(parent.inverse() * child))
        });
        motion.frames.push(angles.collect());
        motion.times.push(k as f64 * document.frame_seconds);
    }
    Ok(motion)
}

/// How every node is turned against the pose of zeros.
fn world_turns(document: &BvhDocument, frame: &[f64]) -> Vec<UnitQuaternion<f64>> {
    let mut turns: Vec<UnitQuaternion<f64>> = Vec::new();
    let mut values = frame.iter();
    for node in &document.nodes {
        let mut turn = node.parent.map_or_else(UnitQuaternion::identity, |p| turns[p]);
        for (channel, value) in node.channels.iter().zip(values.by_ref()) {
            if let BvhChannel::Rotation(axis) = channel {
                turn *= UnitQuaternion::from_scaled_axis(Vec3::ith(*axis, value.to_radians()));
            }
        }
        turns.push(turn);
    }
    turns
}

/// Angles about z, then the turned x, then the turned y.
fn turns_zxy(rotation: &UnitQuaternion<f64>) -> [f64; 3] {
    let r: Matrix3<f64> = Rotation3::from(*rotation).into_inner();
    let x = libm::asin(r.m32.clamp(-1.0, 1.0));
    if r.m32.abs() > 1.0 - 1e-14 {
        return [libm::atan2(r.m21, r.m11), x, 0.0];
    }
    [libm::atan2(-r.m12, r.m22), x, libm::atan2(-r.m31, r.m33)]
}

#[cfg(test)]
mod tests {
    use nalgebra::Translation3;

    use super::*;
    use crate::io::bvh::{bvh_text, parse_bvh};
    use crate::mesh::TriMesh;
    use crate::register::{Coordinate, Joint, JointLimits};

    /// A motion's bones as rigid motions, for checks of a file against the skeleton.
    fn bvh_poses(skeleton: &Skeleton, document: &BvhDocument, frame: usize) -> Vec<Isometry3<f64>> {
        let mut poses: Vec<Isometry3<f64>> = Vec::new();
        let mut origins: Vec<Vec3> = Vec::new();
        let mut values = document.frames[frame].iter();
        for node in &document.nodes {
            let near = node.parent.map_or_else(Isometry3::identity, |p| poses[p]);
            let base = node.parent.map_or_else(Vec3::zeros, |p| origins[p]);
            let origin = base + Vec3::from(node.offset);
            let (mut shift, mut turn) = (origin, UnitQuaternion::identity());
            for (channel, value) in node.channels.iter().zip(values.by_ref()) {
                match channel {
                    BvhChannel::Position(axis) => shift[*axis] = base[*axis] + value,
                    BvhChannel::Rotation(axis) => {
                        turn *=
                            UnitQuaternion::from_scaled_axis(Vec3::ith(*axis, value.to_radians()));
                    }
                }
            }
            let own = Translation3::from(shift) * turn * Translation3::from(-origin);
            poses.push(near * own);
            origins.push(origin);
        }
        let of = |name: &str| document.nodes.iter().position(|n| n.name == *name).map(|n| poses[n]);
        skeleton.bones.iter().map(|b| of(&b.name).unwrap_or_else(Isometry3::identity)).collect()
    }

    /// A trunk with two arms, one of them two bones long, joints in a general place; the second arm's
    /// joint names the arm as parent.
    fn puppet() -> Skeleton {
        let bone = |name: &str, at: Vec3| {
            let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()].map(|c| c + at);
            let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
            (name.to_string(), TriMesh::new(corners.to_vec(), faces).unwrap())
        };
        let free = Vec3::repeat(f64::INFINITY);
        let limits = JointLimits::new(free, free, 1.0).unwrap();
        let joint = |name: &str, parent, child, at: Vec3, axes: &[[f64; 3]]| Joint {
            name: name.into(),
            parent,
            child,
            parent_frame: Isometry3::new(at, Vec3::new(0.3, -0.2, 0.9)),
            child_frame: Isometry3::new(at + Vec3::new(0.1, 0.0, 0.0), Vec3::new(0.3, -0.2, 0.9)),
            limits,
            in_tree: true,
            coordinates: axes
                .iter()
                .enumerate()
                .map(|(k, a)| Coordinate {
                    name: format!("{name}{k}"),
                    axis: Vec3::from(*a).normalize(),
                    range: [-3.0, 3.0],
                })
                .collect(),
            path: None,
        };
        let at = |x: f64| Vec3::new(x, 0.5 * x, 1.0);
        let bones = ["trunk", "left arm", "left_hand", "right"];
        let surfaces = bones.iter().zip([0.0, 3.0, 6.0, -3.0]).map(|(b, x)| bone(b, at(x)));
        let three = [[1.0, 0.1, 0.0], [0.0, 1.0, 0.2], [0.0, 0.0, 1.0]];
        let joints = vec![
            joint("elbow", 1, 2, at(5.0), &[[0.2, 1.0, 0.0]]),
            joint("shoulder", 0, 1, at(2.0), &three),
            joint("other", 3, 0, at(-1.5), &three[..2]),
        ];
        Skeleton::new(surfaces.collect(), joints).unwrap()
    }

    #[test]
    fn a_motion_goes_through_a_file_and_comes_back() {
        let puppet = puppet();
        let names: Vec<String> =
            puppet.joints.iter().flat_map(|j| &j.coordinates).map(|c| c.name.clone()).collect();
        let row = |k: i32| (0..6).map(|c| libm::sin(f64::from(k * 6 + c) * 0.7) * 0.8).collect();
        let frames: Vec<Vec<f64>> = (0..5).map(row).collect();
        let times = (0..5).map(|k| f64::from(k) * 0.04).collect();
        let motion = Motion { names: names.clone(), times, frames };
        let document = bvh_of_motion(&puppet, &motion).unwrap();
        let path = Path::new("a.bvh");
        let again = parse_bvh(bvh_text(&document).as_bytes(), path).unwrap();
        let poses = animate(&puppet, 0, &motion).unwrap();
        for (k, pose) in poses.iter().enumerate() {
            // Spaces in names do not survive.
            let mut renamed = puppet.clone();
            renamed.bones[1].name = "left_arm".into();
            for (a, b) in pose.iter().zip(bvh_poses(&renamed, &again, k)) {
                let apart = a.inv_mul(&b);
                assert!(apart.translation.vector.norm() < 1e-9 && apart.rotation.angle() < 1e-9);
            }
            let found = motion_of_bvh(&renamed, &again, path).unwrap();
            assert!((found.times[k] - motion.times[k]).abs() < 1e-12);
            for (name, value) in found.names.iter().zip(&found.frames[k]) {
                let column = names.iter().position(|n| n == name).unwrap();
                assert!((value - motion.frames[k][column]).to_degrees().abs() < 1e-6, "{name}");
            }
        }
        let mut foreign = again;
        for node in &mut foreign.nodes {
            node.name.push('x');
        }
        let error = motion_of_bvh(&puppet, &foreign, path).unwrap_err().to_string();
        assert!(error.contains("trunk"), "{error}");
    }
}
