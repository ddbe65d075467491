//! Skeletons for viewers: binary glTF 2.0 (`.glb`) with one node and mesh per bone, soft tissues as skins,
//! and a motion.
//!
//! glTF has no joint limits; they go into `extras` of the bone's node, which Blender shows as
//! custom properties. Its unit is the metre and its up axis is y, so the scene's root node turns
//! and scales the skeleton, whose z axis is taken to point up (RAS or LPS).

use std::path::Path;

use nalgebra::Isometry3;
use serde_json::{Value, json};

use super::gltf_buffer::{Buffer, VERTEX};
use super::write_beside;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// Nodes that carry a vertex at most.
const NODES_OF_VERTEX: usize = 4;
/// Places of the materials in the file.
const BONE: usize = 0;
const TISSUE: usize = 1;

/// One node with its mesh.
#[derive(Clone, Debug)]
pub struct GltfNode {
    /// Name.
    pub name: String,
    /// Index of the node it hangs on; must be lower than its own.
    pub parent: Option<usize>,
    /// Parent from node.
    pub local: Isometry3<f64>,
    /// Mesh in the node's own frame.
    pub mesh: TriMesh,
    /// Anything more; null for nothing.
    pub extras: Value,
    /// Parent from node at every time of the motion; empty = still.
    pub track: Vec<Isometry3<f64>>,
}

/// A surface that bends with several nodes.
#[derive(Clone, Debug)]
pub struct GltfSkin {
    /// Name.
    pub name: String,
    /// Mesh where it lies while all nodes are as their `local` says, in the frame of nodes without parent.
    pub mesh: TriMesh,
    /// For each vertex up to four nodes and how much each carries it: positive, sum 1.
    pub weights: Vec<Vec<(usize, f64)>>,
}

/// A scene.
#[derive(Clone, Debug)]
pub struct GltfScene {
    /// Nodes, parents first.
    pub nodes: Vec<GltfNode>,
    /// Surfaces that bend with the nodes.
    pub skins: Vec<GltfSkin>,
    /// Seconds of the motion's frames.
    pub times: Vec<f64>,
    /// Metres per unit of the points, such as 0.001.
    pub metres_per_unit: f64,
}

fn translation(frame: &Isometry3<f64>) -> [f32; 3] {
    frame.translation.vector.map(|x| x as f32).into()
}

/// Quaternion x, y, z, w.
fn rotation(frame: &Isometry3<f64>) -> [f32; 4] {
    frame.rotation.coords.map(|x| x as f32).into()
}

/// Writes a `.glb` file.
pub fn write_glb(path: &Path, scene: &GltfScene) -> Result<()> {
    let bytes = glb_bytes(scene)?;
    write_beside(path, |out| out.write_all(&bytes))
}

/// The bytes of a `.glb` file.
pub fn glb_bytes(scene: &GltfScene) -> Result<Vec<u8>> {
    let mut buffer = Buffer::default();
    let mut nodes = vec![root_node(scene)];
    let mut meshes = Vec::new();
    for node in &scene.nodes {
        let mut entry = json!({
            "name": node.name, "translation": translation(&node.local),
            "rotation": rotation(&node.local), "mesh": meshes.len()
        });
        if !node.extras.is_null() {
            entry["extras"] = node.extras.clone();
        }
        let own = nodes.len();
        let children: Vec<usize> = (0..scene.nodes.len())
            .filter(|&k| scene.nodes[k].parent == Some(own - 1))
            .map(|k| k + 1)
            .collect();
        if !children.is_empty() {
            entry["children"] = json!(children);
        }
        nodes.push(entry);
        let primitive = primitive(&mut buffer, &node.mesh, BONE);
        meshes.push(json!({"name": node.name, "primitives": [primitive]}));
    }
    // A skinned mesh is drawn where its joints are; its own node is a root that does not matter.
    let mut roots = vec![0];
    for skin in &scene.skins {
        roots.push(nodes.len());
        nodes.push(json!({"name": skin.name, "mesh": meshes.len(), "skin": 0}));
        let mut primitive = primitive(&mut buffer, &skin.mesh, TISSUE);
        add_weights(&mut buffer, skin, scene.nodes.len(), &mut primitive)?;
        meshes.push(json!({"name": skin.name, "primitives": [primitive]}));
    }
    let skin = (!scene.skins.is_empty()).then(|| skin_entry(&mut buffer, scene));
    let animation = animation(&mut buffer, scene)?;
    let mut document = json!({
        "asset": {"version": "2.0", "generator": concat!("moulage ", env!("CARGO_PKG_VERSION"))},
        "scene": 0, "scenes": [{"nodes": roots}], "nodes": nodes, "meshes": meshes,
        "materials": materials(!scene.skins.is_empty()),
        "accessors": buffer.accessors, "bufferViews": buffer.views,
        "buffers": [{"byteLength": buffer.bytes.len()}]
    });
    if let Some(skin) = skin {
        document["skins"] = json!([skin]);
    }
    if let Some(animation) = animation {
        document["animations"] = json!([animation]);
    }
    container(&document, &buffer.bytes)
}

