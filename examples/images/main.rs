//! Does `register` find bones in images, does no run end farther off than it began, and does the verdict say
//! which bones are wrong? Prints the table of `docs/images.md`; the folder holds cases as the project's data
//! set does.
//!
//! `cargo run --release --example images -- FOLDER [PART OF A CASE'S NAME...]`
//!
//! With `MOULAGE_IMAGE_BONES=FILE` it writes a line for each bone: error, likeness, verdict, reasons.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod cases;
#[path = "../verdict/counts.rs"]
mod counts;
mod damaged;
#[path = "../../tests/hands/mod.rs"]
mod hands;
mod person;
#[path = "../../tests/synthetic/mod.rs"]
mod synthetic;

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use cases::Case;
use counts::Counts;
use moulage::Run;
use moulage::mesh::normals::{area_vectors, vertex_normals};
use moulage::register::{Appearance, Options, Registered, Target, Verdict, register};

/// A bone that is further off than this, mm, is wrong.
const WRONG: f64 = 2.0;
/// So many bones have an error each in the table.
const FEW: usize = 3;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().unwrap_or_else(|| "../shared/data".into());
    let names: Vec<String> = arguments.collect();
    println!(
        "| case | start, mm | found | wrong bones, named | right bones, named | the whole | s |"
    );
    println!("|---|---|---|---|---|---|---|");
    let chosen = |name: &str| names.is_empty() || names.iter().any(|part| name.contains(part));
    let mut lines = String::from("case\tbone\tstart\terror\tlikeness\tseen\tverdict\treasons\n");
    let mut all = Counts::default();
    for case in cases::all(Path::new(&folder), chosen) {
        all.join(&run(&case, &mut lines));
    }
    println!("\n{}", all.summary());
    if let Some(path) = std::env::var_os("MOULAGE_IMAGE_BONES") {
        std::fs::write(path, lines).unwrap();
    }
}

/// The errors of a few bones, of many their root mean square.
fn shown(errors: &[Option<f64>]) -> String {
    let known: Vec<f64> = errors.iter().flatten().copied().collect();
    if known.len() <= FEW {
        return known.iter().map(|e| format!("{e:.2}")).collect::<Vec<_>>().join(", ");
    }
    let squares: f64 = known.iter().map(|e| e * e).sum();
    format!("{:.2}", (squares / known.len() as f64).sqrt())
}

/// Runs one case and prints its row.
fn run(case: &Case, lines: &mut String) -> Counts {
    let looks = Appearance::profiles(&case.reference, &case.reference_image, None).unwrap();
    let target = Target::image(&case.start, case.image.clone(), looks.clone()).unwrap();
    let started = Instant::now();
    let found = register(&case.start, &target, &Options::default(), &Run::new()).unwrap();
    let seconds = started.elapsed().as_secs_f64();
    let (before, after) = (case.errors(&case.start), case.errors(&found.skeleton));
    let likeness = likeness(case, &looks, &found);
    let mut counts = Counts::default();
    for (b, bone) in found.bones.iter().enumerate() {
        let error = after[b].unwrap_or(f64::INFINITY);
        counts.add(error, WRONG, bone.verdict > Verdict::Good);
        writeln!(
            lines,
            "{}\t{}\t{:.2}\t{error:.2}\t{:.3}\t{:.2}\t{}\t{}",
            case.name,
            bone.name,
            before[b].unwrap_or(f64::NAN),
            likeness[b],
            bone.seen,
            bone.verdict.name(),
            bone.reasons.join("; ")
        )
        .unwrap();
    }
    println!(
        "| {} | {} | {} | {counts} | {} | {seconds:.0} |",
        case.name,
        shown(&before),
        shown(&after),
        found.judgement.verdict.name()
    );
    counts
}

/// The mean over each bone's vertices.
fn likeness(case: &Case, looks: &Appearance, found: &Registered) -> Vec<f64> {
    let Appearance::Profiles(profiles) = looks else { return Vec::new() };
    let skeleton = &found.skeleton;
    let faces = area_vectors(&skeleton.points, &skeleton.triangles);
    let normals = vertex_normals(skeleton.points.len(), &skeleton.triangles, &faces);
    let all = profiles.likeness(&case.image, &skeleton.points, &normals);
    let mean = |range: std::ops::Range<usize>| {
        let own: Vec<f64> = all[range].iter().flatten().copied().collect();
        own.iter().sum::<f64>() / own.len() as f64
    };
    skeleton.bones.iter().map(|bone| mean(bone.vertices.clone())).collect()
}
