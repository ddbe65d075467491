//! A whole hand from files to files: 27 bones find those of another hand, joints inside their limits.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use moulage::Run;
use moulage::io::read_surface;
use moulage::job::{RegisterJob, read_skeleton, run_register};
use moulage::math::Vec3;
use moulage::register::fast_sums::FastSums;
use moulage::register::{Skeleton, Verdict};
use nalgebra::{Quaternion, UnitQuaternion};

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
        ply_out: Some(out.path().join("person.ply")),
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
    assert!(result.registered.bones.iter().all(|b| b.seen > 0.9 && b.verdict == Verdict::Good));

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
    seen_by_viewers(&out.path().join("skeleton.glb"), found);
    let page = std::fs::read_to_string(out.path().join("report/report.html")).unwrap();
    assert!(page.contains("thumbprox"));
    assert_eq!(result.registered.seen.len(), truth.len());
    let ply = std::fs::read(out.path().join("person.ply")).unwrap();
    assert_eq!(ply, std::fs::read(out.path().join("report/result.ply")).unwrap());
    let header = String::from_utf8_lossy(&ply[..400]);
    for name in ["bone", "verdict", "seen", "distance"] {
        assert!(header.contains(&format!("property float {name}\n")), "{header}");
    }
}

#[test]
fn outputs_that_would_come_to_nothing_are_refused_before_anything_is_read() {
    let refused = |job: RegisterJob| run_register(&job, &Run::new()).unwrap_err().to_string();
    assert!(refused(RegisterJob::default()).contains("no output is named"));
    let ply_out = Some("person.obj".into());
    let text = refused(RegisterJob { ply_out, ..RegisterJob::default() });
    assert_eq!(text, "--ply-out person.obj: the name must end in .ply");
    let file = tempfile::NamedTempFile::new().unwrap();
    let text = refused(RegisterJob { out: Some(file.path().into()), ..RegisterJob::default() });
    assert!(text.contains("result.skeleton.json"), "{text}");
}

/// What another reader of glTF sees: every bone's node with its name, in its place, metres and y up.
fn seen_by_viewers(path: &Path, found: &Skeleton) {
    let file = gltf::Gltf::open(path).unwrap();
    let binary = file.blob.as_ref().unwrap();
    let mut parents = vec![None; file.nodes().count()];
    for node in file.nodes() {
        for child in node.children() {
            parents[child.index()] = Some(node.index());
        }
    }
    let nodes: Vec<_> = file.nodes().collect();
    let world = |mut k: usize, p: [f32; 3]| {
        let mut p = Vec3::from(p.map(f64::from));
        loop {
            let (shift, turn, scale) = nodes[k].transform().decomposed();
            let turn = UnitQuaternion::from_quaternion(Quaternion::from(turn.map(f64::from)));
            p = turn * p.component_mul(&Vec3::from(scale.map(f64::from)))
                + Vec3::from(shift.map(f64::from));
            match parents[k] {
                Some(parent) => k = parent,
                None => return p,
            }
        }
    };
    for bone in &found.bones {
        let node = nodes.iter().find(|n| n.name() == Some(bone.name.as_str())).unwrap();
        let primitive = node.mesh().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(binary));
        let positions: Vec<_> = reader.read_positions().unwrap().collect();
        let own = &found.points[bone.vertices.clone()];
        assert_eq!(positions.len(), own.len());
        assert_eq!(reader.read_indices().unwrap().into_u32().count(), 3 * bone.triangles.len());
        for (q, p) in positions.into_iter().zip(own) {
            let there = Vec3::new(p.x, p.z, -p.y) * 1e-3;
            assert!((world(node.index(), q) - there).norm() < 1e-6, "{}", bone.name);
        }
    }
}

#[test]
fn clusters_of_a_hand_need_a_fraction_of_the_additions() {
    let hand = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand/skeleton.json");
    let hand = read_skeleton(&hand).unwrap().skeleton;
    let sums = FastSums::new(&hand.points, &hand.triangles, 8.0).unwrap();
    assert!(sums.saving() >= 0.85, "{}", sums.saving());
    let field: Vec<[f64; 1]> = hand.points.iter().map(|p| [p.x * libm::sin(p.y)]).collect();
    let fast = sums.sum(&field);
    for i in (0..hand.points.len()).step_by(97) {
        let near = hand.points.iter().map(|q| (q - hand.points[i]).norm() <= 8.0);
        let own = near.zip(&field).filter(|(near, _)| *near);
        let (sum, size) =
            own.fold((0.0, 0.0), |(sum, size), (_, f)| (sum + f[0], size + f[0].abs()));
        assert!((fast[i][0] - sum).abs() <= 1e-10 * size, "{i}");
    }
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
