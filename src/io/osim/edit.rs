//! A model written back: numbers and names change in the text, everything else stays as it is, elements
//! that are not known too.

use std::fmt::Write as _;
use std::ops::Range;
use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Rotation3};
use roxmltree::Node;

use super::function::{Function, innermost};
use super::joint::{OsimJoint, body_fixed, is_axis};
use super::model::{document, meshes};
use super::xml::{child_number, child_numbers, child_text, child_three, last_name, name, objects};
use crate::error::Result;
use crate::io::markup::escaped;
use crate::math::Vec3;

/// What changes.
pub trait OsimChanges {
    /// A joint with its new frames and stretched shifts.
    fn joint(&self, name: &str) -> Option<&OsimJoint>;
    /// New default value of a coordinate.
    fn default_value(&self, coordinate: &str) -> Option<f64>;
    /// New mesh files of a body in the order of the old ones, with scale 1; empty if they stay.
    fn meshes(&self, body: &str) -> Vec<String>;
    /// Factor of a body's mass.
    fn mass(&self, body: &str) -> f64;
    /// Scale factors of a body along its axes.
    fn scale(&self, body: &str) -> Option<Vec3>;
    /// New place of a point on a body, seen from the body.
    fn point(&self, body: &str, location: &Vec3) -> Option<Vec3>;
    /// A coordinate's value in the template's default pose.
    fn template_value(&self, coordinate: &str) -> f64;
    /// Factor of the length of a path through points on bodies.
    fn path_length(&self, points: &[(String, Vec3)]) -> Option<f64>;
}

/// The model's text with the changes made; `path` is for error messages.
pub fn edit_osim(text: &str, path: &Path, changes: &impl OsimChanges) -> Result<String> {
    let xml = document(text, path)?;
    let mut edits = Edits::default();
    for joint in objects(&xml, "JointSet") {
        edits.joint(&joint, changes);
    }
    for body in objects(&xml, "BodySet") {
        edits.body(&body, changes);
    }
    for node in xml.descendants().filter(Node::is_element) {
        match node.tag_name().name() {
            "location" => edits.location(&node, changes),
            "MovingPathPoint" => edits.moving_point(&node, changes),
            "GeometryPath" => edits.path(&node, changes),
            _ => {}
        }
    }
    Ok(edits.applied(text))
}

/// Pieces of the text and what replaces them.
#[derive(Default)]
struct Edits(Vec<(Range<usize>, String)>);

impl Edits {
    fn joint(&mut self, joint: &Node, changes: &impl OsimChanges) {
        let Some(new) = changes.joint(name(joint)) else { return };
        self.frames(joint, [new.body_from_parent_frame, new.body_from_child_frame]);
        for coordinate in joint.descendants().filter(|n| n.has_tag_name("Coordinate")) {
            if let Some(value) = changes.default_value(name(&coordinate)) {
                self.set_child(&coordinate, "default_value", &written(&[value]));
            }
        }
        let shifts = joint.descendants().filter(|n| is_axis(n, "translation"));
        for (node, axis) in shifts.zip(&new.translations) {
            self.function(&node, axis.stretch, 0.0);
        }
    }

