//! The skeleton file `*.skeleton.json`: bones, joints as a graph with loops, soft tissues.
//!
//! JSON, because joints with two frames and loops fit neither glTF nor URDF nor BVH. The short form
//! of `skeleton.json` with one entry per hinge (centre, axis, range) is read too.

use std::path::Path;

pub use super::skeleton_document::{
    BoneEntry, CoordinateEntry, FORMAT, FollowsEntry, FrameEntry, JointEntry, LimitsEntry,
    ReferenceImage, SidesEntry, SkeletonDocument, SoftEntry, StationEntry, VERSION,
};
use super::skeleton_hinges::HingeDocument;
use super::write::file_names;
use crate::error::{Error, Result};

impl SkeletonDocument {
    /// Gives every bone a surface of its own in a folder, relative to the skeleton file: `bones/NAME.obj`.
    pub fn name_surfaces(&mut self, folder: &str) {
        let names = file_names(self.bones.iter().map(|bone| bone.name.as_str()));
        for (bone, name) in self.bones.iter_mut().zip(names) {
            bone.mesh = format!("{folder}/{name}.obj");
        }
    }

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
