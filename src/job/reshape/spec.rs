//! A reshaping described as data: the keys of a job file, which are also the command line's flags.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize};

use crate::align::Freedom;
use crate::error::Result;
use crate::io::read_text;
use crate::job::job_file::parse_job_file;

/// Whether the template is moved as a whole before it is reshaped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum Align {
    /// It already lies where the person is.
    #[default]
    None,
    /// Rotation and shift: from three or more landmarks, else from the markers.
    Rigid,
    /// Rotation, shift and one scale.
    Similarity,
}

impl Align {
    /// What the move may change; none: nothing is moved.
    pub fn freedom(self) -> Option<Freedom> {
        match self {
            Self::None => None,
            Self::Rigid => Some(Freedom::Rigid),
            Self::Similarity => Some(Freedom::Similarity),
        }
    }
}

/// What an attachment file with bone points asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum Gap {
    /// The template's point keeps its offset from the bone, turned as the bone is turned.
    #[default]
    Keep,
    /// The template's point goes to the bone's point itself.
    Close,
}

/// All that describes one reshaping. What is `None` takes its default. Lengths are in the
/// template's unit. In a job file, paths are relative to the file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
#[serde(default, deny_unknown_fields)]
pub struct ReshapeJob {
    /// Surface to reshape: .obj, .ply or .stl
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Input"))]
    pub template: Option<PathBuf>,
    /// Points on the person's surface: .csv, .xyz, .ply, .mrk.json, .fcsv or .pp
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1.., help_heading = "Input"))]
    #[serde(deserialize_with = "one_or_many")]
    pub markers: Option<Vec<PathBuf>>,
    /// Paired points: one .csv, or two marker files (template, person) paired by label
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1..=2, help_heading = "Input"))]
    #[serde(deserialize_with = "one_or_many")]
    pub landmarks: Option<Vec<PathBuf>>,
    /// Attachments: .csv pairs, or surfaces of the bones (see --attachment-distance)
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1.., help_heading = "Input"))]
    #[serde(deserialize_with = "one_or_many")]
    pub attachments: Option<Vec<PathBuf>>,
    /// Bone vertices within this distance of the template are attached to it
    #[cfg_attr(feature = "cli", arg(long, value_name = "LENGTH", help_heading = "Input"))]
    pub attachment_distance: Option<f64>,
    /// The person's bones, same vertices as the bones of --attachments [default: those]
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1.., help_heading = "Input"))]
    #[serde(deserialize_with = "one_or_many")]
    pub attachment_targets: Option<Vec<PathBuf>>,
    /// Where an attachment file names bone points: keep the template's gap to them, or close it
    #[cfg_attr(feature = "cli", arg(long, value_enum, help_heading = "Input"))]
    pub attachment_gap: Option<Gap>,
    /// Template points that stay where they are: .csv with vertex, or x, y, z
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Input"))]
    pub fixed: Option<PathBuf>,
    /// Move the template as a whole first [default: none]
    #[cfg_attr(feature = "cli", arg(long, value_enum, help_heading = "Input"))]
    pub align: Option<Align>,

    /// Image of the person: the report shows the result on its slices
    #[cfg_attr(feature = "cli", arg(long, value_name = "VOLUME", help_heading = "Image"))]
    pub volume: Option<PathBuf>,
    /// Label map: the report compares the result with a label
    #[cfg_attr(feature = "cli", arg(long, value_name = "VOLUME", help_heading = "Image"))]
    pub label_map: Option<PathBuf>,
    /// The label [default: the only one]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", help_heading = "Image"))]
    pub label: Option<u32>,
    /// Look in the image for the organ's border where no marker is near, and follow it weakly
    #[cfg_attr(feature = "cli", arg(long, num_args = 0..=1, default_missing_value = "true",
        value_name = "BOOL", help_heading = "Image"))]
    pub refine: Option<bool>,

    /// auto, tetgen, lattice, or a file: .node/.ele, .vtu, .veg or .msh [default: auto]
    #[cfg_attr(feature = "cli", arg(long, value_name = "HOW", help_heading = "Tets"))]
    pub tets: Option<PathBuf>,
    /// About how many tets [default: 15000]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", help_heading = "Tets"))]
    pub tet_count: Option<usize>,
    /// The program TetGen [default: $MOULAGE_TETGEN, else the search path]
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Tets"))]
    pub tetgen: Option<PathBuf>,

    /// How far markers may be off: their noise [default: the template's diagonal / 1000]
    #[cfg_attr(feature = "cli", arg(long, value_name = "LENGTH", help_heading = "Solver"))]
    pub tolerance: Option<f64>,
    /// The same for landmarks [default: 5 times the tolerance]
    #[cfg_attr(feature = "cli", arg(long, value_name = "LENGTH", help_heading = "Solver"))]
    pub landmark_tolerance: Option<f64>,
    /// The same for attachments [default: the tolerance]
    #[cfg_attr(feature = "cli", arg(long, value_name = "LENGTH", help_heading = "Solver"))]
    pub attachment_tolerance: Option<f64>,
    /// Meet attachments whatever the markers say
    #[cfg_attr(feature = "cli", arg(long, num_args = 0..=1, default_missing_value = "true",
        value_name = "BOOL", help_heading = "Solver"))]
    pub hard_attachments: Option<bool>,
    /// Use the published formulation (per-tet Fp, graph Laplacian, Woodbury), for comparison
    #[cfg_attr(feature = "cli", arg(long, num_args = 0..=1, default_missing_value = "true",
        value_name = "BOOL", help_heading = "Solver"))]
    pub paper: Option<bool>,
    /// Pull back template points far from every marker, except where the scan was cut [default: true]
    #[cfg_attr(feature = "cli", arg(long, num_args = 0..=1, default_missing_value = "true",
        value_name = "BOOL", help_heading = "Solver"))]
    pub reverse_term: Option<bool>,
    /// Weight of smoothness, dimensionless
    #[cfg_attr(feature = "cli", arg(long, value_name = "X", help_heading = "Solver"))]
    pub smoothness: Option<f64>,
    /// Distance over which strain fades away from data, as a multiple of the template's size
    #[cfg_attr(feature = "cli", arg(long, value_name = "X", help_heading = "Solver"))]
    pub screening: Option<f64>,
    /// Poisson's ratio of the tissue
    #[cfg_attr(feature = "cli", arg(long, value_name = "X", help_heading = "Solver"))]
    pub poisson: Option<f64>,
    /// Iterations allowed
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", help_heading = "Solver"))]
    pub max_iterations: Option<usize>,
    /// Remesh where the tets get too flat to continue, this many times at most; 0: never
    /// [default: 3]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", help_heading = "Solver"))]
    pub remesh: Option<usize>,
    /// Plausible shapes that tell how sure the result is; 0: none [default: 64]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", help_heading = "Solver"))]
    pub samples: Option<usize>,
    /// Threads to use; the result does not depend on it [default: all cores]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", help_heading = "Solver"))]
    pub threads: Option<usize>,

    /// The template in the person's shape: same vertices, faces, texture coordinates and groups
    #[cfg_attr(feature = "cli", arg(short, long, value_name = "FILE", help_heading = "Output"))]
    pub out: Option<PathBuf>,
    /// Other meshes to carry along; each is written beside OUT as OUT_NAME
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1.., help_heading = "Output"))]
    #[serde(deserialize_with = "one_or_many")]
    pub carry: Option<Vec<PathBuf>>,
    /// The deformed tets with plastic strain and principal stretches: .vtu
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Output"))]
    pub tets_out: Option<PathBuf>,
    /// The result with stretch, distance to the markers and standard deviations per vertex: .ply
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Output"))]
    pub ply_out: Option<PathBuf>,
    /// Folder for the plausible shapes
    #[cfg_attr(feature = "cli", arg(long, value_name = "FOLDER", help_heading = "Output"))]
    pub samples_out: Option<PathBuf>,
    /// Folder for report.html, report.json and result.ply
    #[cfg_attr(feature = "cli", arg(long, value_name = "FOLDER", help_heading = "Output"))]
    pub report: Option<PathBuf>,
}

