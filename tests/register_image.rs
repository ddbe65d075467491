//! Bones registered to images and followed through images, without any surface of the person.
//!
//! The images are made here, with voxels longer one way.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod hands;
mod synthetic;

use std::path::Path;

use moulage::Run;
use moulage::io::write_surface;
use moulage::job::{RegisterJob, TrackJob, run_register, run_track};
use moulage::locate::ClosestPoints;
use moulage::math::Vec3;
use moulage::mesh::bounding_box;
use moulage::register::rotation::turned_about;
use moulage::register::{Appearance, Options, Registration, Skeleton, Target, Verdict, register};
use moulage::volume::Volume;
use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use synthetic::Looks;

/// The first bones of a finger with the joints between them.
fn finger(count: usize) -> Skeleton {
    hands::only(&hands::template(), &["2proxph", "2midph", "2distph"][..count])
}

/// The finger bent at its first joint, at a second one two thirds as far, then moved by `away`.
fn bent(finger: &Skeleton, degrees: f64, away: &Isometry3<f64>) -> Skeleton {
    let mut other = finger.clone();
    let mut motions = vec![Isometry3::identity(); finger.bones.len()];
    for (k, (joint, share)) in finger.joints.iter().zip([1.0, 2.0 / 3.0]).enumerate() {
        let axis = joint.parent_frame.rotation * joint.coordinates[0].axis;
        let turn = UnitQuaternion::from_scaled_axis(axis * (share * degrees).to_radians());
        let centre = joint.parent_frame.translation.vector;
        motions[k + 1] = motions[k] * turned_about(&Isometry3::identity(), &centre, turn);
    }
    for motion in &mut motions {
        *motion = away * *motion;
    }
    other.move_bones(&motions);
    other
}

/// Each bone stretched along the axes about its middle; the joints follow by name only.
fn reshaped(finger: &Skeleton, sizes: &[[f64; 3]]) -> Skeleton {
    let mut other = finger.clone();
    for (bone, size) in finger.bones.iter().zip(sizes) {
        let middle =
            bounding_box(&finger.points[bone.vertices.clone()]).map(|(a, b)| (a + b) / 2.0);
        let middle = middle.unwrap();
        for p in &mut other.points[bone.vertices.clone()] {
            *p = middle + (*p - middle).component_mul(&Vec3::from(*size));
        }
    }
    other
}

/// 3 degrees about the finger's middle and 2 mm.
fn small_motion(finger: &Skeleton) -> Isometry3<f64> {
    let (low, high) = bounding_box(&finger.points).unwrap();
    let tilt = UnitQuaternion::from_scaled_axis(Vec3::new(0.03, -0.035, 0.02));
    let turn = turned_about(&Isometry3::identity(), &((low + high) / 2.0), tilt);
    Translation3::new(1.2, -1.3, 0.9) * turn
}

/// A magnetic resonance image of the finger: dark cortex, bright marrow.
fn image(finger: &Skeleton, spacing: [f64; 3], noise: f64, seed: u64, gain: f64) -> Volume {
    let looks = Looks {
        cortex: 90.0,
        cortex_depth: 1.1,
        marrow: 780.0,
        tissue: 420.0,
        texture: 1.0,
        air: 10.0,
        coil: 0.1,
        noise: 780.0 * noise,
        edge: 0.6,
    };
    synthetic::image(finger, spacing, &looks, seed, gain)
}

/// Mean distance of the found surface from the true one, mm.
fn surface_error(found: &Skeleton, truth: &Skeleton) -> f64 {
    let closest = ClosestPoints::new(&truth.points, &truth.triangles);
    let sum: f64 = found.points.iter().map(|p| closest.closest(p).unwrap().distance).sum();
    sum / found.points.len() as f64
}

fn vertex_error(found: &Skeleton, truth: &Skeleton) -> f64 {
    let squares = found.points.iter().zip(&truth.points).map(|(p, q)| (p - q).norm_squared());
    (squares.sum::<f64>() / truth.points.len() as f64).sqrt()
}

/// Voxels, mm.
const FINE: [f64; 3] = [0.4, 1.0, 0.4];

/// A template and the same bones of another size, bent and away.
fn two_bones() -> (Skeleton, Skeleton) {
    let template = finger(2);
    let sizes = [[1.04, 1.06, 1.02], [1.05, 1.03, 1.06]];
    let truth = bent(&reshaped(&template, &sizes), 20.0, &small_motion(&template));
    (template, truth)
}

