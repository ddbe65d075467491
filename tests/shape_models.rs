//! Shape models on the command line: learnt from results, made into shapes, used to register.
#![allow(clippy::unwrap_used)]

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use moulage::io::read_surface;
use moulage::job::read_skeleton;
use moulage::math::Vec3;
use moulage::register::rotation::turned_about;
use moulage::register::{Joint, Skeleton};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

/// Length and width of the persons that a model is learnt from.
const PERSONS: [(f64, f64); 6] =
    [(0.92, 1.0), (1.08, 1.04), (1.0, 0.93), (0.98, 1.08), (1.05, 0.96), (0.97, 0.99)];
/// Two bones of the example's hand.
const BONES: [&str; 2] = ["2proxph", "2midph"];

fn moulage(arguments: &[&str], files: &[&Path]) -> Output {
    let program = env!("CARGO_BIN_EXE_moulage");
    Command::new(program).args(arguments).args(files).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

fn finger() -> (Skeleton, Joint) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand/skeleton.json");
    let hand = read_skeleton(&path).unwrap().skeleton;
    let bones = BONES.map(|name| hand.bone_index(name).unwrap());
    let mut joint = hand.joints.iter().find(|j| [j.parent, j.child] == bones).unwrap().clone();
    [joint.parent, joint.child] = [0, 1];
    let surface = |b: usize| (hand.bones[b].name.clone(), hand.bone_surface(b, &hand.points));
    (Skeleton::new(bones.map(surface).to_vec(), vec![joint.clone()]).unwrap(), joint)
}

/// The finger of a person: longer along z, wider across, about the joint.
fn person((length, width): (f64, f64)) -> Skeleton {
    let (mut finger, joint) = finger();
    let centre = joint.parent_frame.translation.vector;
    for p in &mut finger.points {
        *p = centre + (*p - centre).component_mul(&Vec3::new(width, width, length));
    }
    finger
}

fn bent(mut finger: Skeleton) -> Skeleton {
    let frame = finger.joints[0].parent_frame;
    let axis = frame.rotation * finger.joints[0].coordinates[0].axis;
    let turn = UnitQuaternion::from_scaled_axis(axis * 40_f64.to_radians());
    let bend = turned_about(&Isometry3::identity(), &frame.translation.vector, turn);
    let tilt = UnitQuaternion::from_scaled_axis(Vec3::new(0.1, 0.05, -0.1));
    let tilt = turned_about(&Isometry3::identity(), &frame.translation.vector, tilt);
    let away = Translation3::new(2.0, -1.5, 1.0) * tilt;
    finger.move_bones(&[away, away * bend]);
    finger
}

