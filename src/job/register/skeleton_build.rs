//! From a skeleton document and its meshes to the skeleton that the algorithms work on, and back.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use super::skeleton_paths::{build_paths, follows_entry};
use crate::error::{Error, Result};
use crate::io::skeleton::{
    BoneEntry, CoordinateEntry, FORMAT, FrameEntry, JointEntry, LimitsEntry, SidesEntry,
    SkeletonDocument, VERSION,
};
use crate::locate::ClosestPoints;
use crate::math::Vec3;
use crate::mesh::{TriMesh, diagonal};
use crate::register::{Coordinate, Joint, JointLimits, Limits, Skeleton};

/// Shift limit of a joint that gives none, as a share of the skeleton's diagonal.
const DEFAULT_SHIFT: f64 = 0.005;
/// Candidates for the narrowest gap between two bones, on each side.
const GAP_SAMPLES: usize = 2000;

/// Builds the skeleton from its document and the surface of each bone, in the document's order.
pub fn build_skeleton(document: &SkeletonDocument, meshes: Vec<TriMesh>) -> Result<Skeleton> {
    let points: Vec<Vec3> = meshes.iter().flat_map(|m| m.points.iter().copied()).collect();
    let diagonal = diagonal(&points);
    let mut joints = Vec::new();
    for entry in &document.joints {
        let bone = |name: &str| {
            document.bones.iter().position(|b| b.name == *name).ok_or_else(|| {
                Error::invalid(format!("joint {}: there is no bone named {name}", entry.name))
            })
        };
        let ends = [bone(&entry.parent)?, bone(&entry.child)?];
        joints.push(build_joint(entry, ends, &meshes, diagonal)?);
    }
    let surfaces = document.bones.iter().map(|b| b.name.clone()).zip(meshes).collect();
    let mut skeleton = Skeleton::new(surfaces, joints)?;
    for (bone, entry) in skeleton.bones.iter_mut().zip(&document.bones) {
        bone.label = entry.label;
    }
    build_paths(&mut skeleton, document)?;
    Ok(skeleton)
}

/// Shift limit of a joint that gives none.
pub fn default_shift(diagonal: f64) -> f64 {
    DEFAULT_SHIFT * diagonal
}

fn build_joint(
    entry: &JointEntry,
    ends: [usize; 2],
    meshes: &[TriMesh],
    diagonal: f64,
) -> Result<Joint> {
    let frame = |f: &FrameEntry| {
        f.isometry().ok_or_else(|| {
            Error::invalid(format!(
                "joint {}: \"q\" must be a unit quaternion w, x, y, z",
                entry.name
            ))
        })
    };
    let given =
        [&entry.parent_frame, &entry.child_frame].map(|f| f.as_ref().map(frame).transpose());
    let [parent_frame, child_frame] = given;
    let (parent_frame, child_frame) = match (parent_frame?, child_frame?) {
        (Some(p), Some(c)) => (p, c),
        (Some(f), None) | (None, Some(f)) => (f, f),
        (None, None) => {
            let middle = middle_of_gap(&meshes[ends[0]], &meshes[ends[1]]);
            let frame =
                Isometry3::from_parts(Translation3::from(middle), UnitQuaternion::identity());
            (frame, frame)
        }
    };
    let side =
        |s: &[Option<f64>; 3]| Vec3::from_fn(|k, _| s[k].map_or(f64::INFINITY, f64::to_radians));
    let sides = &entry.limits.rot_deg;
    let shift = entry.limits.shift.unwrap_or(default_shift(diagonal));
    let limits = JointLimits::new(side(&sides.neg), side(&sides.pos), shift)
        .map_err(|e| Error::invalid(format!("joint {}: {e}", entry.name)))?;
    let rule = entry.limits.rule.as_deref().map(|name| {
        Limits::named(name).ok_or_else(|| {
            let name = &entry.name;
            Error::invalid(format!(
                "joint {name}: \"rule\" of limits must be \"soft\", \"hard\" or \"none\""
            ))
        })
    });
    let limits = JointLimits { rule: rule.transpose()?, ..limits };
    let coordinates =
        entry.coordinates.iter().map(|c| coordinate(c, entry)).collect::<Result<_>>()?;
    Ok(Joint {
        name: entry.name.clone(),
        parent: ends[0],
        child: ends[1],
        parent_frame,
        child_frame,
        limits,
        in_tree: entry.tree,
        coordinates,
        path: None,
    })
}

fn coordinate(entry: &CoordinateEntry, joint: &JointEntry) -> Result<Coordinate> {
    let axis = Vec3::from(entry.axis).try_normalize(1e-9).ok_or_else(|| {
        Error::invalid(format!("joint {}: coordinate {} has no axis", joint.name, entry.name))
    })?;
    Ok(Coordinate { name: entry.name.clone(), axis, range: entry.range_deg.map(f64::to_radians) })
}

