//! What a job with many objects came to.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::case::{Case, Status};
use crate::error::{Error, Result};
use crate::io::read_bytes;
use crate::job::report::stages::Stage;
use crate::job::reshape::report::Change;
use crate::job::separate::SeparationReport;
use crate::measure::Spread;

/// One object's reshaping. Lengths in the templates' unit.
#[derive(Clone, Debug, Serialize)]
pub struct ObjectLine {
    /// Its name.
    pub name: String,
    /// How it ended; None if the run was cancelled before.
    pub status: Option<Status>,
    /// It was done by an earlier run.
    pub kept: bool,
    /// Why it ended so, in words; the error if it failed.
    pub message: String,
    /// Figures of its own report, if it has a result.
    #[serde(flatten)]
    pub figures: Option<Figures>,
    /// Its surface in the person's shape, after the separation if there was one; relative to the
    /// folder of the results.
    pub surface: Option<PathBuf>,
    /// Seconds it took.
    pub seconds: f64,
}

/// What an object's own report says.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Figures {
    /// Markers.
    pub markers: usize,
    /// Distance of the markers before and after reshaping, before separation.
    pub marker_distance: Change<Spread>,
    /// Tets.
    pub tets: usize,
    /// Tets without or with negative volume.
    pub inverted_tets: usize,
    /// What the user should know, one sentence each.
    pub warnings: Vec<String>,
    /// Attachments.
    pub attachments: Vec<Attached>,
}

/// One attachment.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Attached {
    /// Distance to its target after reshaping.
    pub after: f64,
}

/// Everything about one anatomy. Lengths in the templates' unit.
#[derive(Clone, Debug, Serialize)]
pub struct AnatomyReport {
    /// Version of moulage.
    pub version: &'static str,
    /// The run was cancelled; what was ready then is kept.
    pub interrupted: bool,
    /// Names of the bones.
    pub bones: Vec<String>,
    /// Every object.
    pub objects: Vec<ObjectLine>,
    /// What the separation did; None where it was left out or failed.
    pub separation: Option<SeparationReport>,
    /// What the user should know, one sentence each.
    pub warnings: Vec<String>,
    /// Seconds of each stage.
    pub stages: Vec<Stage>,
    /// Files written.
    pub written: Vec<PathBuf>,
}

impl AnatomyReport {
    /// Nothing is separated yet.
    pub(crate) fn new(bones: Vec<String>, objects: Vec<ObjectLine>) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            interrupted: false,
            bones,
            objects,
            separation: None,
            warnings: Vec::new(),
            stages: Vec::new(),
            written: Vec::new(),
        }
    }

    /// How many objects ended so.
    pub fn count(&self, status: Status) -> usize {
        self.objects.iter().filter(|o| o.status == Some(status)).count()
    }

    /// Whether every object was solved and nothing overlaps that should not.
    pub fn is_good(&self) -> bool {
        !self.interrupted
            && self.warnings.is_empty()
            && self.count(Status::Good) == self.objects.len()
            && self.separation.as_ref().is_none_or(|s| s.summary.separated)
    }
}

impl ObjectLine {
    /// An object that the run did not come to.
    pub(crate) fn not_done(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            status: None,
            kept: false,
            message: "The run was stopped before it was done.".to_owned(),
            figures: None,
            surface: None,
            seconds: 0.0,
        }
    }

    /// The figures of a case whose results are in `folder`.
    pub(crate) fn new(case: &Case, folder: &Path) -> Result<Self> {
        let record = &case.record;
        let has_result = record.status != Status::Failed;
        let figures = has_result.then(|| read_figures(&folder.join("report/report.json")));
        let here = Path::new("objects").join(&record.name);
        Ok(Self {
            name: record.name.clone(),
            status: Some(record.status),
            kept: case.kept,
            message: record.message.clone(),
            figures: figures.transpose()?,
            surface: record.surfaces.first().filter(|_| has_result).map(|s| here.join(s)),
            seconds: record.seconds,
        })
    }
}

fn read_figures(path: &Path) -> Result<Figures> {
    serde_json::from_slice(&read_bytes(path)?).map_err(|e| {
        Error::parse(
            path,
            None,
            format!("this is not the report of a reshaping ({e}); delete its folder"),
        )
    })
}
