//! A skeleton as a scene of glTF.

use nalgebra::Isometry3;
use serde_json::json;

use crate::error::Result;
use crate::io::gltf::{GltfNode, GltfScene, GltfSkin};
use crate::math::Vec3;
use crate::mesh::TriMesh;
use crate::register::Skeleton;
use crate::register::animation::{Motion, animate};
use crate::register::skin::{Carriers, skin_weights};

/// Metres per unit of a skeleton file that says its unit; millimetres otherwise.
pub fn metres_per_unit(units: Option<&str>) -> f64 {
    match units {
        Some("m") => 1.0,
        Some("cm") => 0.01,
        _ => 0.001,
    }
}

/// A soft tissue in the pose of its skeleton.
#[derive(Clone, Debug, PartialEq)]
pub struct Tissue {
    /// Its name.
    pub name: String,
    /// Its surface.
    pub mesh: TriMesh,
}

/// The skeleton as a tree of nodes, each in the frame of the joint it hangs on, and soft tissues that bend
/// with it.
pub fn scene(
    skeleton: &Skeleton,
    tissues: &[Tissue],
    motion: Option<&Motion>,
    metres_per_unit: f64,
) -> Result<GltfScene> {
    let forest = skeleton.spanning_forest(0);
    let mut frame = vec![Isometry3::identity(); skeleton.bones.len()];
    let mut hangs: Vec<Option<(usize, usize)>> = vec![None; skeleton.bones.len()];
    let mut order: Vec<usize> = Vec::new();
    for &(j, to_child) in &forest {
        let joint = &skeleton.joints[j];
        let (near, far, own) = if to_child {
            (joint.parent, joint.child, joint.child_frame)
        } else {
            (joint.child, joint.parent, joint.parent_frame)
        };
        frame[far] = own;
        hangs[far] = Some((near, j));
        order.push(far);
    }
    let roots: Vec<usize> = (0..skeleton.bones.len()).filter(|&b| hangs[b].is_none()).collect();
    let order: Vec<usize> = roots.into_iter().chain(order).collect();
    let node_of = |bone: usize| order.iter().position(|&b| b == bone);
    let poses = motion.map(|m| animate(skeleton, 0, m)).transpose()?.unwrap_or_default();
    let nodes = order.iter().map(|&b| {
        let local = |motions: Option<&Vec<Isometry3<f64>>>| {
            let world = |b: usize| motions.map_or(frame[b], |m| m[b] * frame[b]);
            hangs[b].map_or_else(|| world(b), |(near, _)| world(near).inv_mul(&world(b)))
        };
        let mut mesh = skeleton.bone_surface(b, &skeleton.points);
        for p in &mut mesh.points {
            *p = frame[b].inverse_transform_point(&(*p).into()).coords;
        }
        GltfNode {
            name: skeleton.bones[b].name.clone(),
            parent: hangs[b].and_then(|(near, _)| node_of(near)),
            local: local(None),
            mesh,
            extras: hangs[b].map_or(serde_json::Value::Null, |(_, j)| limits_value(skeleton, j)),
            track: poses.iter().map(|p| local(Some(p))).collect(),
        }
    });
    let nodes = nodes.collect();
    let mut skins = if tissues.is_empty() { Vec::new() } else { skins(skeleton, tissues)? };
    for (bone, _) in skins.iter_mut().flat_map(|skin| &mut skin.weights).flatten() {
        *bone = node_of(*bone).unwrap_or_default();
    }
    let times = motion.map(|m| m.times.clone()).unwrap_or_default();
    Ok(GltfScene { nodes, skins, times, metres_per_unit })
}

/// The tissues with the bones that carry them.
fn skins(skeleton: &Skeleton, tissues: &[Tissue]) -> Result<Vec<GltfSkin>> {
    let carriers = Carriers::new(skeleton);
    let skin = |Tissue { name, mesh }: &Tissue| {
        let weights = skin_weights(&carriers, mesh)?;
        Ok(GltfSkin { name: name.clone(), mesh: mesh.clone(), weights })
    };
    tissues.iter().map(skin).collect()
}

fn limits_value(skeleton: &Skeleton, j: usize) -> serde_json::Value {
    let joint = &skeleton.joints[j];
    let degrees =
        |v: &Vec3| v.iter().map(|x| x.is_finite().then(|| x.to_degrees())).collect::<Vec<_>>();
    json!({"joint": joint.name, "limits": {
        "neg_deg": degrees(&joint.limits.negative), "pos_deg": degrees(&joint.limits.positive),
        "shift": joint.limits.shift, "shape": "ellipsoid"
    }})
}
