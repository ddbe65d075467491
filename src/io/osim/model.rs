//! A model read: its bodies with their meshes, its joints, and what couples coordinates. Lengths are metres.

use std::path::Path;

use nalgebra::Isometry3;
use roxmltree::{Document, Node};

use super::function::Function;
use super::joint::{OsimCoordinate, OsimJoint, Values, offset};
use super::xml::{child_number, child_text, child_three, last_name, name, objects, row};
use crate::error::{Error, Result};
use crate::math::Vec3;

/// A model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OsimModel {
    /// Names and meshes of all bodies.
    pub bodies: Vec<OsimBody>,
    /// All joints.
    pub joints: Vec<OsimJoint>,
    /// Coordinates that follow others.
    pub couplers: Vec<Coupler>,
    /// What is not used, in sentences.
    pub notes: Vec<String>,
}

/// A body.
#[derive(Clone, Debug, PartialEq)]
pub struct OsimBody {
    /// Name.
    pub name: String,
    /// Kilograms.
    pub mass: f64,
    /// Its meshes, in the order of the file.
    pub meshes: Vec<OsimMesh>,
}

/// A mesh of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct OsimMesh {
    /// File, as the model names it.
    pub file: String,
    /// Scale factors.
    pub scale: Vec3,
    /// The frame of the body it sits on.
    pub body_from_mesh: Isometry3<f64>,
}

/// A coordinate that follows another (`CoordinateCouplerConstraint`).
#[derive(Clone, Debug, PartialEq)]
pub struct Coupler {
    /// The coordinate that leads.
    pub leading: String,
    /// The one that follows.
    pub following: String,
    /// Value of the one from the other's.
    pub function: Function,
}

impl OsimModel {
    /// Reads a model; `path` is for error messages.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let xml = document(text, path)?;
        let at = |node: &Node, message: String| Error::parse(path, row(node), message);
        let mut model = Self::default();
        for node in objects(&xml, "JointSet") {
            model.joints.push(OsimJoint::parse(&node).map_err(|m| at(&node, m))?);
        }
        for node in objects(&xml, "BodySet") {
            model.bodies.push(body(&node).map_err(|m| at(&node, m))?);
        }
        if model.bodies_with_meshes().next().is_none() {
            return Err(Error::parse(path, None, "no body of the model has a mesh"));
        }
        for node in objects(&xml, "ConstraintSet") {
            match coupler(&node).map_err(|m| at(&node, m))? {
                Some(coupler) => model.couplers.push(coupler),
                None => model.notes.push(format!("constraint {} is not used", name(&node))),
            }
        }
        Ok(model)
    }

    /// The bodies that are bones.
    pub fn bodies_with_meshes(&self) -> impl Iterator<Item = &OsimBody> {
        self.bodies.iter().filter(|body| !body.meshes.is_empty())
    }

    /// All coordinates.
    pub fn coordinates(&self) -> impl Iterator<Item = &OsimCoordinate> {
        self.joints.iter().flat_map(|j| &j.coordinates)
    }

    /// Values of the default pose; what follows another coordinate is where that one leads it.
    pub fn default_values(&self) -> Values {
        let mut values = self.coordinates().map(|c| (c.name.clone(), c.default)).collect();
        self.couple(&mut values);
        values
    }

    /// Lets coordinates that follow others follow them.
    pub fn couple(&self, values: &mut Values) {
        for coupler in &self.couplers {
            if let Some(leading) = values.get(&coupler.leading).copied() {
                values.insert(coupler.following.clone(), coupler.function.value(leading));
            }
        }
    }

    /// The coupler that moves a coordinate.
    pub fn leader(&self, coordinate: &str) -> Option<&Coupler> {
        self.couplers.iter().find(|c| c.following == coordinate)
    }
}

/// The document of a model.
pub(super) fn document<'a>(text: &'a str, path: &Path) -> Result<Document<'a>> {
    let options = roxmltree::ParsingOptions { allow_dtd: false, ..Default::default() };
    let xml = Document::parse_with_options(text, options)
        .map_err(|e| Error::parse(path, e.pos().row as usize, format!("not valid XML: {e}")))?;
    let root = xml.root_element();
    let version: u32 = root.attribute("Version").and_then(|v| v.parse().ok()).unwrap_or(0);
    if root.tag_name().name() != "OpenSimDocument" || version < 40_000 {
        let message = "an <OpenSimDocument Version=\"40000\"> or newer is needed; open the model in OpenSim 4 and save it";
        return Err(Error::parse(path, None, message));
    }
    Ok(xml)
}

