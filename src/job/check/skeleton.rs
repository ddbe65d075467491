//! What is in a skeleton file or an OpenSim model, and what is wrong with it, in words.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Isometry3;

use super::file_check::{FileCheck, extent};
use crate::error::Result;
use crate::io::skeleton::SkeletonDocument;
use crate::job::convert::osim_read::read_osim_skeleton;
use crate::job::register::scene::metres_per_unit;
use crate::job::register::skeleton_build::build_skeleton;
use crate::job::register::skeleton_files::{read_skeleton, read_tissues};
use crate::math::Vec3;
use crate::mesh::{SurfaceCheck, diagonal};
use crate::register::animation::present_angles;
use crate::register::few::few;
use crate::register::rotation::rotation_vector;
use crate::register::{Joint, Skeleton};

/// Names in a sentence at most.
const MOST_NAMED: usize = 5;
/// Degrees beyond a limit that are told.
const BEYOND_DEGREES: f64 = 0.5;
/// Diagonals of skeletons of animals and persons, metres.
const USUAL_SIZE: [f64; 2] = [0.005, 10.0];

/// Looks at a skeleton file, its bones and the files it names.
pub fn skeleton_file(path: &Path) -> Result<FileCheck> {
    let files = read_skeleton(path)?;
    let mut findings = findings(&files.document, &files.skeleton);
    findings.extend(read_tissues(path, &files.document).err().map(|e| e.to_string()));
    let folder = path.parent().unwrap_or(Path::new(""));
    let document = &files.document;
    let image = document.reference_image.iter().flat_map(|r| r.volume.iter().chain(&r.profiles));
    let named = document.statistics.iter().chain(&document.animations).chain(image);
    let missing = named.filter(|name| !folder.join(name).exists());
    findings.extend(missing.map(|name| format!("the file {name} that it names is not there")));
    Ok(FileCheck { content: content(document, &files.skeleton, "a skeleton"), findings })
}

/// Looks at an OpenSim model and the meshes of its bodies.
pub fn osim_file(path: &Path) -> Result<FileCheck> {
    let (document, meshes, mut notes) = read_osim_skeleton(path)?;
    let skeleton = build_skeleton(&document, meshes)?;
    notes.extend(findings(&document, &skeleton));
    Ok(FileCheck { content: content(&document, &skeleton, "an OpenSim model"), findings: notes })
}

fn content(document: &SkeletonDocument, skeleton: &Skeleton, kind: &str) -> String {
    let loops = skeleton.joints.iter().filter(|j| !j.in_tree).count();
    let angles: usize = skeleton.joints.iter().map(|j| j.coordinates.len()).sum();
    let some = |count: usize, what: &str| match count {
        0 => String::new(),
        n => format!(", {n} {what}"),
    };
    // The field is for people and may go on about angles and frames.
    let unit = document.units.as_ref().and_then(|units| units.split([',', ';', ' ']).next());
    format!(
        "{kind} of {} bones with {} vertices, {} joints{}{}{}, {}{}",
        skeleton.bones.len(),
        skeleton.points.len(),
        skeleton.joints.len(),
        some(loops, "of them closing a loop"),
        some(angles, "named angles"),
        some(document.soft.len(), "soft tissues"),
        extent(&skeleton.points),
        unit.map_or(String::new(), |unit| format!(" ({unit})")),
    )
}

fn findings(document: &SkeletonDocument, skeleton: &Skeleton) -> Vec<String> {
    let mut findings = bones(document, skeleton);
    findings.extend(joints(skeleton));
    let metres = diagonal(&skeleton.points) * metres_per_unit(document.units.as_deref());
    if !(USUAL_SIZE[0]..=USUAL_SIZE[1]).contains(&metres) {
        findings.push(format!(
            "the skeleton would be {metres:.3} m large; say the unit of its bones with \"units\": \"mm\", \"cm\" or \"m\""
        ));
    }
    findings
}