/// The middle between the nearest points of two bones.
fn middle_of_gap(a: &TriMesh, b: &TriMesh) -> Vec3 {
    let nearest = |from: &TriMesh, to: &TriMesh| {
        let search = ClosestPoints::new(&to.points, &to.triangles);
        let step = from.points.len().div_ceil(GAP_SAMPLES).max(1);
        let hits = from.points.iter().step_by(step).filter_map(|p| {
            let hit = search.closest(p)?;
            Some((hit.distance, (p + hit.position) / 2.0))
        });
        hits.min_by(|x, y| x.0.total_cmp(&y.0))
    };
    let both = [nearest(a, b), nearest(b, a)];
    let best = both.into_iter().flatten().min_by(|x, y| x.0.total_cmp(&y.0));
    best.map_or_else(Vec3::zeros, |(_, middle)| middle)
}

/// The document of a skeleton; bone meshes are named `bones/<name>.obj`.
pub fn skeleton_document(skeleton: &Skeleton) -> SkeletonDocument {
    let bones = skeleton.bones.iter().map(|b| BoneEntry {
        name: b.name.clone(),
        mesh: format!("bones/{}.obj", b.name),
        label: b.label,
    });
    let ends = |j: &Joint| [j.parent, j.child].map(|b| skeleton.bones[b].name.clone());
    SkeletonDocument {
        format: FORMAT.into(),
        version: VERSION,
        bones: bones.collect(),
        joints: skeleton.joints.iter().map(|j| joint_entry(ends(j), j)).collect(),
        ..SkeletonDocument::default()
    }
}

/// The document of a skeleton that came from another one, such as a person's from a template's: with all that
/// the other's document says in words.
pub fn document_of(skeleton: &Skeleton, template: &SkeletonDocument) -> SkeletonDocument {
    let mut document = skeleton_document(skeleton);
    document.units.clone_from(&template.units);
    document.frame.clone_from(&template.frame);
    for (entry, old) in document.joints.iter_mut().zip(&template.joints) {
        entry.axes.clone_from(&old.axes);
        entry.source.clone_from(&old.source);
        if old.follows.as_ref().is_some_and(|follows| follows.glide) {
            entry.follows.clone_from(&old.follows);
        }
    }
    document
}

/// The entry of a joint between the bones named parent and child.
pub fn joint_entry([parent, child]: [String; 2], joint: &Joint) -> JointEntry {
    let side = |s: &Vec3| std::array::from_fn(|k| s[k].is_finite().then(|| s[k].to_degrees()));
    let coordinates = joint.coordinates.iter().map(|c| CoordinateEntry {
        name: c.name.clone(),
        axis: c.axis.into(),
        range_deg: c.range.map(f64::to_degrees),
    });
    JointEntry {
        name: joint.name.clone(),
        parent,
        child,
        parent_frame: Some((&joint.parent_frame).into()),
        child_frame: Some((&joint.child_frame).into()),
        axes: None,
        limits: LimitsEntry {
            rot_deg: SidesEntry {
                neg: side(&joint.limits.negative),
                pos: side(&joint.limits.positive),
            },
            shift: joint.limits.shift.is_finite().then_some(joint.limits.shift),
            shape: "ellipsoid".into(),
            rule: joint.limits.rule.map(|rule| rule.name().into()),
        },
        tree: joint.in_tree,
        source: None,
        coordinates: coordinates.collect(),
        follows: joint.path.as_ref().map(follows_entry),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn triangle(x: f64) -> TriMesh {
        let points = [[x, 0., 0.], [x + 1.0, 0., 0.], [x, 1., 0.]].map(Vec3::from).to_vec();
        TriMesh::new(points, vec![[0, 1, 2]]).unwrap()
    }

    #[test]
    fn a_joint_without_frames_lies_in_the_gap_and_the_document_comes_back() {
        let text = r#"{ "format": "anatomical-skeleton", "version": 1,
          "bones": [{"name": "a", "mesh": "a.obj"}, {"name": "b", "mesh": "b.obj"}],
          "joints": [{"name": "ab", "parent": "a", "child": "b",
            "limits": {"rot_deg": {"neg": [20, 10, 0], "pos": [120, null, 5]}}}] }"#;
        let document = SkeletonDocument::parse(text, Path::new("a.skeleton.json")).unwrap();
        let skeleton = build_skeleton(&document, vec![triangle(0.0), triangle(3.0)]).unwrap();
        let centre = skeleton.joints[0].parent_frame.translation.vector;
        assert!((centre - Vec3::new(2.0, 0.0, 0.0)).norm() < 1e-12);
        assert!(skeleton.joints[0].limits.positive.y.is_infinite());
        let written = skeleton_document(&skeleton);
        let again = build_skeleton(&written, vec![triangle(0.0), triangle(3.0)]).unwrap();
        assert!((again.joints[0].limits.positive.x - 120_f64.to_radians()).abs() < 1e-12);
        assert_eq!(again.bones, skeleton.bones);

        let mut wrong = document;
        wrong.joints[0].child = "c".into();
        let error = build_skeleton(&wrong, vec![triangle(0.0), triangle(3.0)]).unwrap_err();
        assert!(error.to_string().contains("no bone named c"));
    }
}
