//! Times of a registration beside Table 1 of Gilles, Reveret, Pai 2010: `cargo bench --bench register`.
#![allow(clippy::print_stdout, clippy::expect_used)]

use std::path::Path;
use std::time::Instant;

use moulage::Run;
use moulage::io::read_surface;
use moulage::job::read_skeleton;
use moulage::register::areas::vertex_areas;
use moulage::register::elastic::Elastic;
use moulage::register::fast_sums::FastSums;
use moulage::register::pose::{BoneMoments, project_pose};
use moulage::register::sampled_clusters::SampledClusters;
use moulage::register::{Options, Registration, Target};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// Repetitions of a short measurement; the fastest counts.
const REPETITIONS: usize = 20;

fn fastest(mut work: impl FnMut()) -> f64 {
    let once = |work: &mut dyn FnMut()| {
        let start = Instant::now();
        work();
        1e3 * start.elapsed().as_secs_f64()
    };
    (0..REPETITIONS).map(|_| once(&mut work)).fold(f64::INFINITY, f64::min)
}

fn main() {
    let hand = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand");
    let skeleton =
        read_skeleton(&hand.join("skeleton.json")).expect("part of the repository").skeleton;
    let surface = read_surface(&hand.join("target_surface.ply")).expect("part of the repository");
    let target = Target::whole(surface.mesh().expect("a good mesh")).expect("it has triangles");
    let areas = vertex_areas(&skeleton.points, &skeleton.triangles);
    println!(
        "{} vertices, {} bones, {} joints; milliseconds",
        skeleton.points.len(),
        skeleton.bones.len(),
        skeleton.joints.len()
    );
    println!("| step | here | paper: 7218 vertices, 40 joints, 4 cores of 2010 |\n|---|---|---|");

    let wanted: Vec<_> = skeleton.points.iter().map(|p| p * 1.02).collect();
    let sampled = Elastic::Sampled(SampledClusters::new(&skeleton.points, 8.0, 0.5, None));
    let ms = fastest(|| drop(sampled.apply(&skeleton.points, &wanted, &areas)));
    println!("| as rigid as possible, sampled clusters, radius 8 | {ms:.2} | 20 |");
    let sums = FastSums::new(&skeleton.points, &skeleton.triangles, 8.0).expect("they fit");
    let saving = 100.0 * sums.saving();
    let exact = Elastic::Exact(sums);
    let ms = fastest(|| drop(exact.apply(&skeleton.points, &wanted, &areas)));
    println!("| the same, exact clusters ({saving:.1} % of the additions saved) | {ms:.2} | 20 |");

    let moments: Vec<BoneMoments> = skeleton
        .bones
        .iter()
        .map(|b| BoneMoments::new(&skeleton.points[b.vertices.clone()], &areas[b.vertices.clone()]))
        .collect();
    let turned: Vec<Isometry3<f64>> = (0..skeleton.bones.len())
        .map(|k| {
            let turn = Vector3::new(0.1, -0.05, 0.08) * libm::sin(k as f64);
            Isometry3::from_parts(
                Vector3::new(1.0, 0.5, -1.0).into(),
                UnitQuaternion::from_scaled_axis(turn),
            )
        })
        .collect();
    let ms = fastest(|| drop(project_pose(&skeleton, &moments, &turned, 10)));
    println!("| skeleton pose, 10 sweeps | {ms:.2} | 7 |");

    let registration = Registration::new(skeleton, Options::default()).expect("good options");
    let start = Instant::now();
    let found = registration.register(&target, &Run::new()).expect("a good target");
    let whole = 1e3 * start.elapsed().as_secs_f64();
    for level in &found.levels {
        let ms = 1e3 * level.seconds / level.iterations.max(1) as f64;
        println!("| one iteration, cluster radius {:.1} | {ms:.1} | 534 |", level.radius);
    }
    println!("| whole hand, {} iterations | {whole:.0} | 120000 to 180000 |", found.iterations());
}
