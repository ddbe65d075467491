//! Joints that follow an angle: from what a skeleton file says to paths, and back.

use nalgebra::Isometry3;

use crate::error::{Error, Result};
use crate::io::skeleton::{FollowsEntry, FrameEntry, SkeletonDocument, StationEntry};
use crate::register::animation::present_angle;
use crate::register::glide::gliding_path;
use crate::register::{JointPath, Skeleton};

/// Gives all joints that follow an angle their paths. What glides does so on the bones as they are.
pub(super) fn build_paths(skeleton: &mut Skeleton, document: &SkeletonDocument) -> Result<()> {
    let following = document.joints.iter().enumerate();
    let following = following.filter_map(|(j, joint)| Some((j, joint.follows.as_ref()?)));
    let (gliding, given): (Vec<_>, Vec<_>) = following.partition(|(_, entry)| entry.glide);
    // Those that glide follow bones that may have paths.
    for (j, entry) in given.into_iter().chain(gliding) {
        let path = path(skeleton, j, entry)
            .map_err(|e| Error::invalid(format!("joint {}: {e}", skeleton.joints[j].name)))?;
        skeleton.joints[j].path = Some(path);
    }
    Ok(())
}

/// Paths on a person's own bones. A bone that cannot glide there keeps the template's path, also in the
/// document; it is told in a sentence.
pub fn settle_paths(skeleton: &mut Skeleton, document: &mut SkeletonDocument) -> Vec<String> {
    let mut notes = Vec::new();
    for (j, joint) in document.joints.iter_mut().enumerate() {
        let Some(entry) = joint.follows.as_mut().filter(|entry| entry.glide) else { continue };
        match path(skeleton, j, entry) {
            Ok(path) => skeleton.joints[j].path = Some(path),
            Err(error) => {
                joint.follows = skeleton.joints[j].path.as_ref().map(follows_entry);
                let name = &joint.name;
                notes.push(format!("joint {name}: {error}; in motions it goes as in the template"));
            }
        }
    }
    notes
}

fn path(skeleton: &Skeleton, j: usize, entry: &FollowsEntry) -> Result<JointPath> {
    if present_angle(skeleton, &entry.angle).is_none() {
        return Err(Error::invalid(format!(
            "no joint has the angle {} that it follows",
            entry.angle
        )));
    }
    match (entry.glide, entry.path.as_slice()) {
        (true, []) => gliding_path(skeleton, j, &entry.angle),
        (false, stations @ [_, ..]) => given_path(&entry.angle, stations),
        _ => Err(Error::invalid("\"follows\" needs \"glide\": true, or a \"path\"")),
    }
}

/// What a skeleton file says of a path.
pub(super) fn follows_entry(path: &JointPath) -> FollowsEntry {
    let station = |(angle, place): (f64, &Isometry3<f64>)| {
        let FrameEntry { t, q } = place.into();
        StationEntry { deg: f64::to_degrees(angle), t, q }
    };
    FollowsEntry {
        angle: path.leader().into(),
        glide: false,
        path: path.stations().map(station).collect(),
    }
}

