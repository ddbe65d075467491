//! The ablation of Figure 4 of Gilles, Reveret, Pai 2010 on two finger bones in fused, noisy scans: what
//! clusters, plausible shapes and joints add. Prints the table of `docs/register.md`:
//!
//! `cargo run --release --example figure4`
#![allow(clippy::print_stdout, clippy::unwrap_used, clippy::expect_used)]

#[path = "../tests/hands/mod.rs"]
mod hands;

use moulage::Run;
use moulage::math::Vec3;
use moulage::register::bone_scales::ScaleFreedom;
use moulage::register::options::{Levels, Schedule};
use moulage::register::rotation::turned_about;
use moulage::register::{Options, Registered, Skeleton, Target, register};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

/// Persons, by the seed of their random shapes.
const PERSONS: [u64; 3] = [21, 22, 23];
/// Flexions of the joint, degrees.
const FLEXIONS: [f64; 3] = [30.0, 60.0, 85.0];

fn finger() -> Skeleton {
    let hand = hands::template();
    let bones = ["2proxph", "2midph"].map(|name| hand.bone_index(name).unwrap());
    let mut joint = hand.joints.iter().find(|j| [j.parent, j.child] == bones).unwrap().clone();
    [joint.parent, joint.child] = [0, 1];
    let surface = |b: usize| (hand.bones[b].name.clone(), hand.bone_surface(b, &hand.points));
    Skeleton::new(bones.map(surface).to_vec(), vec![joint]).unwrap()
}

/// The finger of another person, flexed and moved a little.
fn person(template: &Skeleton, seed: u64, flexion: f64) -> Skeleton {
    let mut other = hands::person(template, seed, 0.0, hands::BUMPS);
    let frame = other.joints[0].parent_frame;
    let centre = frame.translation.vector;
    let axis = frame.rotation * template.joints[0].coordinates[0].axis;
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
    // The paper's clusters, mm.
    let published = || Options {
        levels: Levels::Radii(vec![f64::INFINITY, 30.0, 15.0, 6.0]),
        clustering: near().clustering,
        pair_spacing: near().pair_spacing,
        align: false,
        max_iterations: 12,
        ..Options::published()
    };
    let bare = |o: Options| Options {
        use_joints: false,
        scale_freedom: ScaleFreedom::Fixed,
        schedule: Schedule::Never,
        ..o
    };
    vec![
        ("clusters across bones only", bare(published())),
        ("bones apart", bare(Options { separate_bones: true, ..published() })),
        ("clusters and bone scales, no joints", Options { use_joints: false, ..published() }),
        ("published loop: clusters, scales, joints", published()),
        ("the same, template to target pairs only", Options { both_ways: false, ..published() }),
        ("default", near()),
    ]
}

/// For every configuration the errors at each flexion, those of the middle person.
pub fn ablation<const N: usize>(
    persons: &[u64],
    flexions: [f64; N],
) -> Vec<(&'static str, [[f64; 3]; N])> {
    let template = finger();
    let scans = flexions.map(|flexion| {
        let one = |&seed: &u64| {
            let truth = person(&template, seed, flexion);
            let scan = hands::fused_scan(&truth, seed);
            (truth, Target::whole(scan).unwrap())
        };
        persons.iter().map(one).collect::<Vec<_>>()
    });
    let middle = |options: &Options, scans: &[(Skeleton, Target)]| {
        let one = |(truth, target): &(Skeleton, Target)| {
            // The ablations' own results are wanted, wrong ones too.
            let options = Options { as_is: true, ..options.clone() };
            errors(&register(&template, target, &options, &Run::new()).unwrap(), truth)
        };
        let mut all: Vec<[f64; 3]> = scans.iter().map(one).collect();
        all.sort_by(|a, b| a[0].total_cmp(&b[0]));
        all[all.len() / 2]
    };
    let all = |options: &Options| std::array::from_fn(|k| middle(options, &scans[k]));
    configurations().iter().map(|(name, options)| (*name, all(options))).collect()
}

fn main() {
    println!("| | 30 deg | 60 deg | 85 deg | angle error at 85 | gap at 85 |");
    println!("|---|---|---|---|---|---|");
    for (name, errors) in ablation(&PERSONS, FLEXIONS) {
        let vertices = errors.map(|e| format!("{:.2}", e[0])).join(" | ");
        println!("| {name} | {vertices} | {:.1} | {:.2} |", errors[2][1], errors[2][2]);
    }
}
