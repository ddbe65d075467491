//! Many jobs, one after the other or several at once; what is done already is not done again.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::output::stem;
use super::provenance::{InputFile, hash, inputs, read_job};
use super::report::Ending;
use super::reshape_job::run_reshape;
use super::spec::ReshapeJob;
use crate::error::{Error, Result};
use crate::io::{check_writable, read_bytes, write_beside};
use crate::run::Run;

/// How often the run is looked after.
const INTERVAL: Duration = Duration::from_millis(50);
/// The file that tells what a case's folder holds.
const RECORD: &str = "provenance.json";

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

/// How a case ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// The solver is satisfied.
    Good,
    /// There is a result, but the solver gave up.
    Doubtful,
    /// There is no result.
    Failed,
}

/// What a case's folder holds and where it comes from.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CaseRecord {
    /// The case's name.
    pub name: String,
    /// Its job file.
    pub job: PathBuf,
    /// How it ended.
    pub status: Status,
    /// What to know about that; the error if it failed.
    pub message: String,
    /// Version of moulage.
    pub version: String,
    /// SHA-256 of version, options and inputs: the same key means the same result.
    pub key: String,
    /// The job file's text.
    pub options: String,
    /// Every file it read.
    pub inputs: Vec<InputFile>,
    /// Figures, by name; lengths in the template's unit.
    pub figures: BTreeMap<String, f64>,
    /// The surfaces it made, relative to its folder.
    pub surfaces: Vec<PathBuf>,
    /// Seconds it took.
    pub seconds: f64,
}

/// One case of a finished batch.
#[derive(Clone, Debug)]
pub struct Case {
    /// What its folder holds.
    pub record: CaseRecord,
    /// It was done by an earlier batch.
    pub kept: bool,
}

/// Runs all cases into `job.out`. A case that fails does not stop the others; one that an earlier
/// batch finished with the same version, options and inputs is kept. A cancelled batch keeps what is
/// finished and gives [`Error::Cancelled`].
pub fn run_batch(job: &BatchJob, run: &Run) -> Result<Vec<Case>> {
    let names = names(&job.cases)?;
    check_writable(&job.out.join("index.html"))?;
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let slots: Vec<Mutex<Option<Result<Case>>>> = names.iter().map(|_| Mutex::new(None)).collect();
    let runs: Vec<Run> = names.iter().map(|_| Run::new()).collect();
    let work = || {
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            if k >= names.len() || run.is_cancelled() {
                return;
            }
            let case = run_case(&names[k], &job.cases[k], &job.out.join(&names[k]), &runs[k]);
            *slots[k].lock().unwrap_or_else(PoisonError::into_inner) = Some(case);
            done.fetch_add(1, Ordering::Relaxed);
        }
    };
    std::thread::scope(|scope| {
        let count = job.jobs.clamp(1, names.len());
        let workers: Vec<_> = (0..count).map(|_| scope.spawn(work)).collect();
        while workers.iter().any(|worker| !worker.is_finished()) {
            if run.is_cancelled() {
                runs.iter().for_each(Run::cancel);
            }
            let finished = done.load(Ordering::Relaxed);
            let stage = format!("{finished} of {} cases done", names.len());
            run.enter(&stage, finished as f64 / names.len() as f64);
            std::thread::sleep(INTERVAL);
        }
    });
    if run.is_cancelled() {
        return Err(Error::Cancelled);
    }
    let mut cases = Vec::new();
    for slot in slots {
        let case = slot.into_inner().unwrap_or_else(PoisonError::into_inner);
        cases.push(case.ok_or(Error::Cancelled)??);
    }
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
                cases[other].display(),
                cases[k].display()
            )));
        }
    }
    Ok(names)
}

/// Keeps or works on one case; only a folder that cannot be written is an error.
fn run_case(name: &str, path: &Path, folder: &Path, run: &Run) -> Result<Case> {
    let started = Instant::now();
    let mut record = CaseRecord {
        name: name.to_owned(),
        job: path.to_path_buf(),
        status: Status::Failed,
        message: String::new(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        key: String::new(),
        options: String::new(),
        inputs: Vec::new(),
        figures: BTreeMap::new(),
        surfaces: Vec::new(),
        seconds: 0.0,
    };
    let prepared = read_job(path).and_then(|(job, text)| Ok((inputs(&job)?, job, text)));
    let outcome = prepared.and_then(|(inputs, job, text)| {
        let hashes: Vec<&str> = inputs.iter().map(|i| i.sha256.as_str()).collect();
        record.key = hash(format!("{}\n{text}\n{}", record.version, hashes.join("\n")).as_bytes());
        (record.options, record.inputs) = (text, inputs);
        match earlier(folder, &record.key) {
            Some(kept) => Ok(Some(kept)),
            None => work(&job, folder, run, &mut record).map(|()| None),
        }
    });
    match outcome {
        Ok(Some(kept)) => return Ok(Case { record: kept, kept: true }),
        Ok(None) => {}
        Err(Error::Cancelled) => return Err(Error::Cancelled),
        Err(error) => record.message = error.to_string(),
    }
    record.seconds = started.elapsed().as_secs_f64();
    // A case stopped halfway must not look finished.
    if run.is_cancelled() {
        return Err(Error::Cancelled);
    }
    write_beside(&folder.join(RECORD), |out| {
        serde_json::to_writer_pretty(&mut *out, &record)?;
        writeln!(out)
    })?;
    Ok(Case { record, kept: false })
}

/// What an earlier batch left, if it has a result of the same key.
fn earlier(folder: &Path, key: &str) -> Option<CaseRecord> {
    let record: CaseRecord =
        serde_json::from_slice(&read_bytes(&folder.join(RECORD)).ok()?).ok()?;
    let whole = record.surfaces.iter().all(|surface| folder.join(surface).is_file());
    (record.key == key && record.status != Status::Failed && whole).then_some(record)
}

/// Runs one job; what cannot be foreseen is caught, so that the other cases go on.
fn work(job: &ReshapeJob, folder: &Path, run: &Run, record: &mut CaseRecord) -> Result<()> {
    let caught = catch_unwind(AssertUnwindSafe(|| reshape_case(job, folder, run, record)));
    caught.unwrap_or_else(|_| {
        Err(Error::Diverged("moulage stopped by a fault of its own; please report the case".into()))
    })
}

fn reshape_case(job: &ReshapeJob, folder: &Path, run: &Run, record: &mut CaseRecord) -> Result<()> {
    let mut job = job.clone();
    let template = job.template.clone().unwrap_or_default();
    let name = format!("result.{}", template.extension().unwrap_or_default().to_string_lossy());
    job.out = Some(folder.join(&name));
    job.tets_out = Some(folder.join("tets.vtu"));
    job.report = Some(folder.join("report"));
    let report = run_reshape(&job, run)?.report;
    record.status = if report.ending == Ending::Good { Status::Good } else { Status::Doubtful };
    record.message.clone_from(&report.why);
    record.surfaces = vec![name.into()];
    let after = report.marker_distance.after;
    record.figures.extend([
        ("marker_mean".to_owned(), after.mean),
        ("marker_p95".to_owned(), after.p95),
        ("marker_max".to_owned(), after.max),
        ("inverted_tets".to_owned(), report.inverted_tets as f64),
        ("volume_ratio".to_owned(), report.volume_ratio),
    ]);
    Ok(())
}
