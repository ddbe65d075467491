//! What `register` says of targets that nobody would call good: refused, turned, left out, or named.
#![allow(clippy::unwrap_used)]

mod hands;

use std::path::Path;
use std::process::Command;

use hands::vertex_error;
use moulage::io::{read_surface, write_surface};
use moulage::math::Vec3;
use moulage::register::{Options, Registered, Target, Verdict, register};
use moulage::{Result, Run, TriMesh};

fn hand() -> TriMesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand/target_surface.ply");
    read_surface(&path).unwrap().mesh().unwrap()
}

fn inside_out(mesh: &TriMesh) -> TriMesh {
    let triangles = mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    TriMesh { points: mesh.points.clone(), triangles }
}

fn found(target: TriMesh, options: &Options) -> Result<Registered> {
    register(&hands::template(), &Target::whole(target)?, options, &Run::new())
}

#[test]
fn a_mirrored_hand_is_refused_in_words() {
    let mirrored = hand().points.iter().map(|p| Vec3::new(-p.x, p.y, p.z)).collect();
    let mirrored = inside_out(&TriMesh { points: mirrored, ..hand() });
    let error = found(mirrored.clone(), &Options::default()).unwrap_err().to_string();
    assert!(error.contains("mirror image"), "{error}");
    let meant = found(mirrored, &Options { as_is: true, ..Options::default() }).unwrap();
    assert_eq!(meant.judgement.verdict, Verdict::Failed, "{:?}", meant.judgement);
}

#[test]
fn a_hand_inside_out_with_a_ball_far_away_is_found_and_both_are_said() {
    let truth = hand();
    let mut target = truth.clone();
    let ball = ball(truth.points.iter().sum::<Vec3>() / truth.points.len() as f64);
    target.append(&ball);
    let found = found(inside_out(&target), &Options::default()).unwrap();
    let error = vertex_error(&found.skeleton.points, &truth.points);
    assert!(error < 0.2, "{error}");
    assert!(found.bones.iter().all(|b| b.verdict == Verdict::Good));
    assert_eq!(found.judgement.verdict, Verdict::Doubtful, "a third of the target was left out");
    let notes = found.notes.join(" ");
    assert!(notes.contains("inwards") && notes.contains("left out"), "{notes}");
}

/// A ball of 40 mm, 150 mm beside a place.
fn ball(beside: Vec3) -> TriMesh {
    let centre = beside + 150.0 * Vec3::x();
    let sides = [Vec3::x(), Vec3::y(), Vec3::z(), -Vec3::x(), -Vec3::y(), -Vec3::z()];
    let points = sides.iter().map(|n| centre + 40.0 * n).collect();
    let triangles = vec![
        [0, 1, 2],
        [1, 3, 2],
        [3, 4, 2],
        [4, 0, 2],
        [1, 0, 5],
        [3, 1, 5],
        [4, 3, 5],
        [0, 4, 5],
    ];
    TriMesh { points, triangles }
}

#[test]
fn a_finger_that_the_scan_does_not_show_is_named_and_no_other() {
    let template = hands::template();
    let truth = hand();
    let missing = |name: &str| ["5proxph", "5midph", "5distph"].contains(&name);
    let seen = template.bones.iter().enumerate().filter(|(_, bone)| !missing(&bone.name));
    let surfaces =
        seen.map(|(b, bone)| (bone.name.clone(), template.bone_surface(b, &truth.points)));
    let target = Target::per_bone(&template, surfaces.collect()).unwrap();
    let found = register(&template, &target, &Options::default(), &Run::new()).unwrap();
    for bone in &found.bones {
        assert_eq!(bone.verdict > Verdict::Good, missing(&bone.name), "{bone:?}");
    }
    assert_eq!(found.judgement.verdict, Verdict::Doubtful);
    assert!(found.judgement.reasons[0].contains("5proxph"), "{:?}", found.judgement);
}

#[test]
fn the_program_refuses_metres_and_ends_with_2_where_the_result_failed() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mut metres = hand();
    for point in &mut metres.points {
        *point /= 1000.0;
    }
    write_surface(&at("metres.ply"), &metres).unwrap();
    let skeleton = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand/skeleton.json");
    let run = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_moulage"));
        command.arg("register").arg(&skeleton).arg("--target").arg(at("metres.ply"));
        command.arg("-o").arg(at("out")).arg("--report").arg(at("report")).args(more);
        let output = command.output().unwrap();
        let text = [output.stdout, output.stderr].map(|t| String::from_utf8(t).unwrap()).concat();
        (output.status.code(), text)
    };
    let (code, text) = run(&[]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("as if it were in metres") && !at("out").exists(), "{text}");
    let (code, text) = run(&["--as-is", "--iterations", "1"]);
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("verdict: failed"), "{text}");
    let result = std::fs::read_to_string(at("out/result.skeleton.json")).unwrap();
    let result: serde_json::Value = serde_json::from_str(&result).unwrap();
    assert_eq!(result["result"]["verdict"], "failed");
    let page = std::fs::read_to_string(at("report/report.html")).unwrap();
    assert!(page.contains("<h2 class=\"failed\">verdict: failed"), "no verdict on top");
}
