//! Many jobs, one after the other or several at once; what is done already is not done again.

use std::path::PathBuf;

use super::case::{Case, run_case, run_cases};
use super::provenance::read_job;
use crate::error::{Error, Result, Shown};
use crate::io::check_writable;
use crate::io::stem;
use crate::run::Run;

/// All that describes one batch; also the flags of the command line.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct BatchJob {
    /// Job files (TOML) of `reshape`; each is a case named by its file
    #[cfg_attr(feature = "cli", arg(value_name = "JOB.toml", required = true))]
    pub cases: Vec<PathBuf>,
    /// Folder for the results: a folder per case, index.html, table.csv, statistics/
    #[cfg_attr(feature = "cli", arg(short, long, value_name = "FOLDER"))]
    pub out: PathBuf,
    /// Cases worked on at once
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = 1))]
    pub jobs: usize,
    /// Work on the cases only; write no table, page and statistics
    #[cfg_attr(feature = "cli", arg(long))]
    pub no_summary: bool,
}

/// Runs all cases into `job.out`. A case that fails does not stop the others; one that an earlier
/// batch finished with the same version, options and inputs is kept. A cancelled batch keeps what is
/// finished and gives [`Error::Cancelled`].
pub fn run_batch(job: &BatchJob, run: &Run) -> Result<Vec<Case>> {
    let names = names(&job.cases)?;
    check_writable(&job.out.join("index.html"))?;
    let tell = |done: usize| {
        let stage = format!("{done} of {} cases done", names.len());
        run.enter(&stage, done as f64 / names.len() as f64);
    };
    let found = run_cases(names.len(), job.jobs, run, tell, |k, own| {
        let path = &job.cases[k];
        run_case(&names[k], path, read_job(path), &job.out.join(&names[k]), own)
    });
    if run.is_cancelled() {
        return Err(Error::Cancelled);
    }
    let cases =
        found.into_iter().map(|c| c.ok_or(Error::Cancelled)?).collect::<Result<Vec<_>>>()?;
    if !job.no_summary {
        super::batch_summary::write(&job.out, &cases)?;
    }
    Ok(cases)
}

/// Names of the cases: those of their files without extension.
fn names(cases: &[PathBuf]) -> Result<Vec<String>> {
    if cases.is_empty() {
        return Err(Error::invalid("no job file is given"));
    }
    let names: Vec<String> = cases.iter().map(|path| stem(path)).collect();
    for (k, name) in names.iter().enumerate() {
        if let Some(other) = names[..k].iter().position(|n| n == name) {
            return Err(Error::invalid(format!(
                "{} and {} would share the folder '{name}'; rename one",
                cases[other].shown(),
                cases[k].shown()
            )));
        }
    }
    Ok(names)
}
