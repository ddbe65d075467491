//! Does `register` find bones in images, and does no run end farther off than it began? Prints the table of
//! `docs/images.md`; the folder holds cases as the project's data set does.
//!
//! `cargo run --release --example images -- FOLDER [PART OF A CASE'S NAME...]`
#![allow(clippy::print_stdout, clippy::unwrap_used)]

mod cases;
#[path = "../../tests/hands/mod.rs"]
mod hands;
#[path = "../../tests/synthetic/mod.rs"]
mod synthetic;

use std::path::Path;
use std::time::Instant;

use cases::Case;
use moulage::Run;
use moulage::register::{Appearance, Options, Target, register};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().unwrap_or_else(|| "../shared/data".into());
    let names: Vec<String> = arguments.collect();
    println!("| case | bone | start, mm | profiles | s | verdict |");
    println!("|---|---|---|---|---|---|");
    let chosen = |name: &str| names.is_empty() || names.iter().any(|part| name.contains(part));
    for case in cases::all(Path::new(&folder), chosen) {
        run(&case);
    }
}

fn run(case: &Case) {
    let looks = Appearance::profiles(&case.reference, &case.reference_image, None).unwrap();
    let target = Target::image(&case.start, case.image.clone(), looks).unwrap();
    let started = Instant::now();
    let found = register(&case.start, &target, &Options::default(), &Run::new()).unwrap();
    let seconds = started.elapsed().as_secs_f64();
    let verdict = found.judgement.verdict.name();
    let (before, after) = (case.errors(&case.start), case.errors(&found.skeleton));
    for ((bone, start), (_, end)) in before.into_iter().zip(after) {
        let mark = if end > start + 0.005 { " !" } else { "" };
        println!(
            "| {} | {bone} | {start:.2} | {end:.2}{mark} | {seconds:.0} | {verdict} |",
            case.name
        );
    }
}
