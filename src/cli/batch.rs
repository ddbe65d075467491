//! `moulage batch`.

use std::process::ExitCode;

use moulage::error::Shown;
use moulage::job::{BatchJob, Status, run_batch};
use moulage::{Result, Run};

use super::progress::{Progress, stop_on_ctrl_c};

/// Runs all cases and prints one line for each.
pub fn run(job: &BatchJob) -> Result<ExitCode> {
    let run = Run::new();
    stop_on_ctrl_c(&run);
    let progress = Progress::watch(&run);
    let cases = run_batch(job, &run);
    drop(progress);
    let cases = cases?;
    let mut code = 0;
    for case in &cases {
        let record = &case.record;
        let own = match record.status {
            Status::Good => 0,
            Status::Doubtful => super::GAVE_UP,
            Status::Failed => super::BAD_INPUT,
        };
        let kept = if case.kept { ", kept" } else { "" };
        println!("{}: {}{kept}: {}", record.name, record.status.name(), record.message);
        // A failed case weighs more than a doubtful one.
        if own == super::BAD_INPUT || code == 0 {
            code = own;
        }
    }
    if !job.no_summary {
        println!("written: {}", job.out.join("index.html").shown());
    }
    Ok(ExitCode::from(code))
}
