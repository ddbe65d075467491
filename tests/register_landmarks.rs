//! Landmarks of a skeleton in files: named as their bones or lying on them, and what is said of them.
#![allow(clippy::unwrap_used)]

mod hands;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use moulage::Run;
use moulage::io::read_surface;
use moulage::job::{RegisterJob, read_bone_landmarks, read_skeleton, run_register};
use moulage::math::Vec3;

fn hand() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand")
}

/// Name, place on the template and on the person of the first vertex of some bones.
fn known(names: &[&str]) -> Vec<(String, Vec3, Vec3)> {
    let skeleton = read_skeleton(&hand().join("skeleton.json")).unwrap().skeleton;
    let person = read_surface(&hand().join("target_surface.ply")).unwrap().mesh().unwrap().points;
    let known = |name: &&str| {
        let first = skeleton.bones[skeleton.bone_index(name).unwrap()].vertices.start;
        ((*name).to_owned(), skeleton.points[first], person[first])
    };
    names.iter().map(known).collect()
}

fn file(folder: &Path, name: &str, text: &str) -> PathBuf {
    std::fs::write(folder.join(name), text).unwrap();
    folder.join(name)
}

const PAIRS: &str = "label,template_x,template_y,template_z,target_x,target_y,target_z\n";

#[test]
fn landmarks_lie_on_the_bones_that_their_names_or_places_say() {
    let skeleton = read_skeleton(&hand().join("skeleton.json")).unwrap().skeleton;
    let folder = tempfile::tempdir().unwrap();
    let (mut pairs, mut template, mut person) =
        (PAIRS.to_owned(), "label,x,y,z\n".to_owned(), "label,x,y,z\n".to_owned());
    for (k, (name, p, q)) in known(&["3mc", "lunate", "5distph"]).iter().enumerate() {
        let label =
            [format!("{name}: head"), "a place without a bone".into(), name.clone()][k].clone();
        writeln!(pairs, "{label},{},{},{},{},{},{}", p.x, p.y, p.z, q.x, q.y, q.z).unwrap();
        writeln!(template, "{label},{},{},{}", p.x, p.y, p.z).unwrap();
        writeln!(person, "{label},{},{},{}", q.x, q.y, q.z).unwrap();
    }
    let one = [file(folder.path(), "pairs.csv", &pairs)];
    let two = [
        file(folder.path(), "template.csv", &template),
        file(folder.path(), "person.csv", &(person + "unknown,0,0,0\n")),
    ];
    for (files, warned) in [(&one[..], false), (&two[..], true)] {
        let found = read_bone_landmarks(files, &skeleton).unwrap();
        let bones: Vec<&str> =
            found.landmarks.iter().map(|l| skeleton.bones[l.bone].name.as_str()).collect();
        assert_eq!(bones, ["3mc", "lunate", "5distph"]);
        assert_eq!(found.warning.is_some_and(|w| w.contains("unknown")), warned);
    }
    let wrong = file(folder.path(), "wrong.csv", &format!("{PAIRS}3mc,900,0,0,1,2,3\n"));
    let error =
        read_bone_landmarks(std::slice::from_ref(&wrong), &skeleton).unwrap_err().to_string();
    assert!(error.contains("wrong.csv") && error.contains("line 2"), "{error}");
    assert!(error.contains("landmark 3mc lies") && error.contains("its bone, 3mc"), "{error}");
    let number = "label,vertex,target_x,target_y,target_z\n{},5,1,2,3\n";
    let on_bone = file(folder.path(), "vertex.csv", &number.replace("{}", "lunate"));
    let found = read_bone_landmarks(&[on_bone], &skeleton).unwrap();
    let lunate = &skeleton.bones[skeleton.bone_index("lunate").unwrap()];
    assert_eq!(found.landmarks[0].place, skeleton.points[lunate.vertices.start + 5]);
    let nowhere = file(folder.path(), "nowhere.csv", &number.replace("{}", "tip"));
    let error = read_bone_landmarks(&[nowhere], &skeleton).unwrap_err().to_string();
    assert!(error.contains("name it as its bone, such as"), "{error}");
}

#[test]
fn a_hand_follows_its_landmarks_and_the_report_says_how_far_they_end_off() {
    let folder = tempfile::tempdir().unwrap();
    let mut pairs = PAIRS.to_owned();
    for (name, p, q) in known(&["3mc", "thumbdist", "2distph", "5distph", "lunate"]) {
        writeln!(pairs, "{name},{},{},{},{},{},{}", p.x, p.y, p.z, q.x, q.y, q.z).unwrap();
    }
    let job = RegisterJob {
        skeleton: hand().join("skeleton.json"),
        target: Some(hand().join("target_surface.ply")),
        landmarks: Some(vec![file(folder.path(), "pairs.csv", &pairs)]),
        report: Some(folder.path().join("report")),
        ..RegisterJob::default()
    };
    let result = run_register(&job, &Run::new()).unwrap();
    let landmarks = &result.report.landmarks;
    assert_eq!(landmarks.len(), 5);
    assert!(landmarks.iter().all(|l| l.name == l.bone && l.distance < 0.5), "{landmarks:?}");
    let truth = read_surface(&hand().join("target_surface.ply")).unwrap().mesh().unwrap().points;
    let found = &result.registered.skeleton.points;
    let rms = hands::vertex_error(found, &truth);
    assert!(rms < 0.2, "{rms}");
    let page = std::fs::read_to_string(folder.path().join("report/report.html")).unwrap();
    assert!(page.contains("<h2>Landmarks</h2>") && page.contains("<td>thumbdist"));
}
