//! OpenSim models written back: a few numbers and names change in the text, everything else stays as it
//! is, elements that are not known too.

use std::fmt::Write as _;
use std::ops::Range;
use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Rotation3, Vector3};
use roxmltree::{Document, Node, ParsingOptions};

use super::markup::escaped;
use super::osim::{child_text, last_name, parent_named, three};
use crate::error::{Error, Result};

/// What changes.
pub trait OsimChanges {
    /// New frames of a joint on its parent and its child body.
    fn frames(&self, joint: &str) -> Option<[Isometry3<f64>; 2]>;
    /// New default value of a coordinate, radians.
    fn default_value(&self, coordinate: &str) -> Option<f64>;
    /// New mesh file of a body, with scale 1.
    fn mesh(&self, body: &str) -> Option<String>;
    /// New place of a point on a body, seen from the body.
    fn point(&self, body: &str, location: [f64; 3]) -> Option<[f64; 3]>;
}

/// Pieces of the text and what replaces them.
type Edits = Vec<(Range<usize>, String)>;

/// The model's text with the changes made; `path` is for error messages.
pub fn edit_osim(text: &str, path: &Path, changes: &impl OsimChanges) -> Result<String> {
    let options = ParsingOptions { allow_dtd: false, ..Default::default() };
    let xml = Document::parse_with_options(text, options)
        .map_err(|e| Error::parse(path, e.pos().row as usize, format!("not valid XML: {e}")))?;
    let root = xml.root_element();
    let mut edits = Edits::new();
    for joint in root.descendants().filter(|n| parent_named(n, &["JointSet", "objects"])) {
        let name = joint.attribute("name").unwrap_or_default();
        if let Some(frames) = changes.frames(name) {
            edit_frames(&joint, name, &frames, &mut edits);
        }
        for coordinate in joint.descendants().filter(|n| n.has_tag_name("Coordinate")) {
            let name = coordinate.attribute("name").unwrap_or_default();
            if let Some(value) = changes.default_value(name) {
                set_child(&coordinate, "default_value", &format!("{value:?}"), &mut edits);
            }
        }
    }
    for body in root.descendants().filter(|n| parent_named(n, &["BodySet", "objects"])) {
        let name = body.attribute("name").unwrap_or_default();
        let mesh = body.descendants().find(|n| n.has_tag_name("mesh_file"));
        if let (Some(file), Some(mesh)) = (changes.mesh(name), mesh.and_then(|m| m.parent())) {
            set_child(&mesh, "mesh_file", &escaped(&file), &mut edits);
            set_child(&mesh, "scale_factors", "1 1 1", &mut edits);
        }
    }
    for point in root.descendants().filter(|n| n.has_tag_name("location")) {
        let owner = point.parent().and_then(|p| child_text(&p, "socket_parent_frame"));
        let place = point.text().and_then(three);
        if let (Some(owner), Some(place)) = (owner, place)
            && let Some(place) = changes.point(&last_name(&owner), place)
        {
            replace_text(&point, &numbers(&place), &mut edits);
        }
    }
    Ok(applied(text, edits))
}

/// The frames of a joint. A joint that sits on a body without an offset frame gets one.
fn edit_frames(joint: &Node, name: &str, frames: &[Isometry3<f64>; 2], edits: &mut Edits) {
    let offsets: Vec<Node> =
        joint.descendants().filter(|n| n.has_tag_name("PhysicalOffsetFrame")).collect();
    let mut added = String::new();
    for (socket, frame) in ["socket_parent_frame", "socket_child_frame"].iter().zip(frames) {
        let Some(target) = child_text(joint, socket) else { continue };
        let (place, turn) = (numbers(&frame.translation.vector.into()), orientation(frame));
        let own = offsets.iter().find(|n| n.attribute("name") == Some(&last_name(&target)));
        if let Some(own) = own {
            set_child(own, "translation", &place, edits);
            set_child(own, "orientation", &turn, edits);
        } else if frame.translation.vector.norm() > 1e-12 || frame.rotation.angle() > 1e-12 {
            let offset = format!("{name}_{}", if added.is_empty() { "offset" } else { "offset_2" });
            set_child(joint, socket, &escaped(&offset), edits);
            // Writing to a string cannot fail.
            let _ = write!(
                added,
                "<PhysicalOffsetFrame name=\"{}\"><socket_parent>{}</socket_parent><translation>{place}\
                 </translation><orientation>{turn}</orientation></PhysicalOffsetFrame>",
                escaped(&offset),
                escaped(&target)
            );
        }
    }
    if added.is_empty() {
        return;
    }
    match joint.children().find(|n| n.has_tag_name("frames")) {
        Some(list) => insert_child(&list, &added, edits),
        None => insert_child(joint, &format!("<frames>{added}</frames>"), edits),
    }
}

/// Rotations about x, the turned y and the turned z.
fn orientation(frame: &Isometry3<f64>) -> String {
    let r: Matrix3<f64> = Rotation3::from(frame.rotation).into_inner();
    let y = r.m13.clamp(-1.0, 1.0).asin();
    let angles = if r.m13.abs() > 1.0 - 1e-14 {
        Vector3::new(r.m32.atan2(r.m22), y, 0.0)
    } else {
        Vector3::new((-r.m23).atan2(r.m33), y, (-r.m12).atan2(r.m11))
    };
    numbers(&angles.into())
}

fn numbers(values: &[f64; 3]) -> String {
    values.map(|x| format!("{x:?}")).join(" ")
}

/// Sets the text of a child element, which is made where it is missing.
fn set_child(node: &Node, name: &str, text: &str, edits: &mut Edits) {
    match node.children().find(|n| n.has_tag_name(name)) {
        Some(child) => replace_text(&child, text, edits),
        None => insert_child(node, &format!("<{name}>{text}</{name}>"), edits),
    }
}

fn replace_text(node: &Node, text: &str, edits: &mut Edits) {
    let name = node.tag_name().name();
    edits.push((node.range(), format!("<{name}>{text}</{name}>")));
}

/// Puts an element behind the last child of a node.
fn insert_child(node: &Node, element: &str, edits: &mut Edits) {
    let source = node.document().input_text();
    let range = node.range();
    let whole = &source[range.clone()];
    if let Some(close) = whole.rfind("</") {
        let at = range.start + close;
        edits.push((at..at, element.to_owned()));
    } else if let Some(slash) = whole.rfind("/>") {
        let name = node.tag_name().name();
        let at = range.start + slash;
        edits.push((at..range.end, format!(">{element}</{name}>")));
    }
}

/// The text with all edits made, from the last to the first; of two at one place both are kept.
fn applied(text: &str, mut edits: Edits) -> String {
    edits.sort_by_key(|(range, _)| range.start);
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    for (range, piece) in edits {
        if range.start < at {
            continue;
        }
        out.push_str(&text[at..range.start]);
        out.push_str(&piece);
        at = range.end;
    }
    out.push_str(&text[at..]);
    out
}
