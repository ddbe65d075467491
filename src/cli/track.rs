//! `moulage track`.

use std::process::ExitCode;

use moulage::error::Shown;
use moulage::job::{TrackJob, run_track};
use moulage::register::Verdict;
use moulage::{Result, Run};

use super::progress::{Progress, stop_on_ctrl_c};

/// Runs one tracking and prints each frame.
pub fn run(job: &TrackJob) -> Result<ExitCode> {
    let run = Run::new();
    stop_on_ctrl_c(&run);
    let progress = Progress::watch(&run);
    let frames = run_track(job, &run);
    drop(progress);
    let frames = frames?;
    for frame in &frames {
        for reason in &frame.registered.judgement.reasons {
            eprintln!("note: {}: {reason}", frame.volume.shown());
        }
        println!(
            "{}: {}, recognized {:.0} % of the surface, {} iterations",
            frame.volume.shown(),
            frame.registered.judgement.verdict.name(),
            100.0 * frame.seen,
            frame.registered.iterations()
        );
    }
    println!("written: {} frames and angles.csv in {}", frames.len(), job.out.shown());
    let failed = frames.iter().any(|f| f.registered.judgement.verdict == Verdict::Failed);
    Ok(ExitCode::from(match failed {
        _ if run.is_cancelled() => super::INTERRUPTED,
        true => super::GAVE_UP,
        false => 0,
    }))
}
