//! OpenSim models (`.osim`, version 4): bodies with meshes become bones, joints keep their frames.
//!
//! Lengths are metres in the file and stay metres. Meshes are placed by the frames of the model's
//! default pose, so the importer also says where each body lies. Rotations of a joint that are
//! coupled, or more than one about general axes, become an ellipsoid of rotation vectors, which is
//! an approximation of OpenSim's separate ranges.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use super::skeleton::{
    BoneEntry, CoordinateEntry, FORMAT, FrameEntry, JointEntry, LimitsEntry, SidesEntry,
    SkeletonDocument, VERSION,
};
use crate::error::{Error, Result};

/// A range beyond this many radians means free in OpenSim.
const FREE: f64 = 100.0;
/// Rotation allowed about an axis without a coordinate, degrees.
const OFF_AXIS_DEGREES: f64 = 3.0;

/// An imported model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OsimModel {
    /// Bones and joints; frames in world coordinates of the default pose, metres. `mesh` is the
    /// body's first mesh file as the model names it.
    pub document: SkeletonDocument,
    /// World from body in the default pose, for every bone.
    pub world_from_body: Vec<Isometry3<f64>>,
    /// Scale factors of every bone's mesh.
    pub mesh_scale: Vec<[f64; 3]>,
    /// All joints, those too that are left out of the document.
    pub joints: Vec<OsimJoint>,
    /// What was left out, in sentences.
    pub notes: Vec<String>,
}

/// A joint as the model has it.
#[derive(Clone, Debug, PartialEq)]
pub struct OsimJoint {
    /// Name.
    pub name: String,
    /// Name of the parent body.
    pub parent: String,
    /// Name of the child body.
    pub child: String,
    /// Joint frame on the parent.
    pub body_from_parent_frame: Isometry3<f64>,
    /// Joint frame on the child.
    pub body_from_child_frame: Isometry3<f64>,
    /// Joint transform of the default pose.
    transform: Isometry3<f64>,
    coordinates: Vec<CoordinateEntry>,
}

/// Reads a model; `path` is for error messages.
pub fn parse_osim(text: &str, path: &Path) -> Result<OsimModel> {
    let options = roxmltree::ParsingOptions { allow_dtd: false, ..Default::default() };
    let xml = Document::parse_with_options(text, options)
        .map_err(|e| Error::parse(path, e.pos().row as usize, format!("not valid XML: {e}")))?;
    let root = xml.root_element();
    let version: u32 = root.attribute("Version").and_then(|v| v.parse().ok()).unwrap_or(0);
    if root.tag_name().name() != "OpenSimDocument" || version < 40_000 {
        let message = "an <OpenSimDocument Version=\"40000\"> or newer is needed; open the model in OpenSim 4 and save it";
        return Err(Error::parse(path, None, message));
    }
    let mut joints = Vec::new();
    for node in root.descendants().filter(|n| parent_named(n, &["JointSet", "objects"])) {
        joints.push(joint(&node).map_err(|m| Error::parse(path, row(&xml, &node), m))?);
    }
    let world = world_frames(&joints);
    let mut model = OsimModel::default();
    model.document.format = FORMAT.into();
    model.document.version = VERSION;
    model.document.units = Some("m".into());
    for body in root.descendants().filter(|n| parent_named(n, &["BodySet", "objects"])) {
        let name = body.attribute("name").unwrap_or_default();
        let Some(mesh) = body.descendants().find(|n| n.has_tag_name("mesh_file")) else {
            model.notes.push(format!("body {name} has no mesh and is left out"));
            continue;
        };
        let scale = mesh.parent().and_then(|p| child_text(&p, "scale_factors"));
        model.mesh_scale.push(scale.and_then(|s| three(&s)).unwrap_or([1.0; 3]));
        model.world_from_body.push(world.get(name).copied().unwrap_or_else(Isometry3::identity));
        let mesh = mesh.text().unwrap_or_default().trim().to_string();
        model.document.bones.push(BoneEntry { name: name.into(), mesh, label: None });
    }
    if model.document.bones.is_empty() {
        return Err(Error::parse(path, None, "no body of the model has a mesh"));
    }
    for joint in &joints {
        match entry(joint, &model.document.bones, &world) {
            Some(entry) => model.document.joints.push(entry),
            None => model.notes.push(format!("joint {} connects a body without mesh", joint.name)),
        }
    }
    model.joints = joints;
    Ok(model)
}