#[test]
fn a_finger_is_found_in_an_image_whatever_its_gain() {
    let (template, truth) = two_bones();
    let reference = image(&template, FINE, 0.04, 1, 1.0);
    let mut errors = Vec::new();
    for gain in [1.0, 0.8] {
        let person = image(&truth, FINE, 0.04, 77, gain);
        let looks = Appearance::profiles(&template, &reference, None).unwrap();
        let target = Target::image(&template, person, looks).unwrap();
        let found = register(&template, &target, &Options::default(), &Run::new()).unwrap();
        let [surface, vertex] =
            [surface_error, vertex_error].map(|error| error(&found.skeleton, &truth));
        println!(
            "profiles, gain {gain}: start {:.2} / {:.2}, surface {surface:.3}, vertices {vertex:.3} mm, {} iterations",
            surface_error(&template, &truth),
            vertex_error(&template, &truth),
            found.iterations()
        );
        errors.push(surface);
    }
    assert!(errors.iter().all(|e| *e < 0.1), "{errors:?}");
    assert!((errors[0] - errors[1]).abs() < 0.02, "{errors:?}");
}

#[test]
fn what_begins_further_off_than_is_searched_is_found_by_beginning_again() {
    let template = finger(3);
    let reference = image(&template, FINE, 0.04, 1, 1.0);
    for away in [Translation3::new(12.0, 0.0, 0.0), Translation3::new(0.0, 10.0, 0.0)] {
        let truth = bent(&template, 10.0, &Isometry3::from(away));
        let looks = Appearance::profiles(&template, &reference, None).unwrap();
        let target = Target::image(&template, image(&truth, FINE, 0.04, 77, 1.0), looks).unwrap();
        let found = register(&template, &target, &Options::default(), &Run::new()).unwrap();
        let error = vertex_error(&found.skeleton, &truth);
        println!("begun {:.1} mm off: {error:.3} mm", vertex_error(&template, &truth));
        assert!(error < 0.2, "{error}");
        assert_eq!(found.judgement.verdict, Verdict::Good, "{:?}", found.judgement);
    }
}

#[test]
fn a_bone_around_which_the_image_is_another_one_is_not_called_good() {
    let template = finger(2);
    let looks =
        Appearance::profiles(&template, &image(&template, FINE, 0.04, 1, 1.0), None).unwrap();
    let noisy = image(&template, FINE, 1.0, 77, 1.0);
    let target = Target::image(&template, noisy, looks).unwrap();
    let found = register(&template, &target, &Options::default(), &Run::new()).unwrap();
    for bone in &found.bones {
        assert_eq!(bone.verdict, Verdict::Doubtful, "{bone:?}");
        assert!(
            bone.reasons[0].contains("the image is like the reference image by 0."),
            "{bone:?}"
        );
    }
}

#[test]
fn the_published_moments_find_the_bones_too() {
    let (template, truth) = two_bones();
    let reference = image(&template, FINE, 0.04, 1, 1.0);
    for gain in [1.0, 0.8] {
        let person = image(&truth, FINE, 0.04, 77, gain);
        let looks = Appearance::moments(&template, &reference, 0.8).unwrap();
        let target = Target::image(&template, person, looks).unwrap();
        let found = register(&template, &target, &Options::default(), &Run::new()).unwrap();
        let surface = surface_error(&found.skeleton, &truth);
        let vertex = vertex_error(&found.skeleton, &truth);
        println!("moments, gain {gain}: {surface:.3}, {vertex:.3} mm");
        assert!(surface < 0.1, "{surface}");
    }
}

/// Root mean square vertex error of each frame, bent by 10, 20, ... degrees.
fn track(use_joints: bool, frames: u32) -> Vec<f64> {
    let model = finger(3);
    let reference = image(&model, [0.3, 1.0, 0.3], 0.04, 1, 1.0);
    let options = Options { use_joints, ..Options::tracking() };
    let tracker = Registration::new(model.clone(), options).unwrap();
    let mut pose = model.clone();
    (1..=frames)
        .map(|frame| {
            let truth = bent(&model, 10.0 * f64::from(frame), &Isometry3::identity());
            let coarse = image(&truth, [0.6, 1.5, 0.6], 0.06, 100 * u64::from(frame), 1.0);
            let looks = Appearance::profiles(&model, &reference, None).unwrap();
            let target = Target::image(&model, coarse, looks).unwrap();
            let found = tracker.track(&pose, &target, &Run::new()).unwrap();
            let start = vertex_error(&pose, &truth);
            pose = found.skeleton.clone();
            let end = vertex_error(&pose, &truth);
            println!(
                "frame {frame}, joints {use_joints}: {start:.2} -> {end:.3} mm, {} iterations",
                found.iterations()
            );
            end
        })
        .collect()
}

#[test]
fn a_known_finger_is_followed_through_coarse_images_as_long_as_its_joints_have_limits() {
    let (with, without) = (track(true, 3), track(false, 1));
    println!("with limits {with:.2?} mm, without {without:.2?} mm");
    assert!(with.iter().all(|e| *e < 0.25), "{with:?}");
    assert!(without.iter().all(|e| *e > 2.0), "{without:?}");
}