fn write_obj(path: &Path, points: &[Vec3], triangles: &[[u32; 3]]) {
    let mut text = String::new();
    for p in points {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
    }
    for [a, b, c] in triangles {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    std::fs::write(path, text).unwrap();
}

/// Writes a skeleton file with its bones and returns its path.
fn write_skeleton(folder: &Path, finger: &Skeleton) -> PathBuf {
    std::fs::create_dir_all(folder).unwrap();
    for (b, bone) in finger.bones.iter().enumerate() {
        let surface = finger.bone_surface(b, &finger.points);
        let path = folder.join(format!("{}.obj", bone.name));
        write_obj(&path, &surface.points, &surface.triangles);
    }
    let bones = BONES.map(|b| serde_json::json!({"name": b, "mesh": format!("{b}.obj")}));
    let frame = finger.joints[0].parent_frame;
    let q = frame.rotation;
    let document = serde_json::json!({
        "format": "anatomical-skeleton", "version": 1, "units": "mm", "frame": "RAS", "bones": bones,
        "joints": [{
            "name": "pip2", "parent": BONES[0], "child": BONES[1],
            "parent_frame": {"t": frame.translation.vector.as_slice(), "q": [q.w, q.i, q.j, q.k]},
            "limits": {"rot_deg": {"neg": [100, 100, 100], "pos": [100, 100, 100]}, "shift": 1.0},
        }],
    });
    let path = folder.join("result.skeleton.json");
    std::fs::write(&path, document.to_string()).unwrap();
    path
}

fn extent(folder: &Path, bone: &str) -> Vec3 {
    let mesh = read_surface(&folder.join(format!("bones/{bone}.obj"))).unwrap().mesh().unwrap();
    let (low, high) = moulage::mesh::bounding_box(&mesh.points).unwrap();
    high - low
}

#[allow(clippy::too_many_lines)] // Each step stands on the one before.
#[test]
fn a_model_is_learnt_from_results_makes_shapes_and_registers_a_new_person() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let template = write_skeleton(&at("template"), &person((1.0, 1.0)));
    let results: Vec<PathBuf> = PERSONS
        .iter()
        .enumerate()
        .map(|(k, sizes)| write_skeleton(&at(&format!("person{k}")), &bent(person(*sizes))))
        .collect();
    let (model, report) = (at("finger.h5.json"), at("report"));
    let mut files = vec![template.as_path()];
    files.extend(results.iter().map(PathBuf::as_path));
    files.extend([Path::new("-o"), &model, Path::new("--report"), &report]);
    let output = moulage(&["model", "fit"], &files);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));

    // Two causes, however the bones lie.
    let json = std::fs::read_to_string(report.join("report.json")).unwrap();
    let figures: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert!(figures["explained"][1].as_f64().unwrap() > 0.999, "{json}");
    let left_out = figures["left_out"].as_array().unwrap();
    assert_eq!(left_out.len(), PERSONS.len());
    assert!(left_out.iter().all(|d| d.as_f64().unwrap() < 0.05), "{json}");
    let page = std::fs::read_to_string(report.join("report.html")).unwrap();
    assert!(page.contains("Mode 2") && page.contains("data:image/png"));

    // The first mode is mostly length, the second mostly width; each along one line.
    let shape = |name: &str, coefficients: &[&str]| {
        let files = [template.as_path(), &model, Path::new("-o"), &at(name)];
        let mut arguments = vec!["model", "shape"];
        if !coefficients.is_empty() {
            arguments.push("--coefficients");
            arguments.extend(coefficients);
        }
        // Coefficients take all numbers that follow, so files come first.
        let output = Command::new(env!("CARGO_BIN_EXE_moulage"))
            .args(&arguments[..2])
            .args(files)
            .args(&arguments[2..])
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        let skeleton = read_skeleton(&at(name).join("shape.skeleton.json")).unwrap().skeleton;
        let joint = &skeleton.joints[0];
        let gap = joint.parent_frame.translation.vector - joint.child_frame.translation.vector;
        assert!(gap.norm() < 1e-6, "{gap}");
        BONES.map(|b| extent(&at(name), b))
    };
    let (mean, longer, shorter) = (shape("mean", &[]), shape("up", &["2"]), shape("down", &["-2"]));
    for b in 0..BONES.len() {
        let [up, down] = [longer[b] - mean[b], mean[b] - shorter[b]].map(|d| d.z / mean[b].z);
        assert!(up.abs() > 0.05 && (up - down).abs() < 0.01, "{up} {down}");
    }
    let output = Command::new(env!("CARGO_BIN_EXE_moulage"))
        .args(["model", "shape"])
        .args([template.as_path(), &model, Path::new("-o"), &at("none")])
        .args(["--coefficients", "1", "1", "1", "1", "1", "1", "1"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("7 coefficients are given, but the model has"));

    // A person the model has not seen.
    let truth = bent(person((1.04, 0.97)));
    write_obj(&at("target.obj"), &truth.points, &truth.triangles);
    let found = at("found");
    let files = [
        template.as_path(),
        Path::new("--shape-model"),
        &model,
        Path::new("--target"),
        &at("target.obj"),
        Path::new("-o"),
        &found,
    ];
    let output = moulage(&["register", "--no-align"], &files);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let result = read_skeleton(&found.join("result.skeleton.json")).unwrap();
    let points = result.skeleton.points.iter().zip(&truth.points);
    let squares: f64 = points.map(|(p, q)| (p - q).norm_squared()).sum();
    let rms = (squares / truth.points.len() as f64).sqrt();
    assert!(rms < 0.1, "{rms}");
    let figures = result.document.result.unwrap();
    let coefficients = figures["shape_coefficients"].as_array().unwrap();
    assert!(!coefficients.is_empty());
    assert!(coefficients.iter().all(|c| c.as_f64().unwrap().abs() <= 3.0), "{coefficients:?}");
}

#[test]
fn a_result_of_another_template_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let template = write_skeleton(&folder.path().join("a"), &person((1.0, 1.0)));
    let hand = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand/skeleton.json");
    let model = folder.path().join("m.h5.json");
    let output =
        moulage(&["model", "fit"], &[&template, &template, &hand, Path::new("-o"), &model]);
    assert_eq!(output.status.code(), Some(1));
    let said = said(&output);
    assert!(
        said.contains("skeleton.json") && said.contains("not a result of this template"),
        "{said}"
    );
    assert!(!model.exists());
}