fn bones(document: &SkeletonDocument, skeleton: &Skeleton) -> Vec<String> {
    let (mut open, mut inside_out) = (Vec::new(), Vec::new());
    for (b, bone) in skeleton.bones.iter().enumerate() {
        let surface = skeleton.bone_surface(b, &skeleton.points);
        if !SurfaceCheck::new(&surface).open_edges.is_empty() {
            open.push(bone.name.as_str());
        } else if surface.volume() < 0.0 {
            inside_out.push(bone.name.as_str());
        }
    }
    let jointed = |b: usize| skeleton.joints.iter().any(|j| j.neighbour(b).is_some());
    let alone = (0..skeleton.bones.len()).filter(|&b| skeleton.bones.len() > 1 && !jointed(b));
    let alone: Vec<&str> = alone.map(|b| skeleton.bones[b].name.as_str()).collect();
    let mut of_label: BTreeMap<u32, Vec<&str>> = BTreeMap::new();
    for bone in &document.bones {
        if let Some(label) = bone.label {
            of_label.entry(label).or_default().push(&bone.name);
        }
    }
    let told = [
        (open, "have holes"),
        (inside_out, "are inside out; flip their normals"),
        (alone, "have no joint; nothing says where they are if they are not seen"),
    ];
    let mut findings = sentences("bones", &told);
    for (label, names) in of_label.into_iter().filter(|(_, bones)| bones.len() > 1) {
        let what = format!("share the label {label}; give each its own");
        findings.extend(sentences("bones", &[(names, &what)]));
    }
    findings
}

fn joints(skeleton: &Skeleton) -> Vec<String> {
    let still = Isometry3::identity();
    let (mut far, mut apart, mut turned) = (Vec::new(), Vec::new(), Vec::new());
    for joint in &skeleton.joints {
        let ends = [(joint.parent, &joint.parent_frame), (joint.child, &joint.child_frame)];
        let is_far = |(b, frame): (usize, &Isometry3<f64>)| {
            let points = &skeleton.points[skeleton.bones[b].vertices.clone()];
            let middle = points.iter().sum::<Vec3>() / points.len() as f64;
            (frame.translation.vector - middle).norm() > diagonal(points)
        };
        let between = joint.transform(&still, &still);
        if ends.into_iter().all(is_far) {
            far.push(joint.name.as_str());
        }
        if between.translation.vector.norm() > joint.limits.shift {
            apart.push(joint.name.as_str());
        }
        let excess = joint.limits.excess(&rotation_vector(&between.rotation));
        if excess.to_degrees() > BEYOND_DEGREES {
            turned.push(joint.name.as_str());
        }
    }
    let told = [
        (far, "lie further from both their bones than these are long; look at their frames"),
        (apart, "have frames further apart than \"shift\" allows, in the skeleton's own pose"),
        (turned, "are turned beyond their own limits, in the skeleton's own pose"),
    ];
    let mut findings = sentences("joints", &told);
    findings.extend(angles(skeleton));
    findings
}

/// Angles with one name, and those outside their ranges.
fn angles(skeleton: &Skeleton) -> Vec<String> {
    let coordinates = || skeleton.joints.iter().flat_map(|joint: &Joint| &joint.coordinates);
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for coordinate in coordinates() {
        *counts.entry(&coordinate.name).or_default() += 1;
    }
    let twice = counts.iter().filter(|(_, n)| **n > 1).map(|(name, _)| *name).collect();
    let outside = coordinates().zip(present_angles(skeleton)).filter(|(coordinate, (_, angle))| {
        let slack = BEYOND_DEGREES.to_radians();
        !(coordinate.range[0] - slack..=coordinate.range[1] + slack).contains(angle)
    });
    let outside: Vec<&str> = outside.map(|(coordinate, _)| coordinate.name.as_str()).collect();
    let told = [
        (twice, "stand for two joints each; a motion would move both"),
        (outside, "are outside their range, in the skeleton's own pose"),
    ];
    sentences("angles", &told)
}

/// `bones have holes: a, b` for each kind of finding; nothing about none.
fn sentences(kind: &str, told: &[(Vec<&str>, &str)]) -> Vec<String> {
    let told = told.iter().filter(|(names, _)| !names.is_empty());
    told.map(|(names, what)| format!("{kind} {what}: {}", few(names, MOST_NAMED))).collect()
}

#[cfg(test)]
mod tests {
    use crate::job::check_file;
    use std::path::PathBuf;

