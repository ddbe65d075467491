//! Scans as strangers bring them: cut off, with things in them that are no bones, noisy. The whole table is made by
//! `examples/verdict`.
#![allow(clippy::unwrap_used)]

mod hands;

use std::path::Path;

use hands::{damage, vertex_error};
use moulage::io::read_surface;
use moulage::locate::ClosestPoints;
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
fn a_hand_cut_off_across_its_fingers_is_found_as_far_as_it_is_seen() {
    let truth = hand();
    is_found_as_far_as_it_is_seen(damage::cut(&truth, 0.33, true), &truth, false);
    is_found_as_far_as_it_is_seen(damage::cut_and_closed(&truth, 0.33, true), &truth, true);
}

fn is_found_as_far_as_it_is_seen(scan: TriMesh, truth: &TriMesh, closed: bool) {
    let search = ClosestPoints::new(&scan.points, &scan.triangles);
    let found = found(scan);
    assert_eq!(found.notes.iter().any(|note| note.contains("ends in flat faces")), closed);
    let (mut whole, mut gone) = (0, 0);
    for (b, bone) in found.bones.iter().enumerate() {
        let range = found.skeleton.bones[b].vertices.clone();
        let count = range.len();
        let places = &truth.points[range];
        let seen = places.iter().filter(|p| search.closest_within(p, 1e-9).is_some()).count();
        if seen == count {
            whole += 1;
            let error = error(&found, b, truth);
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
    let found = found(damage::blobs(&truth, 10, 8.0));
    let error = vertex_error(&found.skeleton.points, &truth.points);
    assert!(error < 0.3, "{error}");
}

#[test]
fn noise_as_large_as_the_triangles_is_smoothed_and_said() {
    let truth = hand();
    let found = found(damage::noisy(&truth, 1.0));
    let error = vertex_error(&found.skeleton.points, &truth.points);
    assert!(error < 0.7, "{error}");
    assert!(found.notes.iter().any(|note| note.contains("smoothed")), "{:?}", found.notes);
}