pub(super) fn parent_named(node: &Node, names: &[&str; 2]) -> bool {
    let named = |n: Option<Node>, name: &str| n.is_some_and(|n| n.has_tag_name(name));
    node.is_element()
        && named(node.parent(), names[1])
        && named(node.parent().and_then(|p| p.parent()), names[0])
}

fn row(xml: &Document, node: &Node) -> usize {
    xml.text_pos_at(node.range().start).row as usize
}

pub(super) fn child_text(node: &Node, name: &str) -> Option<String> {
    let child = node.children().find(|n| n.has_tag_name(name))?;
    Some(child.text().unwrap_or_default().trim().to_string())
}

fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split_whitespace().map(|w| w.parse().ok().filter(|x: &f64| x.is_finite())).collect()
}

pub(super) fn three(text: &str) -> Option<[f64; 3]> {
    numbers(text)?.try_into().ok()
}

fn joint(node: &Node) -> Result<OsimJoint, String> {
    let name = node.attribute("name").unwrap_or_default().to_string();
    let mut frames = HashMap::new();
    for frame in node.descendants().filter(|n| n.has_tag_name("PhysicalOffsetFrame")) {
        let body = child_text(&frame, "socket_parent").unwrap_or_default();
        let vector = |tag: &str| -> Result<Vector3<f64>, String> {
            let text = child_text(&frame, tag).unwrap_or_else(|| "0 0 0".into());
            three(&text).map(Vector3::from).ok_or_else(|| {
                format!("joint {name}: <{tag}> must hold three numbers, not \"{text}\"")
            })
        };
        let pose = Isometry3::from_parts(
            Translation3::from(vector("translation")?),
            body_fixed(&vector("orientation")?),
        );
        frames.insert(frame.attribute("name").unwrap_or_default(), (last_name(&body), pose));
    }
    let end = |tag: &str| -> Result<(String, Isometry3<f64>), String> {
        let socket = child_text(node, tag).ok_or_else(|| format!("joint {name} has no <{tag}>"))?;
        Ok(frames
            .get(last_name(&socket).as_str())
            .cloned()
            .unwrap_or_else(|| (last_name(&socket), Isometry3::identity())))
    };
    let (parent, body_from_parent_frame) = end("socket_parent_frame")?;
    let (child, body_from_child_frame) = end("socket_child_frame")?;
    let ranges = coordinate_ranges(node, &name)?;
    let (transform, coordinates) = motion(node, &ranges, &name)?;
    Ok(OsimJoint {
        name,
        parent,
        child,
        body_from_parent_frame,
        body_from_child_frame,
        transform,
        coordinates,
    })
}

/// OpenSim orientation: rotations about x, then the turned y, then the turned z.
fn body_fixed(angles: &Vector3<f64>) -> UnitQuaternion<f64> {
    let turn = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
    turn(Vector3::x_axis(), angles.x)
        * turn(Vector3::y_axis(), angles.y)
        * turn(Vector3::z_axis(), angles.z)
}

pub(super) fn last_name(path: &str) -> String {
    path.rsplit('/').next().unwrap_or(path).to_string()
}

