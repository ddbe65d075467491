//! Joints: their frames on the two bodies, and the motion between the frames as functions of coordinates.

use std::collections::HashMap;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use roxmltree::Node;

use super::function::Function;
use super::xml::{child_numbers, child_text, child_three, last_name, name, three};
use crate::math::Vec3;

/// Values of coordinates by name.
pub type Values = HashMap<String, f64>;

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
    /// Its coordinates.
    pub coordinates: Vec<OsimCoordinate>,
    /// Rotations, in the order they are multiplied in.
    pub rotations: Vec<Axis>,
    /// Translations, seen from the parent's frame.
    pub translations: Vec<Axis>,
}

/// A coordinate of a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct OsimCoordinate {
    /// Name.
    pub name: String,
    /// Value of the default pose: radians, or metres.
    pub default: f64,
    /// Lowest and highest value.
    pub range: [f64; 2],
}

/// A turn about an axis, or a shift along it.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Unit direction.
    pub direction: Vec3,
    /// The coordinate it follows; none if it stays.
    pub coordinate: Option<String>,
    /// Radians or metres.
    pub function: Function,
    /// Factor of the function: 1 as the model is read.
    pub stretch: f64,
}

impl Axis {
    fn of_coordinate(direction: Vec3, coordinate: &OsimCoordinate) -> Self {
        let coordinate = Some(coordinate.name.clone());
        Self { direction, coordinate, function: Function::identity(), stretch: 1.0 }
    }

    fn value(&self, values: &Values) -> f64 {
        let at = self.coordinate.as_ref().and_then(|name| values.get(name)).copied();
        self.stretch * self.function.value(at.unwrap_or(0.0))
    }

    /// The coordinate that is this axis's own angle or length, and the direction in which it grows.
    pub fn own_coordinate(&self) -> Option<(&str, Vec3)> {
        let slope = self.function.own_slope()?;
        Some((self.coordinate.as_deref()?, self.direction * slope))
    }
}

impl OsimJoint {
    /// Reads a joint.
    pub fn parse(node: &Node) -> Result<Self, String> {
        let joint = name(node).to_string();
        let in_joint = |message: String| format!("joint {joint}: {message}");
        let (parent, body_from_parent_frame) =
            end(node, "socket_parent_frame").map_err(in_joint)?;
        let (child, body_from_child_frame) = end(node, "socket_child_frame").map_err(in_joint)?;
        let mut read = Self {
            name: joint.clone(),
            parent,
            child,
            body_from_parent_frame,
            body_from_child_frame,
            coordinates: coordinates(node).map_err(in_joint)?,
            rotations: Vec::new(),
            translations: Vec::new(),
        };
        read.take_motion(node).map_err(in_joint)?;
        Ok(read)
    }

    fn take_motion(&mut self, node: &Node) -> Result<(), String> {
        let own =
            |k: usize, axis: Vec3| self.coordinates.get(k).map(|c| Axis::of_coordinate(axis, c));
        let [x, y, z] = [Vec3::x(), Vec3::y(), Vec3::z()];
        let (turns, shifts) = match node.tag_name().name() {
            "PinJoint" => (vec![own(0, z)], vec![]),
            "SliderJoint" => (vec![], vec![own(0, x)]),
            "UniversalJoint" => (vec![own(0, x), own(1, y)], vec![]),
            "BallJoint" | "GimbalJoint" => (vec![own(0, x), own(1, y), own(2, z)], vec![]),
            "PlanarJoint" => (vec![own(0, z)], vec![own(1, x), own(2, y)]),
            "FreeJoint" => {
                (vec![own(0, x), own(1, y), own(2, z)], vec![own(3, x), own(4, y), own(5, z)])
            }
            _ => {
                self.rotations = self.axes(node, "rotation")?;
                self.translations = self.axes(node, "translation")?;
                return Ok(());
            }
        };
        self.rotations = turns.into_iter().flatten().collect();
        self.translations = shifts.into_iter().flatten().collect();
        Ok(())
    }

    /// The axes of a joint that moves by functions, rotations or translations.
    fn axes(&self, joint: &Node, kind: &str) -> Result<Vec<Axis>, String> {
        let nodes = joint.descendants().filter(|n| is_axis(n, kind));
        nodes.map(|node| self.axis(&node).map_err(|m| format!("{}: {m}", name(&node)))).collect()
    }