/// Turns z up into y up and the unit into metres.
fn root_node(scene: &GltfScene) -> Value {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let roots: Vec<usize> = (0..scene.nodes.len())
        .filter(|&k| scene.nodes[k].parent.is_none())
        .map(|k| k + 1)
        .collect();
    json!({
        "name": "skeleton", "children": roots, "rotation": [-half, 0.0, 0.0, half],
        "scale": vec![scene.metres_per_unit; 3]
    })
}

/// Ivory for bones; tissue lets them shine through.
fn materials(tissue: bool) -> Value {
    let material = |name: &str, color: [f64; 4]| {
        json!({"name": name, "pbrMetallicRoughness": {
            "baseColorFactor": color, "metallicFactor": 0.0, "roughnessFactor": 0.7
        }})
    };
    let mut list = vec![material("bone", [0.85, 0.78, 0.63, 1.0])];
    if tissue {
        let mut soft = material("tissue", [0.62, 0.20, 0.16, 0.6]);
        soft["alphaMode"] = json!("BLEND");
        list.push(soft);
    }
    json!(list)
}

/// Positions, normals and triangles.
fn primitive(buffer: &mut Buffer, mesh: &TriMesh, material: usize) -> Value {
    let rows = |points: &[Vec3]| -> Vec<[f32; 3]> {
        points.iter().map(|p| p.map(|x| x as f32).into()).collect()
    };
    let mut normals = mesh.vertex_normals();
    for normal in normals.iter_mut().filter(|n| n.norm_squared() < 0.5) {
        *normal = Vec3::z();
    }
    let position = buffer.floats(&rows(&mesh.points), "VEC3", Some(VERTEX));
    let normal = buffer.floats(&rows(&normals), "VEC3", Some(VERTEX));
    let indices = buffer.indices(&mesh.triangles);
    let attributes = json!({"POSITION": position, "NORMAL": normal});
    json!({"attributes": attributes, "indices": indices, "material": material})
}

fn add_weights(
    buffer: &mut Buffer,
    skin: &GltfSkin,
    node_count: usize,
    primitive: &mut Value,
) -> Result<()> {
    let name = &skin.name;
    if skin.weights.len() != skin.mesh.points.len() {
        return Err(Error::invalid(format!("{name}: a row of weights is needed for each vertex")));
    }
    let wrong = |row: &Vec<(usize, f64)>| {
        row.is_empty() || row.len() > NODES_OF_VERTEX || row.iter().any(|(k, _)| *k >= node_count)
    };
    if node_count > usize::from(u16::MAX) || skin.weights.iter().any(wrong) {
        return Err(Error::invalid(format!("{name}: one to four of 65,535 nodes carry a vertex")));
    }
    let mut joints = Vec::with_capacity(skin.weights.len());
    let mut weights = Vec::with_capacity(skin.weights.len());
    for row in &skin.weights {
        let (mut nodes, mut shares) = ([0_u16; NODES_OF_VERTEX], [0.0_f32; NODES_OF_VERTEX]);
        for (k, &(node, share)) in row.iter().enumerate() {
            (nodes[k], shares[k]) = (node as u16, share as f32);
        }
        // The rounded shares sum to one as well.
        shares[0] = 1.0 - shares[1..].iter().sum::<f32>();
        joints.push(nodes);
        weights.push(shares);
    }
    primitive["attributes"]["JOINTS_0"] = buffer.shorts(&joints, "VEC4").into();
    primitive["attributes"]["WEIGHTS_0"] = buffer.floats(&weights, "VEC4", Some(VERTEX)).into();
    Ok(())
}

/// All nodes as joints, each with the inverse of its frame.
fn skin_entry(buffer: &mut Buffer, scene: &GltfScene) -> Value {
    let mut world: Vec<Isometry3<f64>> = Vec::with_capacity(scene.nodes.len());
    for node in &scene.nodes {
        world.push(node.parent.map_or(node.local, |parent| world[parent] * node.local));
    }
    let inverse: Vec<[f32; 16]> = world
        .iter()
        .map(|frame| {
            let columns = frame.inverse().to_homogeneous();
            std::array::from_fn(|k| columns.as_slice()[k] as f32)
        })
        .collect();
    let joints: Vec<usize> = (1..=scene.nodes.len()).collect();
    json!({
        "name": "skeleton", "joints": joints, "skeleton": 0,
        "inverseBindMatrices": buffer.floats(&inverse, "MAT4", None)
    })
}

