//! One case of many: it is worked on unless an earlier run left the same result.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::provenance::{InputFile, hash, inputs};
use crate::error::{Error, Result};
use crate::io::{read_bytes, write_json};
use crate::job::reshape::report::Ending;
use crate::job::reshape::run::run_reshape;
use crate::job::reshape::spec::ReshapeJob;
use crate::run::Run;

/// How often the run is looked after.
const INTERVAL: Duration = Duration::from_millis(50);
/// The file that tells what a case's folder holds.
const RECORD: &str = "provenance.json";

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

impl Status {
    /// Its name: good, doubtful, failed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Doubtful => "doubtful",
            Self::Failed => "failed",
        }
    }
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

/// One finished case.
#[derive(Clone, Debug)]
pub struct Case {
    /// What its folder holds.
    pub record: CaseRecord,
    /// It was done by an earlier run.
    pub kept: bool,
}

impl CaseRecord {
    /// Nothing is known yet.
    pub(crate) fn new(name: &str, job: &Path) -> Self {
        Self {
            name: name.to_owned(),
            job: job.to_path_buf(),
            status: Status::Failed,
            message: String::new(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            key: String::new(),
            options: String::new(),
            inputs: Vec::new(),
            figures: BTreeMap::new(),
            surfaces: Vec::new(),
            seconds: 0.0,
        }
    }

    /// Sets what the result depends on, besides the version.
    pub(crate) fn depends_on(&mut self, options: String, inputs: Vec<InputFile>) {
        let hashes: Vec<&str> = inputs.iter().map(|i| i.sha256.as_str()).collect();
        let all = format!("{}\n{options}\n{}", self.version, hashes.join("\n"));
        self.key = hash(all.as_bytes());
        (self.options, self.inputs) = (options, inputs);
    }

    /// Writes it into the case's folder.
    pub(crate) fn write(&self, folder: &Path) -> Result<()> {
        write_json(&folder.join(RECORD), self)
    }
}

/// Works on `count` cases, `at_once` at a time; each has a run of its own that is cancelled with
/// `run`. `tell` is told how many are done. What was not worked on is None.
pub(crate) fn run_cases(
    count: usize,
    at_once: usize,
    run: &Run,
    tell: impl Fn(usize),
    work: impl Fn(usize, &Run) -> Result<Case> + Sync,
) -> Vec<Option<Result<Case>>> {
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let slots: Vec<Mutex<Option<Result<Case>>>> = (0..count).map(|_| Mutex::new(None)).collect();
    let runs: Vec<Run> = (0..count).map(|_| Run::new()).collect();
    let worker = || {
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            if k >= count || run.is_cancelled() {
                return;
            }
            let case = work(k, &runs[k]);
            *slots[k].lock().unwrap_or_else(PoisonError::into_inner) = Some(case);
            done.fetch_add(1, Ordering::Relaxed);
        }
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> =
            (0..at_once.clamp(1, count.max(1))).map(|_| scope.spawn(worker)).collect();
        while workers.iter().any(|worker| !worker.is_finished()) {
            if run.is_cancelled() {
                runs.iter().for_each(Run::cancel);
            }
            tell(done.load(Ordering::Relaxed));
            std::thread::sleep(INTERVAL);
        }
    });
    slots.into_iter().map(|s| s.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// Keeps or works on one case, given as its job and the text that stands for its options; only a
/// folder that cannot be written is an error.
pub(crate) fn run_case(
    name: &str,
    path: &Path,
    job: Result<(ReshapeJob, String)>,
    folder: &Path,
    run: &Run,
) -> Result<Case> {
    let started = Instant::now();
    let mut record = CaseRecord::new(name, path);
    let prepared = job.and_then(|(job, text)| Ok((inputs(&job)?, job, text)));
    let outcome = prepared.and_then(|(inputs, job, text)| {
        record.depends_on(text, inputs);
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
    record.write(folder)?;
    Ok(Case { record, kept: false })
}

/// What an earlier run left, if it has a result of the same key.
pub(crate) fn earlier(folder: &Path, key: &str) -> Option<CaseRecord> {
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
