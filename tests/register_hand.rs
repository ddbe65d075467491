//! A whole hand from files to files: 27 bones find those of another hand, joints inside their limits.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use moulage::Run;
use moulage::io::read_surface;
use moulage::job::{RegisterJob, read_skeleton, run_register};

/// Root mean square vertex error to reach, millimetres.
const GOAL: f64 = 0.2;

#[test]
fn a_hand_is_found_and_written_and_its_result_is_a_template_again() {
    let hand = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand");
    let out = tempfile::tempdir().unwrap();
    let job = RegisterJob {
        skeleton: hand.join("skeleton.json"),
        target: Some(hand.join("target_surface.ply")),
        out: Some(out.path().into()),
        report: Some(out.path().join("report")),
        ..RegisterJob::default()
    };
    let result = run_register(&job, &Run::new()).unwrap();

    let truth = read_surface(&hand.join("target_surface.ply")).unwrap().mesh().unwrap().points;
    let found = &result.registered.skeleton;
    let squares: f64 = found.points.iter().zip(&truth).map(|(p, q)| (p - q).norm_squared()).sum();
    let rms = (squares / truth.len() as f64).sqrt();
    assert!(rms <= GOAL, "{rms}");
    for joint in &result.registered.joints {
        assert!(joint.excess_degrees < 1e-6 && joint.excess_shift < 1e-9, "{}", joint.name);
    }
    assert!(result.registered.bones.iter().all(|b| b.seen > 0.9 && !b.suspicious));

    let again = read_skeleton(&out.path().join("result.skeleton.json")).unwrap().skeleton;
    assert_eq!(again.bones, found.bones);
    let worst =
        again.points.iter().zip(&found.points).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
    assert!(worst < 1e-4, "{worst}");
    for (a, b) in again.joints.iter().zip(&found.joints) {
        assert!(
            (a.child_frame.translation.vector - b.child_frame.translation.vector).norm() < 1e-9
        );
        assert!(a.child_frame.rotation.angle_to(&b.child_frame.rotation) < 1e-7);
        assert_eq!(
            (a.parent, a.child, a.coordinates.len()),
            (b.parent, b.child, b.coordinates.len())
        );
    }
    assert!(out.path().join("skeleton.glb").is_file());
    let page = std::fs::read_to_string(out.path().join("report/report.html")).unwrap();
    assert!(page.contains("thumbprox"));
}

#[test]
fn a_job_without_target_or_output_says_so() {
    let hand = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand");
    let mut job = RegisterJob { skeleton: hand.join("skeleton.json"), ..RegisterJob::default() };
    assert!(run_register(&job, &Run::new()).unwrap_err().to_string().contains("-o"));
    job.out = Some("unused".into());
    assert!(run_register(&job, &Run::new()).unwrap_err().to_string().contains("--target"));
    job.labels = Some(hand.clone());
    assert!(run_register(&job, &Run::new()).unwrap_err().to_string().contains("lunate"));
}
