//! Landmarks of a skeleton from marker files.

use std::cell::LazyCell;
use std::path::PathBuf;

use crate::error::{Error, Result};
use crate::io::{self, read_landmark_files};
use crate::locate::ClosestPoints;
use crate::math::Vec3;
use crate::register::{Landmark, Skeleton};

/// Landmarks with their names.
#[derive(Clone, Debug, Default)]
pub struct BoneLandmarks {
    /// In the files' order.
    pub landmarks: Vec<Landmark>,
    /// Their names.
    pub names: Vec<String>,
    /// Names that only one of two files has, in a sentence.
    pub warning: Option<String>,
}

/// Reads landmarks from one file of pairs, or from two marker files (template, person) whose points are
/// paired by name. A landmark is on the bone that its name begins with (`femur`, `femur: head`), else on
/// the nearest one.
pub fn read_bone_landmarks(files: &[PathBuf], skeleton: &Skeleton) -> Result<BoneLandmarks> {
    let (list, warning) = read_landmark_files(files)?;
    let mut found = BoneLandmarks { warning, ..BoneLandmarks::default() };
    let search = LazyCell::new(|| ClosestPoints::new(&skeleton.points, &skeleton.triangles));
    let nearest_bone = |position: &Vec3| {
        let found = search.closest(position)?;
        let vertex = skeleton.triangles[found.triangle as usize][0];
        skeleton.bones.iter().position(|bone| bone.vertices.contains(&(vertex as usize)))
    };
    for (k, landmark) in list.into_iter().enumerate() {
        let name = landmark.label.clone().unwrap_or_else(|| k.to_string());
        let (bone, place) = place(&landmark, &name, skeleton, nearest_bone)?;
        let (target, weight) = (landmark.target, landmark.weight.unwrap_or(1.0));
        let landmark_on_bone = Landmark { bone, place, target, weight };
        landmark_on_bone.check(skeleton).map_err(|e| {
            let (path, line) = &landmark.anchor.source;
            Error::parse(path, *line, format!("landmark {name} {e}"))
        })?;
        found.landmarks.push(landmark_on_bone);
        found.names.push(name);
    }
    Ok(found)
}

/// The bone and the place on it.
fn place(
    landmark: &io::Landmark,
    name: &str,
    skeleton: &Skeleton,
    nearest_bone: impl Fn(&Vec3) -> Option<usize>,
) -> Result<(usize, Vec3)> {
    let anchor = &landmark.anchor;
    match (bone_named(name, skeleton), anchor.position) {
        (Some(bone), _) => {
            let surface = skeleton.bone_surface(bone, &skeleton.points);
            Ok((bone, anchor.resolve(&surface)?.position))
        }
        (None, Some(position)) => Ok((nearest_bone(&position).unwrap_or(0), position)),
        (None, None) => {
            let (path, line) = &anchor.source;
            let what = format!(
                "landmark {name} has a vertex number, but no bone; name it as its bone, such as {}",
                skeleton.bones[0].name
            );
            Err(Error::parse(path, *line, what))
        }
    }
}

/// The bone whose name is the whole of `name`, or its beginning up to something that is no letter or
/// digit; the longest such name.
fn bone_named(name: &str, skeleton: &Skeleton) -> Option<usize> {
    let is_start = |bone: &str| {
        name.strip_prefix(bone)
            .is_some_and(|rest| rest.chars().next().is_none_or(|c| !c.is_alphanumeric()))
    };
    (0..skeleton.bones.len())
        .filter(|&b| is_start(&skeleton.bones[b].name))
        .max_by_key(|&b| skeleton.bones[b].name.len())
}