    /// The frames of a joint. A joint that sits on a body without an offset frame gets one.
    fn frames(&mut self, joint: &Node, frames: [Isometry3<f64>; 2]) {
        let offsets: Vec<Node> =
            joint.descendants().filter(|n| n.has_tag_name("PhysicalOffsetFrame")).collect();
        let mut added = String::new();
        for (socket, frame) in ["socket_parent_frame", "socket_child_frame"].iter().zip(frames) {
            let Some(target) = child_text(joint, socket) else { continue };
            let place = written(frame.translation.vector.as_slice());
            let turn = orientation(&frame);
            let own = offsets.iter().find(|n| name(n) == last_name(&target));
            if let Some(own) = own {
                self.set_child(own, "translation", &place);
                self.set_child(own, "orientation", &turn);
            } else if frame.translation.vector.norm() > 1e-12 || frame.rotation.angle() > 1e-12 {
                let suffix = if added.is_empty() { "offset" } else { "offset_2" };
                let offset = format!("{}_{suffix}", name(joint));
                self.set_child(joint, socket, &escaped(&offset));
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
            Some(list) => self.insert_child(&list, &added),
            None => self.insert_child(joint, &format!("<frames>{added}</frames>")),
        }
    }

    fn body(&mut self, body: &Node, changes: &impl OsimChanges) {
        let body_name = name(body);
        for (mesh, file) in meshes(body).zip(changes.meshes(body_name)) {
            self.set_child(&mesh, "mesh_file", &escaped(&file));
            self.set_child(&mesh, "scale_factors", "1 1 1");
        }
        let factor = changes.mass(body_name);
        self.scale_child(body, "mass", factor);
        let scale = changes.scale(body_name).unwrap_or(Vec3::repeat(1.0));
        if let Some(&[xx, yy, zz, xy, xz, yz]) = child_numbers(body, "inertia").as_deref() {
            let inertia = scaled_inertia([xx, yy, zz, xy, xz, yz], factor, &scale);
            self.set_child(body, "inertia", &written(&inertia));
        }
        self.move_child(body, "mass_center", body_name, changes);
        for wrap in body.descendants().filter(|n| n.has_tag_name("xyz_body_rotation")) {
            if let Some(wrap) = wrap.parent_element() {
                self.wrap(&wrap, body_name, &scale, changes);
            }
        }
    }

    /// A surface that muscles wrap around: its sizes grow with the body along its own axes.
    fn wrap(&mut self, wrap: &Node, body: &str, scale: &Vec3, changes: &impl OsimChanges) {
        self.move_child(wrap, "translation", body, changes);
        let turn = body_fixed(&child_three(wrap, "xyz_body_rotation").unwrap_or_default());
        let along = |axis: Vec3| scale.component_mul(&(turn * axis)).norm();
        let [x, y, z] = [along(Vec3::x()), along(Vec3::y()), along(Vec3::z())];
        let across = f64::midpoint(x, y);
        let sphere = wrap.has_tag_name("WrapSphere");
        let radius = if sphere { (x + y + z) / 3.0 } else { across };
        for (size, factor) in
            [("radius", radius), ("length", z), ("inner_radius", across), ("outer_radius", across)]
        {
            self.scale_child(wrap, size, factor);
        }
        if let Some(sizes) = child_three(wrap, "dimensions") {
            let sizes = sizes.component_mul(&Vec3::new(x, y, z));
            self.set_child(wrap, "dimensions", &written(sizes.as_slice()));
        }
    }

    fn location(&mut self, location: &Node, changes: &impl OsimChanges) {
        let Some(point) = location.parent_element() else { return };
        if let Some(body) = body_of(&point) {
            self.move_child(&point, "location", &body, changes);
        }
    }

    /// A point whose coordinates are functions: they are scaled, and shifted as the point is.
    fn moving_point(&mut self, point: &Node, changes: &impl OsimChanges) {
        let Some(body) = body_of(point) else { return };
        let place = moving_place(point, changes);
        if let (Some(scale), Some(moved)) = (changes.scale(&body), changes.point(&body, &place)) {
            let shift = moved - scale.component_mul(&place);
            for (k, tag) in MOVING.iter().enumerate() {
                if let Some(owner) = point.children().find(|n| n.has_tag_name(*tag)) {
                    self.function(&owner, scale[k], shift[k]);
                }
            }
        }
    }

    /// What is measured along a path grows with it: fibres, tendons, ligaments.
    fn path(&mut self, path: &Node, changes: &impl OsimChanges) {
        let Some(owner) = path.parent_element() else { return };
        let Some(factor) = changes.path_length(&path_points(path, changes)) else { return };
        for length in ["optimal_fiber_length", "tendon_slack_length", "resting_length"] {
            self.scale_child(&owner, length, factor);
        }
    }

    /// Makes the function of an element `factor` times itself plus `shift`.
    fn function(&mut self, owner: &Node, factor: f64, shift: f64) {
        let Some((node, around)) = innermost(owner) else { return };
        let tag = match node.tag_name().name() {
            "Constant" => "value",
            "LinearFunction" | "PolynomialFunction" => "coefficients",
            _ => "y",
        };
        let Some(mut numbers) = child_numbers(&node, tag) else { return };
        // The last coefficient is the constant one.
        let first = if tag == "coefficients" { numbers.len().saturating_sub(1) } else { 0 };
        let shift = if around == 0.0 { 0.0 } else { shift / around };
        for (k, x) in numbers.iter_mut().enumerate() {
            *x = *x * factor + if k < first { 0.0 } else { shift };
        }
        self.set_child(&node, tag, &written(&numbers));
    }

    /// Multiplies the number of a child element.
    fn scale_child(&mut self, node: &Node, name: &str, factor: f64) {
        if let Some(value) = child_number(node, name) {
            self.set_child(node, name, &written(&[value * factor]));
        }
    }

    /// Moves the place on a body that a child element has.
    fn move_child(&mut self, node: &Node, name: &str, body: &str, changes: &impl OsimChanges) {
        let place = child_three(node, name).and_then(|place| changes.point(body, &place));
        if let Some(place) = place {
            self.set_child(node, name, &written(place.as_slice()));
        }
    }

    /// Sets the text of a child element, which is made where it is missing.
    fn set_child(&mut self, node: &Node, name: &str, text: &str) {
        match node.children().find(|n| n.has_tag_name(name)) {
            Some(child) => self.replace_text(&child, text),
            None => self.insert_child(node, &format!("<{name}>{text}</{name}>")),
        }
    }

    fn replace_text(&mut self, node: &Node, text: &str) {
        let name = node.tag_name().name();
        self.0.push((node.range(), format!("<{name}>{text}</{name}>")));
    }

    /// Puts an element behind the last child of a node.
    fn insert_child(&mut self, node: &Node, element: &str) {
        let source = node.document().input_text();
        let range = node.range();
        let whole = &source[range.clone()];
        if let Some(close) = whole.rfind("</") {
            let at = range.start + close;
            self.0.push((at..at, element.to_owned()));
        } else if let Some(slash) = whole.rfind("/>") {
            let name = node.tag_name().name();
            let at = range.start + slash;
            self.0.push((at..range.end, format!(">{element}</{name}>")));
        }
    }

    /// The text with all edits made, from the first to the last; of two at one place both are kept.
    fn applied(mut self, text: &str) -> String {
        self.0.sort_by_key(|(range, _)| range.start);
        let mut out = String::with_capacity(text.len());
        let mut at = 0;
        for (range, piece) in self.0 {
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
}

/// The functions of a moving point.
const MOVING: [&str; 3] = ["x_location", "y_location", "z_location"];

/// The body that an element with a place sits on.
fn body_of(node: &Node) -> Option<String> {
    let sockets = ["socket_parent_frame", "socket_frame"];
    sockets.iter().find_map(|socket| child_text(node, socket)).map(|path| last_name(&path))
}

/// Where a moving point lies in the template's default pose.
fn moving_place(point: &Node, changes: &impl OsimChanges) -> Vec3 {
    let axes = ["socket_x_coordinate", "socket_y_coordinate", "socket_z_coordinate"];
    Vec3::from_fn(|k, _| {
        let owner = point.children().find(|n| n.has_tag_name(MOVING[k]));
        let function = owner.and_then(|owner| Function::of(&owner).ok().flatten());
        let coordinate = child_text(point, axes[k]).unwrap_or_default();
        let value = changes.template_value(&last_name(&coordinate));
        function.map_or(0.0, |f| f.value(value))
    })
}

/// The points of a path that count in the template's default pose.
fn path_points(path: &Node, changes: &impl OsimChanges) -> Vec<(String, Vec3)> {
    let place = |point: Node| {
        if let (Some(coordinate), Some(&[low, high])) =
            (child_text(&point, "socket_coordinate"), child_numbers(&point, "range").as_deref())
        {
            let value = changes.template_value(&last_name(&coordinate));
            (low..=high).contains(&value).then_some(())?;
        }
        let fixed = child_three(&point, "location");
        Some((body_of(&point)?, fixed.unwrap_or_else(|| moving_place(&point, changes))))
    };
    let points = path.descendants().filter(|n| n.tag_name().name().ends_with("PathPoint"));
    points.filter_map(place).collect()
}

/// A body's inertia about its centre with its mass and its lengths along the axes scaled.
fn scaled_inertia(inertia: [f64; 6], mass: f64, scale: &Vec3) -> [f64; 6] {
    let [xx, yy, zz, xy, xz, yz] = inertia;
    // Second moments of the mass along the axes.
    let moments = Vec3::new(yy + zz - xx, xx + zz - yy, xx + yy - zz) / 2.0;
    if moments.min() < 0.0 {
        // No real mass has it; then only its size is changed.
        let size = libm::pow(scale.product().abs(), 2.0 / 3.0);
        return inertia.map(|x| x * mass * size);
    }
    let [x, y, z] = (moments.component_mul(&scale.component_mul(scale)) * mass).into();
    let products = [xy * scale.x * scale.y, xz * scale.x * scale.z, yz * scale.y * scale.z];
    let [xy, xz, yz] = products.map(|p| p * mass);
    [y + z, x + z, x + y, xy, xz, yz]
}

/// Rotations about x, the turned y and the turned z.
fn orientation(frame: &Isometry3<f64>) -> String {
    let r: Matrix3<f64> = Rotation3::from(frame.rotation).into_inner();
    let y = libm::asin(r.m13.clamp(-1.0, 1.0));
    let angles = if r.m13.abs() > 1.0 - 1e-14 {
        Vec3::new(libm::atan2(r.m32, r.m22), y, 0.0)
    } else {
        Vec3::new(libm::atan2(-r.m23, r.m33), y, libm::atan2(-r.m12, r.m11))
    };
    written(angles.as_slice())
}

fn written(numbers: &[f64]) -> String {
    numbers.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" ")
}
