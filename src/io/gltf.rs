//! Skeletons for viewers: binary glTF 2.0 (`.glb`) with one node and mesh per bone and a motion.
//!
//! glTF has no joint limits; they go into `extras` of the bone's node, which Blender shows as
//! custom properties. Its unit is the metre and its up axis is y, so the scene's root node turns
//! and scales the skeleton, whose z axis is taken to point up (RAS or LPS).

use std::path::Path;

use nalgebra::Isometry3;
use serde_json::{Value, json};

use super::write_beside;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::mesh::TriMesh;

/// Component types and targets of glTF.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

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

/// A scene.
#[derive(Clone, Debug)]
pub struct GltfScene {
    /// Nodes, parents first.
    pub nodes: Vec<GltfNode>,
    /// Seconds of the motion's frames.
    pub times: Vec<f64>,
    /// Metres per unit of the points, such as 0.001.
    pub metres_per_unit: f64,
}

#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view =
            json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Rows of `WIDTH` floats with their bounds.
    fn floats<const WIDTH: usize>(
        &mut self,
        rows: &[[f32; WIDTH]],
        kind: &str,
        target: Option<u32>,
    ) -> usize {
        let bytes: Vec<u8> = rows.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, target);
        let bound = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..WIDTH).map(|k| rows.iter().map(|r| r[k]).reduce(pick).unwrap_or(0.0)).collect()
        };
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": rows.len(), "type": kind,
            "min": bound(f32::min), "max": bound(f32::max)
        }));
        self.accessors.len() - 1
    }

    fn indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let bytes: Vec<u8> = triangles.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_INT,
            "count": 3 * triangles.len(), "type": "SCALAR"
        }));
        self.accessors.len() - 1
    }
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
        meshes.push(mesh_entry(&mut buffer, node));
    }
    let animation = animation(&mut buffer, scene)?;
    let mut document = json!({
        "asset": {"version": "2.0", "generator": concat!("moulage ", env!("CARGO_PKG_VERSION"))},
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes, "meshes": meshes,
        "accessors": buffer.accessors, "bufferViews": buffer.views,
        "buffers": [{"byteLength": buffer.bytes.len()}]
    });
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

fn mesh_entry(buffer: &mut Buffer, node: &GltfNode) -> Value {
    let rows = |points: &[Vec3]| -> Vec<[f32; 3]> {
        points.iter().map(|p| p.map(|x| x as f32).into()).collect()
    };
    let mut normals = node.mesh.vertex_normals();
    for normal in normals.iter_mut().filter(|n| n.norm_squared() < 0.5) {
        *normal = Vec3::z();
    }
    let position = buffer.floats(&rows(&node.mesh.points), "VEC3", Some(ARRAY_BUFFER));
    let normal = buffer.floats(&rows(&normals), "VEC3", Some(ARRAY_BUFFER));
    let indices = buffer.indices(&node.mesh.triangles);
    json!({"name": node.name, "primitives": [
        {"attributes": {"POSITION": position, "NORMAL": normal}, "indices": indices}
    ]})
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
        scene.times.push(2.0);
        assert!(glb_bytes(&scene).is_err());
    }
}
