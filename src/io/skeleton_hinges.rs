//! The short skeleton form: one entry per hinge with centre, axis and range.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde::Deserialize;

use super::skeleton_document::{
    BoneEntry, CoordinateEntry, FORMAT, FollowsEntry, JointEntry, LimitsEntry, SidesEntry,
    SkeletonDocument, VERSION,
};
use crate::error::{Error, Result};

/// Rotation allowed each way in a joint said to be fixed, degrees: bones of another person do not
/// meet at the same angle.
const FIXED_DEGREES: f64 = 10.0;
/// The same for a joint with six small freedoms.
const LOOSE_DEGREES: f64 = 20.0;
/// Shift allowed in such a joint, millimetres (the form's own unit).
const LOOSE_SHIFT: f64 = 10.0;
/// Rotation allowed about an axis without a hinge, degrees: the axes of two persons differ a little.
const OFF_AXIS_DEGREES: f64 = 3.0;

/// The file.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct HingeDocument {
    units: Option<String>,
    bones: Vec<HingeBone>,
    #[serde(default)]
    joints: Vec<Hinge>,
}

#[derive(Clone, Debug, Deserialize)]
struct HingeBone {
    bone: String,
    file: String,
    /// Value in label maps.
    label: Option<u32>,
    body: Option<String>,
    parent_body: Option<String>,
}

#[derive(Clone, Debug, Deserialize)]
struct Hinge {
    name: String,
    #[serde(alias = "parent_body")]
    parent: String,
    #[serde(alias = "child_body")]
    child: String,
    #[serde(rename = "type")]
    kind: String,
    #[serde(rename = "centre_mm")]
    centre: [f64; 3],
    axis: [f64; 3],
    range_rad: [f64; 2],
    /// The angle that leads the joint in motions.
    follows: Option<FollowsEntry>,
}

impl HingeDocument {
    pub(super) fn parse(text: &str, path: &Path) -> Result<Self> {
        serde_json::from_str(text).map_err(|e| Error::parse(path, e.line(), e.to_string()))
    }

    /// Hinges with the same bones become one joint; bones with a parent but no hinge get a fixed
    /// one; hinges to bones that are not there are left out.
    pub(super) fn into_document(self, path: &Path) -> Result<SkeletonDocument> {
        let bone_of: HashMap<&str, &str> = self
            .bones
            .iter()
            .map(|b| (b.body.as_deref().unwrap_or(&b.bone), b.bone.as_str()))
            .collect();
        let mut groups: Vec<((&str, &str), Vec<&Hinge>)> = Vec::new();
        for hinge in &self.joints {
            let ends = (bone_of.get(hinge.parent.as_str()), bone_of.get(hinge.child.as_str()));
            if let (Some(&parent), Some(&child)) = ends {
                match groups.iter_mut().find(|(bones, _)| *bones == (parent, child)) {
                    Some((_, hinges)) => hinges.push(hinge),
                    None => groups.push(((parent, child), vec![hinge])),
                }
            }
        }
        let mut joints = groups
            .iter()
            .map(|((parent, child), hinges)| joint(parent, child, hinges, path))
            .collect::<Result<Vec<_>>>()?;
        for bone in &self.bones {
            let parent = bone.parent_body.as_deref().and_then(|p| bone_of.get(p));
            if let Some(&parent) = parent
                && !groups.iter().any(|((_, child), _)| *child == bone.bone)
            {
                joints.push(fixed(parent, &bone.bone));
            }
        }
        Ok(SkeletonDocument {
            format: FORMAT.into(),
            version: VERSION,
            units: self.units.clone(),
            bones: self
                .bones
                .iter()
                .map(|b| BoneEntry { name: b.bone.clone(), mesh: b.file.clone(), label: b.label })
                .collect(),
            joints,
            ..SkeletonDocument::default()
        })
    }
}

fn fixed(parent: &str, child: &str) -> JointEntry {
    let side = [Some(FIXED_DEGREES); 3];
    JointEntry {
        name: format!("{parent}_{child}"),
        parent: parent.into(),
        child: child.into(),
        limits: LimitsEntry {
            rot_deg: SidesEntry { neg: side, pos: side },
            shape: "ellipsoid".into(),
            ..LimitsEntry::default()
        },
        tree: true,
        source: Some("fixed".into()),
        ..JointEntry::default()
    }
}

