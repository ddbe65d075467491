//! `moulage track`.

use std::process::ExitCode;

use moulage::job::{TrackJob, run_track};
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
        println!(
            "{}: recognized {:.0} % of the surface, {} iterations",
            frame.volume.display(),
            100.0 * frame.seen,
            frame.registered.iterations()
        );
    }
    println!("written: {} frames and angles.csv in {}", frames.len(), job.out.display());
    Ok(ExitCode::from(if run.is_cancelled() { super::INTERRUPTED } else { 0 }))
}