/// The meshes of a body.
pub(super) fn meshes<'a>(body: &Node<'a, 'a>) -> impl Iterator<Item = Node<'a, 'a>> {
    body.descendants().filter(|n| n.children().any(|c| c.has_tag_name("mesh_file")))
}

fn body(node: &Node) -> Result<OsimBody, String> {
    let body = name(node).to_string();
    let mut read = Vec::new();
    for mesh in meshes(node) {
        let mut body_from_mesh = Isometry3::identity();
        for frame in mesh.ancestors().filter(|n| n.has_tag_name("PhysicalOffsetFrame")) {
            body_from_mesh =
                offset(&frame).map_err(|m| format!("body {body}: {m}"))? * body_from_mesh;
        }
        let scale = child_three(&mesh, "scale_factors");
        read.push(OsimMesh {
            file: child_text(&mesh, "mesh_file").unwrap_or_default(),
            scale: scale.unwrap_or(Vec3::repeat(1.0)),
            body_from_mesh,
        });
    }
    let mass = child_number(node, "mass").unwrap_or(0.0);
    Ok(OsimBody { name: body, mass, meshes: read })
}

/// A coordinate that follows one other; `None` for every other constraint.
fn coupler(node: &Node) -> Result<Option<Coupler>, String> {
    let enforced = child_text(node, "isEnforced").is_none_or(|text| text == "true");
    let leading = child_text(node, "independent_coordinate_names").unwrap_or_default();
    let following = child_text(node, "dependent_coordinate_name").unwrap_or_default();
    let function = node.children().find(|n| n.has_tag_name("coupled_coordinates_function"));
    let (Some(function), true) = (function, enforced && leading.split_whitespace().count() == 1)
    else {
        return Ok(None);
    };
    let in_constraint = |m: String| format!("constraint {}: {m}", name(node));
    let function = Function::of(&function).map_err(in_constraint)?;
    let scale = child_number(node, "scale_factor");
    Ok(function.map(|function| Coupler {
        leading: last_name(&leading),
        following: last_name(&following),
        function: function.times(scale.unwrap_or(1.0)),
    }))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::io::osim::pose::places;

    /// A thigh on the ground, a knee that slides as it bends, a knee cap that is led by it, and a body
    /// without a mesh.
    pub(crate) const LEG: &str = r#"<?xml version="1.0"?><OpenSimDocument Version="40000"><Model name="leg">
      <BodySet><objects>
       <Body name="femur"><attached_geometry><Mesh name="f"><mesh_file>femur.vtp</mesh_file>
         <scale_factors>1 2 1</scale_factors></Mesh></attached_geometry><mass>3</mass></Body>
       <Body name="tibia"><attached_geometry><Mesh name="t"><mesh_file>tibia.obj</mesh_file></Mesh>
         <Mesh name="u"><mesh_file>fibula.obj</mesh_file></Mesh></attached_geometry></Body>
       <Body name="patella"><components><PhysicalOffsetFrame name="o"><translation>0 0 2</translation>
         <attached_geometry><Mesh name="p"><mesh_file>patella.obj</mesh_file></Mesh></attached_geometry>
         </PhysicalOffsetFrame></components></Body>
       <Body name="empty"/></objects></BodySet>
      <JointSet><objects>
       <CustomJoint name="knee"><socket_parent_frame>femur_offset</socket_parent_frame>
        <socket_child_frame>tibia_offset</socket_child_frame>
        <coordinates><Coordinate name="knee_angle"><default_value>0.5</default_value><range>-2 0.1</range></Coordinate></coordinates>
        <frames>
         <PhysicalOffsetFrame name="femur_offset"><socket_parent>/bodyset/femur</socket_parent><translation>0 -0.4 0</translation><orientation>0 0 0</orientation></PhysicalOffsetFrame>
         <PhysicalOffsetFrame name="tibia_offset"><socket_parent>/bodyset/tibia</socket_parent><translation>0 0 0</translation><orientation>0 0 0</orientation></PhysicalOffsetFrame>
        </frames><SpatialTransform>
         <TransformAxis name="rotation1"><coordinates>knee_angle</coordinates><axis>0 0 1</axis>
          <LinearFunction><coefficients>1 0</coefficients></LinearFunction></TransformAxis>
         <TransformAxis name="rotation2"><coordinates></coordinates><axis>0 1 0</axis><Constant><value>0</value></Constant></TransformAxis>
         <TransformAxis name="translation1"><coordinates>knee_angle</coordinates><axis>1 0 0</axis>
          <LinearFunction><coefficients>0.01 0</coefficients></LinearFunction></TransformAxis>
        </SpatialTransform></CustomJoint>
       <CustomJoint name="groove"><socket_parent_frame>/bodyset/femur</socket_parent_frame>
        <socket_child_frame>/bodyset/patella</socket_child_frame>
        <coordinates><Coordinate name="beta"><default_value>7</default_value></Coordinate></coordinates>
        <SpatialTransform><TransformAxis name="rotation1"><coordinates>beta</coordinates><axis>1 0 0</axis>
          <LinearFunction><coefficients>1 0</coefficients></LinearFunction></TransformAxis></SpatialTransform></CustomJoint>
       <WeldJoint name="base"><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>/bodyset/femur</socket_child_frame></WeldJoint>
       <WeldJoint name="end"><socket_parent_frame>/bodyset/tibia</socket_parent_frame><socket_child_frame>/bodyset/empty</socket_child_frame></WeldJoint>
      </objects></JointSet>
      <ConstraintSet><objects>
       <CoordinateCouplerConstraint name="led"><coupled_coordinates_function><LinearFunction><coefficients>0.5 0</coefficients></LinearFunction></coupled_coordinates_function>
        <independent_coordinate_names>knee_angle</independent_coordinate_names><dependent_coordinate_name>beta</dependent_coordinate_name><scale_factor>-1</scale_factor></CoordinateCouplerConstraint>
       <PointConstraint name="other"/></objects></ConstraintSet></Model></OpenSimDocument>"#;

    #[test]
    fn bodies_joints_and_couplers_are_read() {
        let model = OsimModel::parse(LEG, Path::new("leg.osim")).unwrap();
        let meshes = model.bodies.iter().map(|b| b.meshes.len());
        assert_eq!(meshes.collect::<Vec<_>>(), [1, 2, 1, 0]);
        assert_eq!((model.bodies[0].mass, model.bodies[0].meshes[0].scale.y), (3.0, 2.0));
        assert!((model.bodies[2].meshes[0].body_from_mesh.translation.z - 2.0).abs() < 1e-12);
        assert_eq!(model.notes, ["constraint other is not used"]);
        let values = model.default_values();
        assert_eq!((values["knee_angle"], values["beta"]), (0.5, -0.25));
        let world = places(&model.joints, &values);
        let tibia = world["tibia"];
        assert!((tibia.rotation.angle() - 0.5).abs() < 1e-12);
        assert!((tibia.translation.vector - Vec3::new(0.005, -0.4, 0.0)).norm() < 1e-12);
        assert!((world["patella"].rotation.angle() - 0.25).abs() < 1e-12);
    }

    #[test]
    fn mistakes_are_named() {
        let message =
            |text: &str| OsimModel::parse(text, Path::new("a.osim")).unwrap_err().to_string();
        assert!(message("<a").contains("XML"));
        assert!(message(&LEG.replace("40000", "30000")).contains("OpenSim 4"));
        assert!(message(&LEG.replace("0 -0.4 0", "0 x 0")).contains("knee"));
        assert!(message(&LEG.replace("mesh_file", "other")).contains("no body"));
        let range = LEG.replace("-2 0.1", "0.1 -2");
        assert!(message(&range).contains("joint knee: <range> of coordinate knee_angle"));
        let axis = LEG.replace("<axis>0 0 1</axis>", "<axis>0 0 0</axis>");
        assert!(message(&axis).contains("joint knee: rotation1: <axis>"));
        let stranger = LEG.replacen("<coordinates>knee_angle<", "<coordinates>elbow<", 1);
        assert!(message(&stranger).contains("no coordinate elbow"));
        let several = LEG.replacen("<coordinates>knee_angle<", "<coordinates>knee_angle beta<", 1);
        assert!(message(&several).contains("several coordinates"));
    }
}