    fn axis(&self, node: &Node) -> Result<Axis, String> {
        let function = Function::of(node)?.unwrap_or(Function::constant(0.0));
        let coordinates = child_text(node, "coordinates").unwrap_or_default();
        let mut names = coordinates.split_whitespace().map(String::from);
        let coordinate = names.next();
        if names.next().is_some() {
            return Err("functions of several coordinates are not known".into());
        }
        if let Some(unknown) = coordinate.as_ref().filter(|name| !self.has(name)) {
            return Err(format!("there is no coordinate {unknown} in this joint"));
        }
        let direction = child_three(node, "axis").and_then(|axis| axis.try_normalize(1e-9));
        let direction = direction.ok_or("<axis> must hold three numbers, not all zero")?;
        Ok(Axis { direction, coordinate, function, stretch: 1.0 })
    }

    fn has(&self, coordinate: &str) -> bool {
        self.coordinates.iter().any(|c| c.name == coordinate)
    }

    /// The child frame seen from the parent frame.
    pub fn transform(&self, values: &Values) -> Isometry3<f64> {
        let turn = self.rotations.iter().fold(UnitQuaternion::identity(), |turn, axis| {
            turn * UnitQuaternion::from_scaled_axis(axis.direction * axis.value(values))
        });
        Isometry3::from_parts(Translation3::from(self.shift(values)), turn)
    }

    /// The child frame's origin seen from the parent frame.
    pub fn shift(&self, values: &Values) -> Vec3 {
        self.translations.iter().map(|axis| axis.direction * axis.value(values)).sum()
    }
}

/// Whether a node is a turn or a shift of a joint's motion whose name begins so.
pub(super) fn is_axis(node: &Node, begins: &str) -> bool {
    node.has_tag_name("TransformAxis") && name(node).starts_with(begins)
}

/// The body at one end of a joint, and the joint's frame on it.
fn end(joint: &Node, socket: &str) -> Result<(String, Isometry3<f64>), String> {
    let target = child_text(joint, socket).ok_or_else(|| format!("there is no <{socket}>"))?;
    let target = last_name(&target);
    let mut frames = joint.descendants().filter(|n| n.has_tag_name("PhysicalOffsetFrame"));
    match frames.find(|n| name(n) == target) {
        Some(frame) => {
            let body = child_text(&frame, "socket_parent").unwrap_or_default();
            Ok((last_name(&body), offset(&frame)?))
        }
        None => Ok((target, Isometry3::identity())),
    }
}

/// The place of an offset frame on what it sits on.
pub(super) fn offset(frame: &Node) -> Result<Isometry3<f64>, String> {
    let vector = |tag: &str| {
        let text = child_text(frame, tag).unwrap_or_else(|| "0 0 0".into());
        three(&text).ok_or_else(|| format!("<{tag}> must hold three numbers, not \"{text}\""))
    };
    let place = Translation3::from(vector("translation")?);
    Ok(Isometry3::from_parts(place, body_fixed(&vector("orientation")?)))
}

/// OpenSim's orientation: rotations about x, then the turned y, then the turned z.
pub(super) fn body_fixed(angles: &Vec3) -> UnitQuaternion<f64> {
    let turn = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
    turn(Vec3::x_axis(), angles.x) * turn(Vec3::y_axis(), angles.y) * turn(Vec3::z_axis(), angles.z)
}

fn coordinates(joint: &Node) -> Result<Vec<OsimCoordinate>, String> {
    let nodes = joint.descendants().filter(|n| n.has_tag_name("Coordinate"));
    let read = nodes.map(|node| {
        let name = name(&node).to_string();
        let number = |tag: &str, otherwise: &[f64]| match child_text(&node, tag) {
            None => Ok(otherwise.to_vec()),
            Some(_) => child_numbers(&node, tag)
                .filter(|v| v.len() == otherwise.len())
                .ok_or_else(|| format!("<{tag}> of coordinate {name} is not usable")),
        };
        let range = number("range", &[-99_999.9, 99_999.9])?;
        let [low, high] = [range[0], range[1]];
        if low > high {
            return Err(format!("<range> of coordinate {name} ends below its beginning"));
        }
        let default = number("default_value", &[0.0])?[0];
        Ok(OsimCoordinate { name, default, range: [low, high] })
    });
    read.collect()
}
