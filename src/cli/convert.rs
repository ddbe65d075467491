//! `moulage convert`.

use std::path::PathBuf;
use std::process::ExitCode;

use moulage::Result;
use moulage::job::convert_skeleton;

#[derive(clap::Args)]
pub struct Arguments {
    /// Skeleton: .osim or .skeleton.json
    #[arg(value_name = "FROM")]
    from: PathBuf,
    /// .skeleton.json (from .osim) or .glb (from .skeleton.json)
    #[arg(value_name = "TO")]
    to: PathBuf,
}

/// Converts a skeleton and says what was left out.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    for note in convert_skeleton(&arguments.from, &arguments.to)? {
        eprintln!("note: {note}");
    }
    println!("wrote {}", arguments.to.display());
    Ok(ExitCode::SUCCESS)
}