/// A list may be written as one text.
pub(crate) fn one_or_many<'de, D: Deserializer<'de>>(
    value: D,
) -> Result<Option<Vec<PathBuf>>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum OneOrMany {
        One(PathBuf),
        Many(Vec<PathBuf>),
    }
    Ok(Some(match OneOrMany::deserialize(value)? {
        OneOrMany::One(path) => vec![path],
        OneOrMany::Many(paths) => paths,
    }))
}

/// Takes each key from the first job if it is there, else from the second.
macro_rules! first_of {
    ($first:expr, $second:expr, $($key:ident),* $(,)?) => {
        ReshapeJob { $($key: $first.$key.or($second.$key)),* }
    };
}

impl ReshapeJob {
    /// Reads a TOML job file; its paths come back relative to where the file is.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(&read_text(path)?, path)
    }

    /// The same from text; `path` tells where paths start and serves the error sentences.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let job: Self = parse_job_file(text, path)?;
        Ok(job.relative_to(path.parent().unwrap_or(Path::new(""))))
    }

    /// This job with all keys of `flags` that are set.
    #[must_use]
    pub fn overridden_by(self, flags: Self) -> Self {
        first_of!(
            flags,
            self,
            template,
            markers,
            landmarks,
            attachments,
            attachment_distance,
            attachment_targets,
            attachment_gap,
            fixed,
            align,
            volume,
            label_map,
            label,
            refine,
            tets,
            tet_count,
            tetgen,
            tolerance,
            landmark_tolerance,
            attachment_tolerance,
            hard_attachments,
            paper,
            reverse_term,
            smoothness,
            screening,
            poisson,
            max_iterations,
            remesh,
            samples,
            threads,
            out,
            carry,
            tets_out,
            ply_out,
            samples_out,
            report,
        )
    }

    /// The same with paths that start at `folder`.
    pub(crate) fn relative_to(mut self, folder: &Path) -> Self {
        let lists = [
            &mut self.markers,
            &mut self.landmarks,
            &mut self.attachments,
            &mut self.attachment_targets,
            &mut self.carry,
        ];
        let in_lists = lists.into_iter().flatten().flatten();
        let single = [
            &mut self.template,
            &mut self.fixed,
            &mut self.volume,
            &mut self.label_map,
            &mut self.tetgen,
            &mut self.out,
            &mut self.tets_out,
            &mut self.ply_out,
            &mut self.samples_out,
            &mut self.report,
        ];
        for path in in_lists.chain(single.into_iter().flatten()) {
            *path = folder.join(&path);
        }
        // `tets` is a word or a file.
        if let Some(tets) = &mut self.tets
            && tets.extension().is_some()
        {
            *tets = folder.join(&tets);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<ReshapeJob> {
        ReshapeJob::parse(text, Path::new("case/job.toml"))
    }

    #[test]
    fn paths_start_at_the_job_file_and_flags_win() {
        let job = parse(
            "template = 'a.obj'\nmarkers = ['m.csv', '/n.csv']\nlandmarks = 'l.csv'\n\
             tets = 'auto'\ntolerance = 0.3\nalign = 'rigid'\nhard_attachments = true\n",
        )
        .unwrap();
        assert_eq!(job.template.as_deref(), Some(Path::new("case/a.obj")));
        assert_eq!(job.markers, Some(vec!["case/m.csv".into(), "/n.csv".into()]));
        assert_eq!(job.landmarks, Some(vec!["case/l.csv".into()]));
        assert_eq!(job.tets.as_deref(), Some(Path::new("auto")));
        let flags = ReshapeJob {
            tolerance: Some(0.5),
            tets: Some("b.vtu".into()),
            ..ReshapeJob::default()
        };
        let job = job.overridden_by(flags);
        assert_eq!(job.tolerance, Some(0.5));
        assert_eq!(job.tets.as_deref(), Some(Path::new("b.vtu")));
        assert_eq!(job.align, Some(Align::Rigid));
    }

    #[test]
    fn a_job_written_out_reads_back() {
        let job = parse("template = '/a.obj'\nmarkers = '/m.csv'\ntolerance = 0.3\n").unwrap();
        let text = serde_json::to_string(&job).unwrap();
        assert!(serde_json::from_str::<serde_json::Value>(&text).unwrap()["tolerance"] == 0.3);
    }

    #[test]
    fn errors_name_line_and_key() {
        let error = parse("template = 'a.obj'\nmarker = 'm.csv'\n").unwrap_err().to_string();
        assert!(error.starts_with("case/job.toml, line 2: unknown field `marker`"), "{error}");
        assert!(!error.contains('\n'), "{error}");
        let error = parse("tolerance = 'big'\n").unwrap_err().to_string();
        assert!(error.contains("line 1"), "{error}");
        let error = parse("tolerance = \n").unwrap_err().to_string();
        assert!(error.contains("line 1"), "{error}");
    }
}
