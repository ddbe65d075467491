//! `moulage anatomy`.

use std::path::PathBuf;
use std::process::ExitCode;

use moulage::error::Shown;
use moulage::job::{AnatomyJob, ObjectLine, Status, run_anatomy};
use moulage::{Result, Run};

use super::progress::{Progress, stop_on_ctrl_c};

#[derive(clap::Args)]
pub struct Arguments {
    /// Job file (TOML) with a list of [[object]]
    #[arg(value_name = "JOB.toml")]
    job: PathBuf,
    /// Folder for all results [default: out of the job]
    #[arg(short, long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Objects reshaped at once [default: as many as cores and memory allow]
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
}

/// Runs one anatomy and prints what came out.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let mut job = AnatomyJob::read(&arguments.job)?;
    job.out = arguments.out.clone().or(job.out);
    job.jobs = arguments.jobs.or(job.jobs);
    let run = Run::new();
    stop_on_ctrl_c(&run);
    let progress = Progress::watch(&run);
    let result = run_anatomy(&job, &run);
    drop(progress);
    let report = result?;
    for object in &report.objects {
        print_object(object);
    }
    if let Some(separation) = &report.separation {
        super::separate::print(separation);
    }
    for warning in &report.warnings {
        eprintln!("note: {warning}");
    }
    let seconds: f64 = report.stages.iter().map(|stage| stage.seconds).sum();
    println!("{} objects, {} bones, {seconds:.1} s", report.objects.len(), report.bones.len());
    for path in report.written.iter().filter(|p| p.extension().is_some_and(|e| e == "html")) {
        println!("written: {}", path.shown());
    }
    Ok(ExitCode::from(if report.interrupted {
        super::INTERRUPTED
    } else if report.count(Status::Failed) > 0 {
        super::BAD_INPUT
    } else if report.is_good() {
        0
    } else {
        super::GAVE_UP
    }))
}

fn print_object(object: &ObjectLine) {
    let word = object.status.map_or("not done", Status::name);
    let kept = if object.kept { ", kept" } else { "" };
    println!("{}: {word}{kept}: {}", object.name, object.message);
    if let Some(f) = &object.figures {
        let d = &f.marker_distance;
        println!(
            "  markers: mean {:.4}, largest {:.4} before, {:.4}, {:.4} after; {} tets, {} inverted",
            d.before.mean, d.before.max, d.after.mean, d.after.max, f.tets, f.inverted_tets
        );
    }
}
