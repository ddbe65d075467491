//! The ablation of Figure 4 of Gilles, Reveret, Pai 2010 on two finger bones: what clusters, plausible
//! shapes and joints add. Prints the table of `docs/register.md`:
//!
//! `cargo run --release --example figure4`
#![allow(clippy::print_stdout, clippy::unwrap_used, clippy::expect_used)]

use std::path::Path;

use moulage::job::read_skeleton;
use moulage::math::Vec3;
use moulage::register::bone_scales::ScaleFreedom;
use moulage::register::rotation::turned_about;
use moulage::register::{Options, Registered, Skeleton, Target, register};
use moulage::{Run, TriMesh};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

/// Sizes of the two bones along x, y, z for each person.
const PERSONS: [[[f64; 3]; 2]; 3] = [
    [[1.04, 1.08, 1.02], [1.07, 1.03, 1.06]],
    [[0.95, 0.97, 0.93], [0.97, 0.94, 0.96]],
    [[1.03, 0.98, 1.08], [1.00, 1.06, 1.04]],
];
/// Flexions of the joint, degrees.
const FLEXIONS: [f64; 3] = [30.0, 60.0, 85.0];

fn finger() -> Skeleton {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand/skeleton.json");
    let hand = read_skeleton(&path).expect("the example is part of the repository").skeleton;
    let bones = ["2proxph", "2midph"].map(|name| hand.bone_index(name).unwrap());
    let mut joint = hand.joints.iter().find(|j| [j.parent, j.child] == bones).unwrap().clone();
    [joint.parent, joint.child] = [0, 1];
    let surface = |b: usize| (hand.bones[b].name.clone(), hand.bone_surface(b, &hand.points));
    Skeleton::new(bones.map(surface).to_vec(), vec![joint]).unwrap()
}

/// The finger of another person: bones scaled about the joint, then flexed and moved a little.
fn person(template: &Skeleton, sizes: &[[f64; 3]; 2], flexion: f64) -> Skeleton {
    let mut other = template.clone();
    let centre = template.joints[0].parent_frame.translation.vector;
    for (bone, size) in template.bones.iter().zip(sizes) {
        for p in &mut other.points[bone.vertices.clone()] {
            *p = centre + (*p - centre).component_mul(&Vec3::from(*size));
        }
    }
    let axis = template.joints[0].parent_frame.rotation * template.joints[0].coordinates[0].axis;
    let turn = UnitQuaternion::from_scaled_axis(axis * flexion.to_radians());
    let bend = turned_about(&Isometry3::identity(), &centre, turn);
    let tilt = UnitQuaternion::from_scaled_axis(Vec3::new(0.05, -0.08, 0.03));
    let away =
        Translation3::new(2.0, -1.5, 1.0) * turned_about(&Isometry3::identity(), &centre, tilt);
    other.move_bones(&[away, away * bend]);
    other
}

/// Root mean square vertex error, error of the joint's angle in degrees, gap between the joint's two
/// centres.
fn errors(found: &Registered, truth: &Skeleton) -> [f64; 3] {
    let squares: f64 =
        found.skeleton.points.iter().zip(&truth.points).map(|(p, q)| (p - q).norm_squared()).sum();
    let still = Isometry3::identity();
    let [a, b] = [&found.skeleton, truth].map(|s| s.joints[0].transform(&still, &still).rotation);
    let rms = (squares / truth.points.len() as f64).sqrt();
    [rms, a.angle_to(&b).to_degrees(), found.joints[0].seam]
}

fn configurations() -> Vec<(&'static str, Options)> {
    // As in the paper, the template starts near the target; sampled clusters and pairs save time.
    let near = || Options { align: false, max_iterations: 12, ..Options::default() };
    let published = || Options {
        clustering: near().clustering,
        pair_spacing: near().pair_spacing,
        align: false,
        max_iterations: 12,
        ..Options::published()
    };
    let bare = |o: Options| Options { use_joints: false, scale_freedom: ScaleFreedom::Fixed, ..o };
    vec![
        ("clusters across bones only", bare(published())),
        ("bones apart", bare(Options { separate_bones: true, ..published() })),
        ("clusters and bone scales, no joints", Options { use_joints: false, ..published() }),
        ("published loop: clusters, scales, joints", published()),
        ("the same, template to target pairs only", Options { both_ways: false, ..published() }),
        ("default", near()),
    ]
}

fn main() {
    let template = finger();
    println!("| | 30 deg | 60 deg | 85 deg | angle error at 85 | gap at 85 |");
    println!("|---|---|---|---|---|---|");
    for (name, options) in configurations() {
        let mut cells = Vec::new();
        let mut last = [0.0; 3];
        for flexion in FLEXIONS {
            let mut all: Vec<[f64; 3]> = PERSONS
                .iter()
                .map(|sizes| {
                    let truth = person(&template, sizes, flexion);
                    let surface =
                        TriMesh::new(truth.points.clone(), truth.triangles.clone()).unwrap();
                    let target = Target::whole(surface).unwrap();
                    let found = register(&template, &target, &options, &Run::new()).unwrap();
                    errors(&found, &truth)
                })
                .collect();
            all.sort_by(|a, b| a[0].total_cmp(&b[0]));
            last = all[PERSONS.len() / 2];
            cells.push(format!("{:.2}", last[0]));
        }
        println!("| {name} | {} | {:.1} | {:.2} |", cells.join(" | "), last[1], last[2]);
    }
}