fn animation(buffer: &mut Buffer, scene: &GltfScene) -> Result<Option<Value>> {
    if scene.times.is_empty() {
        return Ok(None);
    }
    let first = scene.times[0];
    let times: Vec<[f32; 1]> = scene.times.iter().map(|t| [(t - first) as f32]).collect();
    let input = buffer.floats(&times, "SCALAR", None);
    let (mut samplers, mut channels) = (Vec::new(), Vec::new());
    for (k, node) in scene.nodes.iter().enumerate().filter(|(_, n)| !n.track.is_empty()) {
        if node.track.len() != scene.times.len() {
            return Err(Error::invalid(format!(
                "node {} has {} poses for {} times",
                node.name,
                node.track.len(),
                scene.times.len()
            )));
        }
        let shifts: Vec<_> = node.track.iter().map(translation).collect();
        let turns: Vec<_> = node.track.iter().map(rotation).collect();
        let outputs = [
            ("translation", buffer.floats(&shifts, "VEC3", None)),
            ("rotation", buffer.floats(&turns, "VEC4", None)),
        ];
        for (what, output) in outputs {
            channels
                .push(json!({"sampler": samplers.len(), "target": {"node": k + 1, "path": what}}));
            samplers.push(json!({"input": input, "output": output, "interpolation": "LINEAR"}));
        }
    }
    Ok((!channels.is_empty()).then(|| json!({"samplers": samplers, "channels": channels})))
}

/// Header, JSON chunk and binary chunk.
fn container(document: &Value, binary: &[u8]) -> Result<Vec<u8>> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + text.len() + 8 + binary.len();
    let size = |n: usize| {
        u32::try_from(n).map(u32::to_le_bytes).map_err(|_| {
            Error::Unsupported(
                "the scene is larger than the 4 GB of a .glb file; write fewer frames".into(),
            )
        })
    };
    let mut bytes = Vec::with_capacity(length);
    bytes.extend_from_slice(b"glTF");
    bytes.extend_from_slice(&2_u32.to_le_bytes());
    bytes.extend_from_slice(&size(length)?);
    bytes.extend_from_slice(&size(text.len())?);
    bytes.extend_from_slice(b"JSON");
    bytes.extend_from_slice(&text);
    bytes.extend_from_slice(&size(binary.len())?);
    bytes.extend_from_slice(b"BIN\0");
    bytes.extend_from_slice(binary);
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_has_the_chunks_and_counts_it_promises() {
        let points = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]].map(Vec3::from).to_vec();
        let mesh = TriMesh::new(points, vec![[0, 1, 2]]).unwrap();
        let node = |name: &str, parent| GltfNode {
            name: name.into(),
            parent,
            local: Isometry3::translation(1.0, 2.0, 3.0),
            mesh: mesh.clone(),
            extras: json!({"limit": 3}),
            track: vec![Isometry3::identity(); 2],
        };
        let mut scene = GltfScene {
            nodes: vec![node("a", None), node("b", Some(0))],
            skins: vec![GltfSkin {
                name: "skin".into(),
                mesh: mesh.clone(),
                weights: vec![vec![(0, 0.7), (1, 0.3)], vec![(1, 1.0)], vec![(0, 1.0)]],
            }],
            times: vec![0.5, 1.0],
            metres_per_unit: 0.001,
        };
        let bytes = glb_bytes(&scene).unwrap();
        assert_eq!(u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize, bytes.len());
        let text = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let document: Value = serde_json::from_slice(&bytes[20..20 + text]).unwrap();
        assert_eq!(document["nodes"][1]["children"], json!([2]));
        assert_eq!(document["nodes"][2]["extras"]["limit"], 3);
        assert_eq!(document["animations"][0]["channels"].as_array().unwrap().len(), 4);
        let views = document["bufferViews"].as_array().unwrap();
        let end = views
            .iter()
            .map(|v| v["byteOffset"].as_u64().unwrap() + v["byteLength"].as_u64().unwrap());
        assert!(end.max().unwrap() <= document["buffers"][0]["byteLength"].as_u64().unwrap());
        assert_eq!(document["skins"][0]["joints"], json!([1, 2]));
        assert_eq!(document["scenes"][0]["nodes"], json!([0, 3]));
        scene.skins[0].weights[2] = vec![(2, 1.0)];
        assert!(glb_bytes(&scene).is_err());
        scene.skins.clear();
        scene.times.push(2.0);
        assert!(glb_bytes(&scene).is_err());
    }
}
