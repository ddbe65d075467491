//! `moulage model`.

use std::process::ExitCode;

use clap::Subcommand;
use moulage::error::Shown;
use moulage::job::{ModelFitJob, ModelShapeJob, run_model_fit, run_model_shape};
use moulage::{Result, Run};

use super::progress::{Progress, stop_on_ctrl_c};

#[derive(Subcommand)]
pub enum Command {
    /// Learn the shapes of all bones from earlier results
    Fit(ModelFitJob),
    /// Make a shape from a model
    Shape(ModelShapeJob),
}

/// Runs one of the commands and prints what came out.
pub fn run(command: &Command) -> Result<ExitCode> {
    match command {
        Command::Fit(job) => {
            let run = Run::new();
            stop_on_ctrl_c(&run);
            let progress = Progress::watch(&run);
            let report = run_model_fit(job, &run);
            drop(progress);
            let report = report?;
            for (k, (size, explained)) in
                report.deviations.iter().zip(&report.explained).enumerate()
            {
                println!("mode {}: {size:.3}, {:.1} % explained", k + 1, 100.0 * explained);
            }
            println!("wrote {}", job.out.shown());
        }
        Command::Shape(job) => println!("wrote {}", run_model_shape(job)?.shown()),
    }
    Ok(ExitCode::SUCCESS)
}
