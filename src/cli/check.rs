//! `moulage check`.

use std::path::PathBuf;
use std::process::ExitCode;

use moulage::error::Shown;
use moulage::job::check_file;

#[derive(clap::Args)]
pub struct Arguments {
    /// Surfaces, markers, pairs, tet meshes, images (files or DICOM folders), skeletons, motions or job files
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
}

/// Prints what each file holds and what is wrong with it. Only files that cannot be used are bad
/// input; findings are for the user to judge.
pub fn run(arguments: &Arguments) -> ExitCode {
    let mut code = 0;
    for path in &arguments.files {
        match check_file(path) {
            Ok(check) => {
                println!("{}: {}", path.shown(), check.content);
                for finding in check.findings {
                    println!("  {finding}");
                }
            }
            Err(error) => {
                eprintln!("moulage: {error}");
                code = super::BAD_INPUT;
            }
        }
    }
    ExitCode::from(code)
}
