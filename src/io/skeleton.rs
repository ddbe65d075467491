//! The skeleton file `*.skeleton.json`: bones, joints as a graph with loops, soft tissues.
//!
//! JSON, because joints with two frames and loops fit neither glTF nor URDF nor BVH. The short form
//! of `skeleton.json` with one entry per hinge (centre, axis, range) is read too.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::skeleton_hinges::HingeDocument;
use crate::error::{Error, Result};

/// Value of `format`.
pub const FORMAT: &str = "anatomical-skeleton";
/// Value of `version` that is written; higher ones are refused.
pub const VERSION: u32 = 1;

/// A skeleton file. Lengths are in the unit of the meshes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkeletonDocument {
    /// Always [`FORMAT`].
    pub format: String,
    /// Version of the format.
    pub version: u32,
    /// Unit of length in words, such as "mm"; for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub units: Option<String>,
    /// World frame in words, such as "LPS" or "RAS"; for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// Bones.
    pub bones: Vec<BoneEntry>,
    /// Joints.
    #[serde(default)]
    pub joints: Vec<JointEntry>,
    /// Soft tissues that ride on the bones.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub soft: Vec<SoftEntry>,
    /// Shape model file (`.h5.json`), relative to this file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub statistics: Option<String>,
    /// Motion files (`.mot`, `.bvh`), relative to this file.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub animations: Vec<String>,
    /// Cluster radii from coarse to fine; null = infinite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clusters: Option<Vec<Option<f64>>>,
    /// What the template looks like in an image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_image: Option<ReferenceImage>,
    /// What a registration found; kept as it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub result: Option<serde_json::Value>,
}

/// An image in which the template lies on the bones, or what was taken from it. Paths are relative to
/// the skeleton file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceImage {
    /// The image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<String>,
    /// Profiles (`.profiles.json`) sampled from it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profiles: Option<String>,
}

/// One bone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoneEntry {
    /// Unique name.
    pub name: String,
    /// Surface mesh, relative to the skeleton file.
    pub mesh: String,
    /// Value in label maps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<u32>,
}

/// A soft tissue surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoftEntry {
    /// Unique name.
    pub name: String,
    /// Surface mesh, relative to the skeleton file.
    pub mesh: String,
}

/// One joint. Without frames it is placed in the middle of the narrowest gap between its bones.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointEntry {
    /// Unique name.
    pub name: String,
    /// Name of the parent bone.
    pub parent: String,
    /// Name of the child bone.
    pub child: String,
    /// Joint frame on the parent, in world coordinates of the template's pose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent_frame: Option<FrameEntry>,
    /// Joint frame on the child; the parent's where it is missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub child_frame: Option<FrameEntry>,
    /// Names of the rotations about x, y, z of the joint frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<[String; 3]>,
    /// Limits.
    pub limits: LimitsEntry,
    /// False for a joint that only closes a loop.
    #[serde(default = "yes", skip_serializing_if = "Clone::clone")]
    pub tree: bool,
    /// Where the joint comes from, in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// Named angles for motions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub coordinates: Vec<CoordinateEntry>,
}

/// A rigid frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameEntry {
    /// Origin.
    pub t: [f64; 3],
    /// Rotation, unit quaternion w, x, y, z.
    pub q: [f64; 4],
}

/// Limits of a joint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LimitsEntry {
    /// Largest rotations, degrees; free where they are missing.
    #[serde(default)]
    pub rot_deg: SidesEntry,
    /// Largest distance of the two joint points; half a percent of the skeleton's diagonal where it
    /// is missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shift: Option<f64>,
    /// Only "ellipsoid" is known.
    #[serde(default = "ellipsoid")]
    pub shape: String,
    /// Whether they are "soft", "hard" or "none" to a registration; what the run says where it is missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rule: Option<String>,
}