/// Name, default value and range of every coordinate, in file order.
fn coordinate_ranges(node: &Node, joint: &str) -> Result<Vec<(String, f64, [f64; 2])>, String> {
    let coordinates = node.descendants().filter(|n| n.has_tag_name("Coordinate"));
    coordinates
        .map(|c| {
            let name = c.attribute("name").unwrap_or_default().to_string();
            let bad =
                |tag: &str| format!("joint {joint}: <{tag}> of coordinate {name} is not usable");
            let default = child_text(&c, "default_value").unwrap_or_else(|| "0".into());
            let default = numbers(&default).and_then(|v| v.first().copied());
            let default = default.ok_or_else(|| bad("default_value"))?;
            let range = child_text(&c, "range").unwrap_or_else(|| "-99999.9 99999.9".into());
            let range: [f64; 2] =
                numbers(&range).and_then(|r| r.try_into().ok()).ok_or_else(|| bad("range"))?;
            Ok((name, default, range))
        })
        .collect()
}

/// The default transform and the rotations that have a coordinate of their own.
fn motion(
    node: &Node,
    ranges: &[(String, f64, [f64; 2])],
    joint: &str,
) -> Result<(Isometry3<f64>, Vec<CoordinateEntry>), String> {
    let mut rotations: Vec<(String, Vector3<f64>)> = Vec::new();
    match node.tag_name().name() {
        "PinJoint" => rotations.extend(ranges.iter().take(1).map(|r| (r.0.clone(), Vector3::z()))),
        "UniversalJoint" | "BallJoint" | "GimbalJoint" | "FreeJoint" => {
            let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
            rotations.extend(ranges.iter().map(|r| r.0.clone()).zip(axes));
        }
        _ => {
            for axis in node.descendants().filter(|n| n.has_tag_name("TransformAxis")) {
                let rotation = axis.attribute("name").is_some_and(|n| n.starts_with("rotation"));
                let names = child_text(&axis, "coordinates").unwrap_or_default();
                if !rotation || !ranges.iter().any(|r| r.0 == names) {
                    continue;
                }
                let text = child_text(&axis, "axis").unwrap_or_default();
                let direction = three(&text).and_then(|a| Vector3::from(a).try_normalize(1e-9));
                let direction = direction
                    .ok_or_else(|| format!("joint {joint}: <axis> of {names} must not be zero"))?;
                rotations.push((names, direction));
            }
        }
    }
    let mut turn = UnitQuaternion::identity();
    let mut entries = Vec::new();
    for (name, axis) in rotations {
        let Some((_, default, range)) = ranges.iter().find(|r| r.0 == name) else { continue };
        turn *= UnitQuaternion::from_scaled_axis(axis * *default);
        let range_deg = range.map(|r| r.clamp(-FREE, FREE).to_degrees());
        entries.push(CoordinateEntry { name, axis: axis.into(), range_deg });
    }
    Ok((Isometry3::from_parts(Translation3::identity(), turn), entries))
}

/// World from body in the default pose, from the ground outwards; bodies that are not reached stay
/// where they are.
fn world_frames(joints: &[OsimJoint]) -> HashMap<String, Isometry3<f64>> {
    let mut world = HashMap::from([("ground".to_string(), Isometry3::identity())]);
    for _ in 0..joints.len() {
        for joint in joints {
            if let Some(parent) = world.get(&joint.parent).copied()
                && !world.contains_key(&joint.child)
            {
                let child = parent
                    * joint.body_from_parent_frame
                    * joint.transform
                    * joint.body_from_child_frame.inverse();
                world.insert(joint.child.clone(), child);
            }
        }
    }
    world
}

