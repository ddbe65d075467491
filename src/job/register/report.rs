//! `report.html` and `report.json` of a registration.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::bone_landmarks::BoneLandmarks;
use super::pictures::pictures;
use super::skeleton_files::SkeletonFiles;
use super::spec::RegisterJob;
use crate::error::Result;
use crate::io::markup::escaped;
use crate::job::report::files::write_report;
use crate::job::report::html::{self, Column, marked, notes, table};
use crate::register::summary::{BoneSummary, JointSummary, LevelTrace};
use crate::register::{Landmark, Registered, Skeleton, Target, Verdict};

/// A landmark and its distance from its place at the end.
#[derive(Clone, Debug, Serialize)]
pub struct LandmarkSummary {
    /// Name.
    pub name: String,
    /// Its bone.
    pub bone: String,
    /// Distance, template unit.
    pub distance: f64,
}

/// All figures of a registration.
#[derive(Clone, Debug, Serialize)]
pub struct RegisterReport {
    /// Version of this program.
    pub version: &'static str,
    /// The template.
    pub skeleton: PathBuf,
    /// The target surface or folder.
    pub target: PathBuf,
    /// How far the result can be trusted.
    pub verdict: Verdict,
    /// Why it is not good.
    pub reasons: Vec<String>,
    /// Seconds for preparing the template.
    pub prepare_seconds: f64,
    /// Seconds for the registration.
    pub seconds: f64,
    /// Closest-point iterations.
    pub iterations: usize,
    /// Stopped on request.
    pub cancelled: bool,
    /// The bones.
    pub bones: Vec<BoneSummary>,
    /// The joints.
    pub joints: Vec<JointSummary>,
    /// The landmarks.
    pub landmarks: Vec<LandmarkSummary>,
    /// The levels.
    pub levels: Vec<LevelTrace>,
    /// What to look at.
    pub warnings: Vec<String>,
    /// Files written.
    pub written: Vec<PathBuf>,
}

impl RegisterReport {
    pub(crate) fn new(
        job: &RegisterJob,
        files: &SkeletonFiles,
        landmarks: &BoneLandmarks,
        found: &Registered,
        [prepare_seconds, seconds]: [f64; 2],
    ) -> Self {
        let target = job
            .target
            .as_ref()
            .or(job.labels.as_ref())
            .or(job.volume.as_ref())
            .cloned()
            .unwrap_or_default();
        Self {
            version: env!("CARGO_PKG_VERSION"),
            skeleton: job.skeleton.clone(),
            target,
            verdict: found.judgement.verdict,
            reasons: found.judgement.reasons.clone(),
            prepare_seconds,
            seconds,
            iterations: found.iterations(),
            cancelled: found.cancelled,
            bones: found.bones.clone(),
            joints: found.joints.clone(),
            landmarks: landmark_summaries(landmarks, &files.skeleton, &found.landmarks),
            levels: found.levels.clone(),
            warnings: found.warnings(&files.skeleton),
            written: Vec::new(),
        }
    }

    /// Mean residual of all bones, weighted equally.
    pub fn mean_residual(&self) -> f64 {
        self.bones.iter().map(|b| b.mean_residual).sum::<f64>() / self.bones.len().max(1) as f64
    }

    /// The verdict in a line.
    pub fn headline(&self) -> String {
        let named = |verdict| self.bones.iter().filter(|b| b.verdict == verdict).count();
        format!(
            "verdict: {} ({} bones good, {} doubtful, {} failed)",
            self.verdict.name(),
            named(Verdict::Good),
            named(Verdict::Doubtful),
            named(Verdict::Failed)
        )
    }

    /// `distances`: of the person's vertices to the target.
    pub(crate) fn write(
        &self,
        folder: &Path,
        template: &Skeleton,
        target: &Target,
        distances: &[f64],
        found: &Registered,
    ) -> Result<()> {
        write_report(folder, self, &self.page(&pictures(template, target, distances, found)))
    }

    fn page(&self, pictures: &str) -> String {
        let head = format!(
            "<h1>Registration</h1>\n<h2 class=\"{}\">{}</h2>\n\
             <p>{} bones, {} joints; {} iterations in {:.2} s; mean residual {:.3}.</p>\n",
            self.verdict.name(),
            escaped(&self.headline()),
            self.bones.len(),
            self.joints.len(),
            self.iterations,
            self.seconds,
            self.mean_residual()
        );
        let body = [
            head,
            notes(&self.warnings),
            pictures.to_owned(),
            format!("<h2>Bones</h2>\n{}<h2>Joints</h2>\n{}", self.bone_table(), self.joint_table()),
            self.landmark_table(),
        ];
        html::page("registration", "the template's", &body.concat())
    }

    fn bone_table(&self) -> String {
        let columns = [
            Column::Text("bone"),
            Column::Text("verdict"),
            Column::Number("mean residual"),
            Column::Number("largest"),
            Column::Number("seen %"),
            Column::Number("deepest inside another bone"),
            Column::Text("why"),
        ];
        let row = |b: &BoneSummary| {
            let inside = b.penetrates.as_ref().map_or_else(String::new, |other| {
                format!("{:.2} in {}", b.penetration, escaped(other))
            });
            vec![
                escaped(&b.name),
                marked(b.verdict.name(), b.verdict.name()),
                format!("{:.3}", b.mean_residual),
                format!("{:.3}", b.max_residual),
                format!("{:.0}", 100.0 * b.seen),
                inside,
                escaped(&b.reasons.join("; ")),
            ]
        };
        table(&columns, self.bones.iter().map(row))
    }

    fn joint_table(&self) -> String {
        let columns = [
            Column::Text("joint"),
            Column::Number("rotation, degrees"),
            Column::Number("share of range"),
            Column::Number("data go beyond, degrees"),
            Column::Number("centre"),
            Column::Number("centres apart"),
        ];
        let row = |j: &JointSummary| {
            let (r, c) = (j.rotation.map(f64::to_degrees), j.centre);
            vec![
                escaped(&j.name),
                format!("{:.1} {:.1} {:.1}", r.x, r.y, r.z),
                format!("{:.2}", j.usage),
                format!("{:.1}", j.wanted_excess_degrees),
                format!("{:.2} {:.2} {:.2}", c.x, c.y, c.z),
                format!("{:.2}", j.seam),
            ]
        };
        table(&columns, self.joints.iter().map(row))
    }

    fn landmark_table(&self) -> String {
        if self.landmarks.is_empty() {
            return String::new();
        }
        let columns =
            [Column::Text("landmark"), Column::Text("bone"), Column::Number("ends off by")];
        let row = |l: &LandmarkSummary| {
            vec![escaped(&l.name), escaped(&l.bone), format!("{:.3}", l.distance)]
        };
        format!("<h2>Landmarks</h2>\n{}", table(&columns, self.landmarks.iter().map(row)))
    }
}

fn landmark_summaries(
    landmarks: &BoneLandmarks,
    skeleton: &Skeleton,
    distances: &[f64],
) -> Vec<LandmarkSummary> {
    let named = landmarks.names.iter().zip(&landmarks.landmarks).zip(distances);
    let summary = |((name, landmark), distance): ((&String, &Landmark), &f64)| {
        let bone = skeleton.bones[landmark.bone].name.clone();
        LandmarkSummary { name: name.clone(), bone, distance: *distance }
    };
    named.map(summary).collect()
}
