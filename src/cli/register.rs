//! `moulage register`.

use std::process::ExitCode;

use moulage::error::Shown;
use moulage::job::{RegisterJob, RegisterReport, run_register};
use moulage::register::Verdict;
use moulage::{Result, Run};

use super::progress::{Progress, stop_on_ctrl_c};

/// Runs one registration and prints what came out.
pub fn run(job: &RegisterJob) -> Result<ExitCode> {
    let run = Run::new();
    stop_on_ctrl_c(&run);
    let progress = Progress::watch(&run);
    let result = run_register(job, &run);
    drop(progress);
    let report = result?.report;
    print(&report);
    Ok(ExitCode::from(match report.verdict {
        _ if report.cancelled => super::INTERRUPTED,
        Verdict::Failed => super::GAVE_UP,
        Verdict::Good | Verdict::Doubtful => 0,
    }))
}

fn print(report: &RegisterReport) {
    for warning in &report.warnings {
        eprintln!("note: {warning}");
    }
    println!("{}", report.headline());
    let worst = report.bones.iter().max_by(|a, b| a.mean_residual.total_cmp(&b.mean_residual));
    println!(
        "{} bones: residual mean {:.4}{}",
        report.bones.len(),
        report.mean_residual(),
        worst.map_or_else(String::new, |b| format!(", worst {} {:.4}", b.name, b.mean_residual))
    );
    let outside = report.joints.iter().filter(|j| j.excess_degrees > 1e-3 || j.excess_shift > 1e-6);
    println!("{} joints, {} outside their limits", report.joints.len(), outside.count());
    println!("{} iterations, {:.2} s", report.iterations, report.seconds);
    for path in report.written.iter().filter(|p| !p.to_string_lossy().contains("bones")) {
        println!("wrote {}", path.shown());
    }
}