/// Largest rotations in both senses about x, y, z, degrees, from 0 upwards; null = free.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SidesEntry {
    /// Negative sense.
    #[serde(default)]
    pub neg: [Option<f64>; 3],
    /// Positive sense.
    #[serde(default)]
    pub pos: [Option<f64>; 3],
}

/// A named angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoordinateEntry {
    /// Name as in motion files.
    pub name: String,
    /// Axis in the joint's parent frame.
    pub axis: [f64; 3],
    /// Lowest and highest angle, degrees.
    pub range_deg: [f64; 2],
}

fn yes() -> bool {
    true
}

fn ellipsoid() -> String {
    "ellipsoid".into()
}

impl SkeletonDocument {
    /// Reads the text of a skeleton file; `path` is for error messages.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let line = |e: &serde_json::Error| Some(e.line()).filter(|&l| l > 0);
        let value: serde_json::Value = serde_json::from_str(text)
            .map_err(|e| Error::parse(path, line(&e), format!("not valid JSON: {e}")))?;
        if value.get("format").is_none() && value.get("bones").is_some() {
            return HingeDocument::parse(text, path)?.into_document(path);
        }
        let format = value.get("format").and_then(|f| f.as_str());
        if format != Some(FORMAT) {
            return Err(Error::parse(
                path,
                None,
                format!("\"format\" must be \"{FORMAT}\"; this is not a skeleton file"),
            ));
        }
        if value.get("version").and_then(serde_json::Value::as_u64) > Some(u64::from(VERSION)) {
            return Err(Error::parse(
                path,
                None,
                format!(
                    "written by a newer version (\"version\" above {VERSION}); update this program"
                ),
            ));
        }
        let document: Self =
            serde_json::from_str(text).map_err(|e| Error::parse(path, line(&e), e.to_string()))?;
        for joint in &document.joints {
            if joint.limits.shape != "ellipsoid" {
                return Err(Error::parse(
                    path,
                    None,
                    format!("joint {}: \"shape\" of limits must be \"ellipsoid\"", joint.name),
                ));
            }
        }
        Ok(document)
    }

    /// The text of the file.
    pub fn to_text(&self) -> Result<String> {
        serde_json::to_string_pretty(self)
            .map_err(|e| Error::invalid(format!("the skeleton cannot be written as JSON: {e}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = r#"{ "format": "anatomical-skeleton", "version": 1, "units": "mm",
      "bones": [{"name": "a", "mesh": "a.obj"}, {"name": "b", "mesh": "b.obj", "label": 4}],
      "joints": [{"name": "ab", "parent": "a", "child": "b",
        "parent_frame": {"t": [1, 2, 3], "q": [1, 0, 0, 0]},
        "limits": {"rot_deg": {"neg": [20, 10, 0], "pos": [120, null, 5]}, "shift": 1.0}}] }"#;

    #[test]
    fn a_file_survives_the_way_there_and_back() {
        let path = Path::new("a.skeleton.json");
        let document = SkeletonDocument::parse(SMALL, path).unwrap();
        assert_eq!(document.joints[0].limits.rot_deg.pos[1], None);
        assert!(document.joints[0].tree);
        let text = document.to_text().unwrap();
        assert_eq!(SkeletonDocument::parse(&text, path).unwrap(), document);
    }

    #[test]
    fn mistakes_are_named() {
        let path = Path::new("a.skeleton.json");
        let message = |text: &str| SkeletonDocument::parse(text, path).unwrap_err().to_string();
        assert!(message("{").contains("line 1"));
        assert!(message(r#"{"format": "other"}"#).contains("not a skeleton file"));
        assert!(message(&SMALL.replace("\"version\": 1", "\"version\": 9")).contains("newer"));
        assert!(message(&SMALL.replace("\"child\"", "\"chlid\"")).contains("chlid"));
        let shape = SMALL.replace("\"shift\": 1.0", "\"shape\": \"box\"");
        assert!(message(&shape).contains("ellipsoid"));
    }
}