/// The image as a NIfTI file of single-precision values.
fn write_nifti(path: &Path, volume: &Volume) {
    let mut file = vec![0_u8; 352];
    let mut put = |at: usize, bytes: &[u8]| file[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348_i32.to_le_bytes());
    let [i, j, k] = volume.size().map(|n| n as i16);
    for (d, n) in [3, i, j, k, 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * d, &n.to_le_bytes());
    }
    put(70, &16_i16.to_le_bytes());
    put(108, &352.0_f32.to_le_bytes());
    put(254, &1_i16.to_le_bytes());
    for row in 0..3 {
        for column in 0..3 {
            let x = volume.world_from_voxel()[(row, column)] as f32;
            put(280 + 16 * row + 4 * column, &x.to_le_bytes());
        }
        put(292 + 16 * row, &(volume.origin()[row] as f32).to_le_bytes());
    }
    put(344, b"n+1\0");
    file.extend(volume.values().iter().flat_map(|v| v.to_le_bytes()));
    std::fs::write(path, file).unwrap();
}

#[test]
fn from_files_a_result_carries_its_profiles_and_can_be_followed() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let model = finger(2);
    let reference = image(&model, [0.4, 1.0, 0.4], 0.03, 1, 1.0);
    write_nifti(&at("reference.nii"), &reference);
    let truth = bent(&model, 10.0, &Isometry3::identity());
    write_nifti(&at("frame.nii"), &image(&truth, [0.6, 1.5, 0.6], 0.05, 9, 1.0));
    // The template's file, as a person would write it.
    let mut bones = Vec::new();
    for b in 0..2 {
        let name = &model.bones[b].name;
        write_surface(&at(&format!("{name}.obj")), &model.bone_surface(b, &model.points)).unwrap();
        bones.push(serde_json::json!({"name": name, "mesh": format!("{name}.obj")}));
    }
    let joint = &model.joints[0];
    let (t, q) = (joint.parent_frame.translation.vector, joint.parent_frame.rotation);
    let degrees = |v: &Vec3| v.map(f64::to_degrees).as_slice().to_vec();
    let document = serde_json::json!({
        "format": "anatomical-skeleton", "version": 1, "units": "mm", "frame": "RAS", "bones": bones,
        "joints": [{"name": "pip", "parent": model.bones[0].name, "child": model.bones[1].name,
            "parent_frame": {"t": t.as_slice(), "q": [q.w, q.i, q.j, q.k]},
            "limits": {"rot_deg": {"neg": degrees(&joint.limits.negative),
                "pos": degrees(&joint.limits.positive)}, "shift": 1.0},
            "coordinates": [{"name": "bend", "axis": joint.coordinates[0].axis.as_slice(),
                "range_deg": [-20.0, 120.0]}]}],
        "reference_image": {"volume": "reference.nii"}
    });
    std::fs::write(at("finger.skeleton.json"), document.to_string()).unwrap();

    let job = RegisterJob {
        skeleton: at("finger.skeleton.json"),
        volume: Some(at("reference.nii")),
        out: Some(at("out")),
        ..RegisterJob::default()
    };
    let found = run_register(&job, &Run::new()).unwrap().registered;
    let same = vertex_error(&found.skeleton, &model);
    assert!(same < 0.05, "the template on its own image moved by {same} mm");

    let job = TrackJob {
        skeleton: at("out/result.skeleton.json"),
        volume: vec![at("frame.nii")],
        out: at("frames"),
        ..TrackJob::default()
    };
    let frames = run_track(&job, &Run::new()).unwrap();
    let error = vertex_error(&frames[0].registered.skeleton, &truth);
    assert!(error < 0.25 && frames[0].seen > 0.5, "{error} mm, seen {}", frames[0].seen);
    let table = std::fs::read_to_string(at("frames/angles.csv")).unwrap();
    let bend: f64 = table.trim().rsplit(',').next().unwrap().parse().unwrap();
    assert!(table.starts_with("frame,volume,verdict,seen,bend_deg\n1,frame.nii,good,"), "{table}");
    assert!((bend - 10.0).abs() < 0.5, "{table}");
    assert!(at("frames/001/result.skeleton.json").is_file());

    let job = RegisterJob { reference: Some(at("no.nii")), ..job_without_reference(&at("out")) };
    assert!(run_register(&job, &Run::new()).is_err());
}

fn job_without_reference(folder: &Path) -> RegisterJob {
    RegisterJob {
        skeleton: folder.join("result.skeleton.json"),
        volume: Some(folder.join("../frame.nii")),
        out: Some(folder.join("again")),
        ..RegisterJob::default()
    }
}
