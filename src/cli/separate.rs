//! `moulage separate`.

use std::process::ExitCode;

use moulage::error::Shown;
use moulage::job::{SeparateJob, SeparationReport, run_separate};
use moulage::separate::Ending;
use moulage::{Result, Run};

use super::progress::{Progress, stop_on_ctrl_c};

/// Runs one separation and prints what came out.
pub fn run(job: &SeparateJob) -> Result<ExitCode> {
    let run = Run::new();
    stop_on_ctrl_c(&run);
    let progress = Progress::watch(&run);
    let result = run_separate(job, &run);
    drop(progress);
    let report = result?;
    print(&report);
    for path in &report.written {
        println!("written: {}", path.shown());
    }
    Ok(ExitCode::from(match report.summary.ending {
        _ if report.summary.separated => 0,
        Ending::Cancelled => super::INTERRUPTED,
        _ => super::GAVE_UP,
    }))
}

/// The lines about overlaps and bodies.
pub(super) fn print(report: &SeparationReport) {
    for line in &report.summary.overlaps {
        let ([a, b], [before, after]) = (&line.between, line.depth);
        println!("{a} and {b}: overlap {before:.4} deep before, {after:.4} after");
    }
    for body in &report.summary.bodies {
        println!(
            "{}: {} of {} vertices moved, at most {:.4}; {} inverted tets",
            body.name, body.moved, body.vertices, body.largest_move, body.inverted_tets
        );
        if let Some([before, after]) = &body.marker_distance {
            println!(
                "  markers: mean {:.4}, largest {:.4} before, {:.4}, {:.4} after",
                before.mean, before.max, after.mean, after.max
            );
        }
        if !body.contradicting_markers.is_empty() {
            let named = body.contradicting_markers.iter();
            let named: Vec<_> = named.map(|m| format!("{} ({})", m.marker, m.inside)).collect();
            println!(
                "  {} markers lie inside a bone and cannot be met: {}",
                named.len(),
                named.join(", ")
            );
        }
    }
    println!("{} rounds, {:.1} s", report.summary.rounds, report.seconds);
    if report.summary.separated {
        println!("No triangle of one surface crosses or lies inside another.");
    } else {
        let left = report
            .summary
            .overlaps
            .iter()
            .filter(|line| line.crossings[1] + line.vertices_inside[1] > 0);
        let why = match report.summary.ending {
            Ending::Cancelled => "the run was interrupted",
            _ => "allow more --rings, or look whether the shapes contradict each other",
        };
        eprintln!(
            "{} overlaps are left, the shapes with the least overlap are kept: {why}",
            left.count()
        );
    }
}
