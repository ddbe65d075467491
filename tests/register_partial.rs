//! Scans as strangers bring them: cut off, with things in them that are no bones, noisy. The whole table is made by
//! `examples/verdict`.
#![allow(clippy::unwrap_used)]

mod hands;

use std::path::Path;

use hands::{Noise, vertex_error};
use moulage::io::read_surface;
use moulage::locate::ClosestPoints;
use moulage::math::Vec3;
use moulage::mesh::bounding_box;
use moulage::register::{Options, Registered, Target, Verdict, register};
use moulage::{Run, TriMesh};

fn hand() -> TriMesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand/target_surface.ply");
    read_surface(&path).unwrap().mesh().unwrap()
}

fn found(scan: TriMesh) -> Registered {
    let target = Target::whole(scan).unwrap();
    register(&hands::template(), &target, &Options::default(), &Run::new()).unwrap()
}

/// How far bone `b` is off, root mean square.
fn error(found: &Registered, b: usize, truth: &TriMesh) -> f64 {
    let range = found.skeleton.bones[b].vertices.clone();
    vertex_error(&found.skeleton.points[range.clone()], &truth.points[range])
}

#[test]
fn a_hand_cut_off_behind_its_knuckles_is_found_as_far_as_it_is_seen() {
    let truth = hand();
    // From the wrist to the finger tips: the way of the largest extent.
    let (low, high) = bounding_box(&truth.points).unwrap();
    let along = |p: &Vec3| p[(high - low).imax()];
    let mut heights: Vec<f64> = truth.points.iter().map(along).collect();
    heights.sort_by(f64::total_cmp);
    let cut = heights[2 * heights.len() / 3];
    let mut scan = truth.clone();
    scan.triangles.retain(|t| t.iter().all(|&v| along(&truth.points[v as usize]) < cut));
    let search = ClosestPoints::new(&scan.points, &scan.triangles);
    let found = found(scan);
    let (mut whole, mut gone) = (0, 0);
    for (b, bone) in found.bones.iter().enumerate() {
        let range = found.skeleton.bones[b].vertices.clone();
        let count = range.len();
        let places = &truth.points[range];
        let seen = places.iter().filter(|p| search.closest_within(p, 1e-9).is_some()).count();
        if seen == count {
            whole += 1;
            let error = error(&found, b, &truth);
            assert!(error < 0.3, "{error} {bone:?}");
        } else if seen == 0 {
            gone += 1;
            assert!(bone.verdict > Verdict::Good, "{bone:?}");
        }
    }
    assert!(whole > 8 && gone > 3, "{whole} bones are whole, {gone} are gone");
}

#[test]
fn balls_in_the_scan_draw_no_bone_away() {
    let truth = hand();
    let mut scan = truth.clone();
    let mut noise = Noise(11);
    for _ in 0..10 {
        let at = f64::midpoint(noise.next(), 1.0) * truth.points.len() as f64;
        let ball = ball(truth.points[at as usize], 8.0);
        let first = scan.points.len() as u32;
        scan.points.extend(ball.points);
        scan.triangles.extend(ball.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    let found = found(scan);
    let error = vertex_error(&found.skeleton.points, &truth.points);
    assert!(error < 0.3, "{error}");
}

/// A ball of 16 rings.
fn ball(centre: Vec3, radius: f64) -> TriMesh {
    let mut mesh = TriMesh::default();
    for i in 0..=16_u32 {
        for j in 0..32_u32 {
            let polar = std::f64::consts::PI * f64::from(i) / 16.0;
            let turn = std::f64::consts::TAU * f64::from(j) / 32.0;
            let out = Vec3::new(polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos());
            mesh.points.push(centre + radius * out);
            if i < 16 {
                let [a, b] = [i * 32 + j, i * 32 + (j + 1) % 32];
                mesh.triangles.extend([[a, a + 32, b + 32], [a, b + 32, b]]);
            }
        }
    }
    mesh
}

#[test]
fn noise_as_large_as_the_triangles_is_smoothed_and_said() {
    let truth = hand();
    let mut noise = Noise(7);
    let mut scan = truth.clone();
    for point in &mut scan.points {
        // The mean of three values from -1 to 1, times 3: near enough to a normal distribution.
        *point += noise.vector() + noise.vector() + noise.vector();
    }
    let found = found(scan);
    let error = vertex_error(&found.skeleton.points, &truth.points);
    assert!(error < 0.7, "{error}");
    assert!(found.notes.iter().any(|note| note.contains("smoothed")), "{:?}", found.notes);
}
