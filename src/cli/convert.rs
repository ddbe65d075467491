//! `moulage convert`.

use std::process::ExitCode;

use moulage::Result;
use moulage::error::Shown;
use moulage::job::{Conversion, convert};

/// Converts a skeleton or a motion and says what was left out.
pub fn run(job: &Conversion) -> Result<ExitCode> {
    for note in convert(job)? {
        eprintln!("note: {note}");
    }
    println!("wrote {}", job.to.shown());
    Ok(ExitCode::SUCCESS)
}