fn joint(parent: &str, child: &str, hinges: &[&Hinge], path: &Path) -> Result<JointEntry> {
    let first = hinges[0];
    let mut entry = fixed(parent, child);
    entry.name = hinges.iter().map(|h| h.name.as_str()).collect::<Vec<_>>().join("+");
    let axes = frame_axes(hinges, path)?;
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    let centre = Vector3::from(first.centre);
    entry.parent_frame = Some((&Isometry3::from_parts(centre.into(), rotation)).into());
    entry.source = Some(first.kind.clone());
    entry.follows.clone_from(&first.follows);
    if first.kind != "hinge" {
        if first.kind.starts_with("6dof") {
            let side = [Some(LOOSE_DEGREES); 3];
            entry.limits.rot_deg = SidesEntry { neg: side, pos: side };
            entry.limits.shift = Some(LOOSE_SHIFT);
        }
        return Ok(entry);
    }
    if hinges.len() > 3 {
        let message =
            format!("more than three hinges between {parent} and {child}; join some of them");
        return Err(Error::parse(path, None, message));
    }
    let side = [Some(OFF_AXIS_DEGREES); 3];
    let mut sides = SidesEntry { neg: side, pos: side };
    let mut names: [String; 3] = std::array::from_fn(|_| String::new());
    for (k, hinge) in hinges.iter().enumerate() {
        let local = axes.transpose() * Vector3::from(hinge.axis).normalize();
        // A third axis may point against the frame's own.
        let reversed = local[k] < 0.0;
        let [low, high] = hinge.range_rad.map(f64::to_degrees);
        let (neg, pos) = if reversed { (high, -low) } else { (-low, high) };
        sides.neg[k] = Some(neg.max(0.0));
        sides.pos[k] = Some(pos.max(0.0));
        names[k].clone_from(&hinge.name);
        entry.coordinates.push(CoordinateEntry {
            name: hinge.name.clone(),
            axis: local.into(),
            range_deg: [low, high],
        });
    }
    entry.limits.rot_deg = sides;
    entry.axes = Some(names);
    Ok(entry)
}

/// Right-handed axes: the first hinge's, the second's made perpendicular, and their product.
fn frame_axes(hinges: &[&Hinge], path: &Path) -> Result<Matrix3<f64>> {
    let axis = |h: &Hinge| {
        Vector3::from(h.axis)
            .try_normalize(1e-9)
            .filter(|a| a.iter().all(|c| c.is_finite()))
            .ok_or_else(|| {
                Error::parse(path, None, format!("joint {}: \"axis\" must not be zero", h.name))
            })
    };
    let x = axis(hinges[0])?;
    let beside = |v: Vector3<f64>| (v - x * x.dot(&v)).try_normalize(0.05);
    let second = match hinges.get(1) {
        Some(h) => beside(axis(h)?),
        None => None,
    };
    let any = || Vector3::ith(x.iamin(), 1.0);
    let y = second.or_else(|| beside(any())).ok_or_else(|| {
        Error::parse(path, None, format!("joint {}: axes are not usable", hinges[0].name))
    })?;
    Ok(Matrix3::from_columns(&[x, y, x.cross(&y)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hinges_become_joints_and_missing_ones_fixed_joints() {
        let text = r#"{ "units": "mm", "bones": [
          {"bone": "2mc", "body": "secondmc", "parent_body": "capitate", "file": "2mc.obj"},
          {"bone": "cap", "body": "capitate", "parent_body": "lunate", "file": "cap.obj"},
          {"bone": "2px", "body": "proxph2", "parent_body": "secondmc", "file": "2px.obj"}],
         "joints": [
          {"name": "flex", "parent_body": "secondmc", "child_body": "proxph2", "type": "hinge",
           "centre_mm": [1, 2, 3], "axis": [0, 1, 0], "range_rad": [0, 1.5]},
          {"name": "abd", "parent_body": "secondmc", "child_body": "proxph2", "type": "hinge",
           "centre_mm": [1, 2, 3], "axis": [1, 0.1, 0], "range_rad": [-0.2, 0.3]},
          {"name": "wrist", "parent_body": "radius", "child_body": "capitate", "type": "hinge",
           "centre_mm": [0, 0, 0], "axis": [1, 0, 0], "range_rad": [0, 1]}] }"#;
        let document = SkeletonDocument::parse(text, Path::new("skeleton.json")).unwrap();
        assert_eq!(document.joints.len(), 2);
        let knuckle = &document.joints[0];
        assert_eq!((knuckle.parent.as_str(), knuckle.child.as_str()), ("2mc", "2px"));
        assert!((knuckle.limits.rot_deg.pos[0].unwrap() - 1.5_f64.to_degrees()).abs() < 1e-9);
        assert!((knuckle.limits.rot_deg.neg[1].unwrap() - 0.2_f64.to_degrees()).abs() < 1e-9);
        assert_eq!(knuckle.coordinates.len(), 2);
        assert_eq!(document.joints[1].name, "cap_2mc");
        assert!(document.joints[1].parent_frame.is_none());
        let zero = text.replace("[0, 1, 0]", "[0, 0, 0]");
        let error = SkeletonDocument::parse(&zero, Path::new("s.json")).unwrap_err();
        assert!(error.to_string().contains("flex"));
    }
}