    const GOOD: &str = r#"{"format": "anatomical-skeleton", "version": 1, "units": "mm, degrees",
        "bones": [{"name": "a", "mesh": "a.obj", "label": 1}, {"name": "b", "mesh": "b.obj", "label": 2},
                  {"name": "c", "mesh": "c.obj"}],
        "joints": [{"name": "ab", "parent": "a", "child": "b", "limits": {},
                    "coordinates": [{"name": "bend", "axis": [0, 0, 1], "range_deg": [-5, 5]}]},
                   {"name": "bc", "parent": "b", "child": "c", "limits": {"shift": 1},
                    "coordinates": [{"name": "turn", "axis": [1, 0, 0], "range_deg": [0, 5]}]}]}"#;
    const OUTWARDS: &str = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    const INWARDS: &str = "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n";

    struct Files(tempfile::TempDir);

    impl Files {
        /// The good skeleton: three tetrahedra side by side.
        fn new() -> Self {
            let files = Self(tempfile::tempdir().unwrap());
            for (name, x) in [("a", 0), ("b", 12), ("c", 24)] {
                files.write_bone(name, x, OUTWARDS);
            }
            files.write("s.skeleton.json", GOOD);
            files
        }

        fn write(&self, name: &str, text: &str) -> PathBuf {
            let path = self.0.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        }

        fn write_bone(&self, name: &str, x: i32, triangles: &str) {
            let far = x + 10;
            let points = format!("v {x} 0 0\nv {far} 0 0\nv {x} 10 0\nv {x} 0 10\n");
            self.write(&format!("{name}.obj"), &(points + triangles));
        }

        fn findings(&self) -> Vec<String> {
            check_file(&self.0.path().join("s.skeleton.json")).unwrap().findings
        }
    }

    #[test]
    fn a_skeleton_is_told_in_a_sentence() {
        let files = Files::new();
        let told = check_file(&files.write("s.skeleton.json", GOOD)).unwrap();
        assert_eq!(told.findings, Vec::<String>::new());
        let begins =
            "a skeleton of 3 bones with 12 vertices, 2 joints, 2 named angles, 34.0000 x 10.0000";
        assert!(told.content.starts_with(begins), "{}", told.content);
        assert!(told.content.ends_with("in size (mm)"), "{}", told.content);
        let newer = r#"{"format": "anatomical-skeleton", "version": 9}"#;
        assert!(check_file(&files.write("newer.json", newer)).is_err());
        let walk = "x\ninDegrees=yes\nendheader\ntime bend\n0.5 10\n1.5 -20\n";
        let told = check_file(&files.write("s.mot", walk)).unwrap().content;
        assert_eq!(told, "a motion of 1 columns in 2 frames, 0.5 to 1.5 s");
    }

    #[test]
    fn what_is_wrong_in_the_file_is_named() {
        let files = Files::new();
        let turned = r#""limits": {"shift": 1, "rot_deg": {"neg": [3, 3, 3], "pos": [3, 3, 3]}},
            "parent_frame": {"t": [200, 0, 0], "q": [1, 0, 0, 0]},
            "child_frame": {"t": [202, 0, 0], "q": [0.8, 0.6, 0, 0]}"#;
        let shift = r#""limits": {"shift": 1}"#;
        let wrong = [
            (r#""label": 2"#, r#""label": 1"#, "bones share the label 1; give each its own: a, b"),
            (
                r#""turn""#,
                r#""bend""#,
                "angles stand for two joints each; a motion would move both: bend",
            ),
            (shift, turned, "joints lie further from both their bones than these are long"),
            (shift, turned, "joints have frames further apart"),
            (shift, turned, "joints are turned beyond"),
            (shift, turned, "angles are outside their range, in the skeleton's own pose: turn"),
            (r#""mm, degrees""#, r#""m""#, "the skeleton would be 36."),
            (
                r#""version": 1"#,
                r#""version": 1, "statistics": "s.h5.json""#,
                "the file s.h5.json that",
            ),
            (
                r#""version": 1"#,
                r#""version": 1, "soft": [{"name": "m", "mesh": "m.obj"}]"#,
                "cannot read",
            ),
        ];
        for (from, to, expected) in wrong {
            files.write("s.skeleton.json", &GOOD.replace(from, to));
            let told = files.findings();
            assert!(told.iter().any(|t| t.starts_with(expected)), "{expected}: {told:?}");
        }
    }

    #[test]
    fn what_is_wrong_with_the_bones_is_named() {
        let files = Files::new();
        files.write_bone("a", 0, INWARDS);
        files.write_bone("c", 24, &OUTWARDS[..24]);
        let end = GOOD.find("]},\n").unwrap();
        files.write("s.skeleton.json", &format!("{}]}}]}}", &GOOD[..end]));
        let told = files.findings();
        let expected = [
            "bones have holes: c",
            "bones are inside out; flip their normals: a",
            "bones have no joint; nothing says where they are if they are not seen: c",
        ];
        assert_eq!(told, expected);
    }
}
