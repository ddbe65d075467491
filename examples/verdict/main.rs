//! Are the verdicts of `register` right? Runs it on persons whose bones are known, whole and damaged, and compares what
//! it says of each bone with how far off the bone is. Prints the table of `docs/register.md`; the folder holds cases as
//! the project's data set does.
//!
//! `cargo run --release --example verdict -- FOLDER [PART OF A CASE'S NAME...]`
//!
//! With `MOULAGE_VERDICT_BONES=FILE` it writes a line for each bone: error, verdict, reasons.
#![allow(clippy::print_stdout, clippy::panic, clippy::unwrap_used)]

mod cases;
mod counts;
#[path = "../../tests/hands/mod.rs"]
mod hands;

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use cases::{Case, Truth};
use counts::Counts;
use moulage::Run;
use moulage::locate::ClosestPoints;
use moulage::register::{Options, Registered, Verdict, register};

/// A bone of which the target shows this share is shown; of which it shows no more than the rest of it, is not.
const SHOWN: f64 = 0.9;

/// How far bone `b` is off: root mean square of its vertices, or mean distance from the true surface.
fn error(case: &Case, found: &Registered, b: usize) -> Option<f64> {
    let bone = found.skeleton.bone_surface(b, &found.skeleton.points);
    let count = bone.points.len() as f64;
    Some(match case.truth[b].as_ref()? {
        Truth::Vertices(truth) => {
            let squares: f64 =
                bone.points.iter().zip(truth).map(|(p, q)| (p - q).norm_squared()).sum();
            (squares / count).sqrt()
        }
        Truth::Surface(surface) | Truth::Part(surface) => {
            let search = ClosestPoints::new(&bone.points, &bone.triangles);
            let hits = search.closest_many(&surface.points);
            let distances = hits.iter().flatten().zip(&surface.points);
            let sum: f64 = distances.map(|(hit, p)| (hit.position - p).norm()).sum();
            sum / surface.points.len() as f64
        }
    })
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().unwrap_or_else(|| panic!("give the folder with the cases"));
    let parts: Vec<String> = arguments.collect();
    let mut lines = String::from("case\tbone\tshown\tseen\terror\tverdict\treasons\n");
    let mut all = Counts::default();
    println!(
        "| case | rms error of bones shown, mm | in part | not | wrong bones, named | right bones, named | the whole | s |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for case in cases::all(Path::new(&folder)) {
        if parts.is_empty() || parts.iter().any(|part| case.name.contains(part)) {
            all.join(&run(&case, &mut lines));
        }
    }
    println!("\n{}", all.summary());
    if let Some(path) = std::env::var_os("MOULAGE_VERDICT_BONES") {
        std::fs::write(path, lines).unwrap();
    }
}

/// Root mean square; nothing of none.
fn rms(errors: &[f64]) -> String {
    let squares: f64 = errors.iter().map(|e| e * e).sum();
    if errors.is_empty() {
        String::new()
    } else {
        format!("{:.2}", (squares / errors.len() as f64).sqrt())
    }
}

/// Runs one case and prints its row.
fn run(case: &Case, lines: &mut String) -> Counts {
    let started = Instant::now();
    let found = register(&case.template, &case.target, &Options::default(), &Run::new());
    let seconds = started.elapsed().as_secs_f64();
    let mut counts = Counts::default();
    let found = match found {
        Ok(found) => found,
        Err(e) => {
            let wrongly = if case.refused { "" } else { " (WRONGLY)" };
            println!("| {} | | | | | | refused{wrongly}: {e} | {seconds:.1} |", case.name);
            return counts;
        }
    };
    let mut errors: [Vec<f64>; 3] = Default::default();
    for (b, bone) in found.bones.iter().enumerate() {
        let Some(error) = error(case, &found, b) else { continue };
        // A part does not tell that the rest is right.
        if error > case.wrong || !matches!(case.truth[b], Some(Truth::Part(_))) {
            counts.add(error, case.wrong, bone.verdict > Verdict::Good);
        }
        let place = match case.shown[b] {
            shown if shown >= SHOWN => 0,
            shown if shown > 1.0 - SHOWN => 1,
            _ => 2,
        };
        errors[place].push(error);
        let (name, verdict) = (&bone.name, bone.verdict.name());
        writeln!(
            lines,
            "{}\t{name}\t{:.2}\t{:.2}\t{error:.3}\t{verdict}\t{}",
            case.name,
            case.shown[b],
            bone.seen,
            bone.reasons.join("; ")
        )
        .unwrap();
    }
    println!(
        "| {} | {} | {counts} | {}{} | {seconds:.1} |",
        case.name,
        errors.each_ref().map(|errors| rms(errors)).join(" | "),
        found.judgement.verdict.name(),
        if case.refused { " (NOT REFUSED)" } else { "" }
    );
    counts
}