fn entry(
    joint: &OsimJoint,
    bones: &[BoneEntry],
    world: &HashMap<String, Isometry3<f64>>,
) -> Option<JointEntry> {
    let known = |name: &String| bones.iter().any(|b| b.name == *name);
    if !known(&joint.parent) || !known(&joint.child) {
        return None;
    }
    let placed = |body: &String, frame: &Isometry3<f64>| {
        let frame = world.get(body).copied().unwrap_or_else(Isometry3::identity) * frame;
        let q = frame.rotation.quaternion();
        FrameEntry { t: frame.translation.vector.into(), q: [q.w, q.i, q.j, q.k] }
    };
    let mut sides =
        SidesEntry { neg: [Some(OFF_AXIS_DEGREES); 3], pos: [Some(OFF_AXIS_DEGREES); 3] };
    for c in &joint.coordinates {
        // The range goes to the frame's axis that the coordinate turns about most.
        let k = Vector3::from(c.axis).iamax();
        let [low, high] = c.range_deg;
        let (low, high) = if c.axis[k] < 0.0 { (-high, -low) } else { (low, high) };
        let side = |x: f64| (x < FREE.to_degrees()).then_some(x.max(0.0));
        (sides.neg[k], sides.pos[k]) = (side(-low), side(high));
    }
    Some(JointEntry {
        name: joint.name.clone(),
        parent: joint.parent.clone(),
        child: joint.child.clone(),
        parent_frame: Some(placed(&joint.parent, &joint.body_from_parent_frame)),
        child_frame: Some(placed(&joint.child, &joint.body_from_child_frame)),
        limits: LimitsEntry { rot_deg: sides, shape: "ellipsoid".into(), ..LimitsEntry::default() },
        tree: true,
        source: Some("osim".into()),
        coordinates: joint.coordinates.clone(),
        ..JointEntry::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEG: &str = r#"<?xml version="1.0"?><OpenSimDocument Version="40000"><Model name="leg">
      <BodySet><objects>
       <Body name="femur"><attached_geometry><Mesh name="f"><mesh_file>femur.vtp</mesh_file>
         <scale_factors>1 2 1</scale_factors></Mesh></attached_geometry></Body>
       <Body name="tibia"><attached_geometry><Mesh name="t"><mesh_file>tibia.obj</mesh_file></Mesh></attached_geometry></Body>
       <Body name="empty"/></objects></BodySet>
      <JointSet><objects>
       <PinJoint name="knee"><socket_parent_frame>femur_offset</socket_parent_frame>
        <socket_child_frame>tibia_offset</socket_child_frame>
        <coordinates><Coordinate name="knee_angle"><default_value>0.5</default_value><range>-2 0.1</range></Coordinate></coordinates>
        <frames>
         <PhysicalOffsetFrame name="femur_offset"><socket_parent>/bodyset/femur</socket_parent><translation>0 -0.4 0</translation><orientation>0 0 0</orientation></PhysicalOffsetFrame>
         <PhysicalOffsetFrame name="tibia_offset"><socket_parent>/bodyset/tibia</socket_parent><translation>0 0 0</translation><orientation>0 0 0</orientation></PhysicalOffsetFrame>
        </frames></PinJoint>
       <WeldJoint name="base"><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>/bodyset/femur</socket_child_frame></WeldJoint>
      </objects></JointSet></Model></OpenSimDocument>"#;

    #[test]
    fn bodies_and_joints_are_placed_in_the_default_pose() {
        let model = parse_osim(LEG, Path::new("leg.osim")).unwrap();
        assert_eq!(model.document.bones.len(), 2);
        assert!((model.mesh_scale[0][1] - 2.0).abs() < 1e-12);
        assert_eq!(model.notes.len(), 2);
        let knee = &model.document.joints[0];
        assert!((knee.parent_frame.unwrap().t[1] + 0.4).abs() < 1e-12);
        assert!((knee.limits.rot_deg.neg[2].unwrap() - 2_f64.to_degrees()).abs() < 1e-9);
        assert!((model.world_from_body[1].rotation.angle() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn mistakes_are_named() {
        let message = |text: &str| parse_osim(text, Path::new("a.osim")).unwrap_err().to_string();
        assert!(message("<a").contains("XML"));
        assert!(message(&LEG.replace("40000", "30000")).contains("OpenSim 4"));
        assert!(message(&LEG.replace("0 -0.4 0", "0 x 0")).contains("knee"));
        assert!(message(&LEG.replace("mesh_file", "other")).contains("no body"));
    }
}
