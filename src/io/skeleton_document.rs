//! What a skeleton file holds.

use nalgebra::{Isometry3, Quaternion, UnitQuaternion};
use serde::{Deserialize, Serialize};

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
    /// The angle that leads the joint in motions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub follows: Option<FollowsEntry>,
}

/// How a joint follows an angle: by gliding or on a path.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FollowsEntry {
    /// Name of the angle.
    pub angle: String,
    /// The child glides on the parent's surface, pulled by the bone that the angle moves: a knee cap.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub glide: bool,
    /// Where the joint's frame on the child is, seen from its frame on the parent, at rising angles.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub path: Vec<StationEntry>,
}

/// A place on a path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StationEntry {
    /// The angle there, degrees.
    pub deg: f64,
    /// Origin.
    pub t: [f64; 3],
    /// Rotation, unit quaternion w, x, y, z.
    pub q: [f64; 4],
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

impl FrameEntry {
    /// The frame; none if `q` is no rotation.
    pub fn isometry(&self) -> Option<Isometry3<f64>> {
        let [w, i, j, k] = self.q;
        let rotation = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-6)?;
        Some(Isometry3::from_parts(self.t.into(), rotation))
    }
}

impl From<&Isometry3<f64>> for FrameEntry {
    fn from(frame: &Isometry3<f64>) -> Self {
        let q = frame.rotation.quaternion();
        Self { t: frame.translation.vector.into(), q: [q.w, q.i, q.j, q.k] }
    }
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