fn given_path(leader: &str, stations: &[StationEntry]) -> Result<JointPath> {
    let place = |station: &StationEntry| {
        let frame = FrameEntry { t: station.t, q: station.q }.isometry();
        let frame = frame
            .ok_or_else(|| Error::invalid("\"q\" of a path must be a unit quaternion w, x, y, z"));
        Ok((station.deg.to_radians(), frame?))
    };
    JointPath::new(leader.into(), stations.iter().map(place).collect::<Result<_>>()?)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{build_paths, settle_paths};
    use crate::error::Result;
    use crate::io::skeleton::SkeletonDocument;
    use crate::job::register::skeleton_build::{build_skeleton, document_of};
    use crate::locate::test_shapes::sphere;
    use crate::math::Vec3;
    use crate::mesh::TriMesh;
    use crate::register::Skeleton;
    use crate::register::animation::{posed, present_angles};

    const LEG: &str = r#"{ "units": "mm", "bones": [
        {"bone": "femur", "file": "a.obj"}, {"bone": "tibia", "file": "b.obj"}, {"bone": "patella", "file": "c.obj"}],
      "joints": [
        {"name": "knee", "parent": "femur", "child": "tibia", "type": "hinge", "centre_mm": [0, 0, 0],
         "axis": [0, 1, 0], "range_rad": [0, 2]},
        {"name": "groove", "parent": "femur", "child": "patella", "type": "6dof, small", "centre_mm": [50, 0, 0],
         "axis": [0, 1, 0], "range_rad": [0, 0], "follows": {"angle": "knee", "glide": true}}] }"#;

    fn document(text: &str) -> SkeletonDocument {
        SkeletonDocument::parse(text, Path::new("leg.json")).unwrap()
    }

    fn built(text: &str) -> Result<Skeleton> {
        let ball = |radius: f64, x: f64, z: f64| {
            let (points, triangles) = sphere(24, 48);
            let placed = points.iter().map(|p| p * radius + Vec3::new(x, 0.0, z));
            TriMesh { points: placed.collect(), triangles }
        };
        let bones = vec![ball(40.0, 0.0, 0.0), ball(20.0, 0.0, -70.0), ball(5.0, 50.0, 0.0)];
        build_skeleton(&document(text), bones)
    }

    fn surfaces(skeleton: &Skeleton) -> Vec<TriMesh> {
        (0..3).map(|b| skeleton.bone_surface(b, &skeleton.points)).collect()
    }

    #[test]
    fn a_knee_cap_glides_on_the_thigh_with_the_shin_and_goes_on_from_there_in_a_file() {
        let skeleton = built(LEG).unwrap();
        let motions = posed(&skeleton, 0, |name| (name == "knee").then_some(1.0));
        for motion in &motions[1..] {
            assert!((motion.rotation.angle() - 1.0).abs() < 0.03, "{motion}");
        }
        let mut bent = skeleton.clone();
        bent.move_bones(&motions);
        let text = document_of(&bent, &document(LEG)).to_text().unwrap();
        assert!(text.contains("\"glide\": true"));
        let again = build_skeleton(&document(&text), surfaces(&bent)).unwrap();
        assert!((present_angles(&again)[0].1 - 1.0).abs() < 1e-9);
        let back = posed(&again, 0, |name| (name == "knee").then_some(0.0));
        for (back, there) in back.iter().zip(&motions) {
            let rest = back * there;
            assert!(rest.translation.vector.norm() < 1.0 && rest.rotation.angle() < 0.03, "{rest}");
        }
        // As a path of its own it is the same to the last digits of the file.
        let text = document_of(&bent, &SkeletonDocument::default()).to_text().unwrap();
        assert!(!text.contains("glide"));
        let again = build_skeleton(&document(&text), surfaces(&bent)).unwrap();
        let back = posed(&again, 0, |name| (name == "knee").then_some(0.0));
        let rest = back[2] * motions[2];
        assert!(rest.translation.vector.norm() < 1e-6 && rest.rotation.angle() < 1e-9, "{rest}");
        let mut same = again.clone();
        build_paths(&mut same, &document(&text)).unwrap();
        assert_eq!(again, same);
    }

    #[test]
    fn a_person_whose_knee_cap_cannot_glide_keeps_the_path_of_the_template() {
        let mut person = built(LEG).unwrap();
        let mut kept = document_of(&person, &document(LEG));
        assert!(settle_paths(&mut person, &mut kept).is_empty());
        assert!(kept.joints[1].follows.as_ref().unwrap().glide);
        let cap = person.bones[2].vertices.clone();
        person.points[cap].iter_mut().for_each(|p| p.x -= 50.0);
        let path = person.joints[1].path.clone();
        let notes = settle_paths(&mut person, &mut kept);
        assert!(notes.len() == 1 && notes[0].contains("lies on the axis"), "{notes:?}");
        assert_eq!(person.joints[1].path, path);
        let again = build_skeleton(&kept, surfaces(&person)).unwrap();
        assert!(again.joints[1].path.is_some());
    }

    #[test]
    fn what_cannot_be_followed_is_named() {
        let station = r#"{"deg": 0, "t": [0, 0, 0], "q": [1, 0, 0, 0]}"#;
        let wrong = [
            (r#""angle": "hip", "glide": true"#.to_string(), "no joint has the angle hip"),
            (r#""angle": "knee""#.to_string(), "needs \"glide\""),
            (format!(r#""angle": "knee", "glide": true, "path": [{station}]"#), "needs \"glide\""),
            (format!(r#""angle": "knee", "path": [{station}]"#), "at least two"),
            (
                format!(r#""angle": "knee", "path": [{station}]"#).replace("[1,", "[0,"),
                "unit quaternion",
            ),
            (format!(r#""angle": "hip", "path": [{station}]"#), "no joint has the angle hip"),
        ];
        for (entry, expected) in wrong {
            let text = LEG.replace(r#""angle": "knee", "glide": true"#, &entry);
            let error = built(&text).unwrap_err().to_string();
            assert!(error.starts_with("joint groove: ") && error.contains(expected), "{error}");
        }
    }
}
