//! `report.html` and `report.json` of a registration.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use base64::Engine;
use serde::Serialize;

use super::bone_landmarks::BoneLandmarks;
use super::skeleton_files::SkeletonFiles;
use super::spec::RegisterJob;
use crate::error::{Error, Result};
use crate::io::markup::escaped;
use crate::io::write_beside;
use crate::job::report::picture::{Colour, View, draw};
use crate::mesh::TriMesh;
use crate::register::summary::{BoneSummary, JointSummary, LevelTrace};
use crate::register::{Landmark, Registered, Skeleton, Verdict};

/// Colours of neighbouring bones.
const PALETTE: [Colour; 6] = [
    [0.90, 0.86, 0.74],
    [0.55, 0.75, 0.92],
    [0.95, 0.70, 0.55],
    [0.65, 0.85, 0.60],
    [0.85, 0.65, 0.85],
    [0.80, 0.80, 0.80],
];

/// Colours of doubtful and failed bones.
const DOUBTFUL: Colour = [0.95, 0.65, 0.10];
const FAILED: Colour = [0.80, 0.10, 0.10];

/// Bones and joints that are named in the warnings; all stand in the tables.
const WORST: usize = 5;
/// Joints that turn further beyond their limits are named, degrees.
const BEYOND_DEGREES: f64 = 0.5;

/// What to look at in a result, in sentences: the worst bones and joints; all others have their
/// reasons in [`Registered::bones`].
pub fn warnings(template: &Skeleton, found: &Registered) -> Vec<String> {
    let mut warnings = found.notes.clone();
    warnings.extend(found.judgement.reasons.iter().cloned());
    let mut named: Vec<&BoneSummary> =
        found.bones.iter().filter(|b| b.verdict > Verdict::Good).collect();
    named.sort_by_key(|bone| std::cmp::Reverse(bone.verdict));
    for bone in named.iter().take(WORST) {
        let (verdict, worst) = (bone.verdict.name(), bone.reasons.first());
        let worst = worst.map_or("", String::as_str);
        warnings.push(format!("bone {} is {verdict}: {worst}", bone.name));
    }
    let beyond = found.joints.iter().filter(|joint| joint.excess_degrees > BEYOND_DEGREES);
    let beyond = beyond.map(|joint| (joint.excess_degrees, joint.name.as_str()));
    if let Some(worst) = worst_joints(beyond, 1) {
        warnings.push(format!(
            "joints turn beyond the template's limits, by degrees: {worst}; see whether this person can do that"
        ));
    }
    let apart = found.joints.iter().zip(&template.joints);
    let apart = apart.filter(|(joint, template)| joint.seam > 2.0 * template.limits.shift);
    let apart = apart.map(|(joint, _)| (joint.seam, joint.name.as_str()));
    if let Some(worst) = worst_joints(apart, 2) {
        warnings.push(format!(
            "the two bones disagree on the centre by more than twice the allowed shift in {worst}"
        ));
    }
    warnings
}

/// The joints with the largest figures, which are written with so many digits; none of none.
fn worst_joints<'a>(joints: impl Iterator<Item = (f64, &'a str)>, digits: usize) -> Option<String> {
    let mut joints: Vec<(f64, &str)> = joints.collect();
    joints.sort_by(|a, b| b.0.total_cmp(&a.0));
    let more = joints.len().saturating_sub(WORST);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let worst: Vec<String> = joints
        .iter()
        .take(WORST)
        .map(|(figure, name)| format!("{name} ({figure:.digits$})"))
        .collect();
    (!worst.is_empty()).then(|| format!("{}{more}", worst.join(", ")))
}

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
            warnings: warnings(&files.skeleton, found),
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

    pub(crate) fn write(
        &self,
        folder: &Path,
        template: &Skeleton,
        found: &Registered,
    ) -> Result<()> {
        let json = serde_json::to_string_pretty(self)
            .map_err(|e| Error::invalid(format!("the report cannot be written as JSON: {e}")))?;
        write_beside(&folder.join("report.json"), |out| out.write_all(json.as_bytes()))?;
        let page = self.page(template, found);
        write_beside(&folder.join("report.html"), |out| out.write_all(page.as_bytes()))
    }

    fn verdict_colours(&self, skeleton: &Skeleton) -> Vec<Colour> {
        let colour = |bone: &u32| match self.bones[*bone as usize].verdict {
            Verdict::Good => PALETTE[0],
            Verdict::Doubtful => DOUBTFUL,
            Verdict::Failed => FAILED,
        };
        skeleton.bone_of_vertex().iter().map(colour).collect()
    }

    fn page(&self, template: &Skeleton, found: &Registered) -> String {
        let mut html = String::from(
            "<!doctype html><meta charset=\"utf-8\"><title>Registration</title>\
             <style>body{font:15px sans-serif;margin:2em;max-width:70em}td,th{padding:.1em .8em;\
             text-align:right;vertical-align:top}td:first-child,th:first-child,.words{text-align:left}\
             img{margin:.3em}.warn{color:#a40}.good{color:#272}.doubtful{color:#b60}\
             .failed{color:#b00}</style><h1>Registration</h1>",
        );
        // Writing to a string cannot fail.
        let _ = write!(
            html,
            "<h2 class=\"{}\">{}</h2><p>{} bones, {} joints; {} iterations in {:.2} s; mean residual {:.3}.</p>",
            self.verdict.name(),
            escaped(&self.headline()),
            self.bones.len(),
            self.joints.len(),
            self.iterations,
            self.seconds,
            self.mean_residual()
        );
        for warning in &self.warnings {
            let _ = write!(html, "<p class=\"warn\">{}</p>", escaped(warning));
        }
        let pictures = [
            ("Template", template, palette(template)),
            ("Person", &found.skeleton, palette(&found.skeleton)),
            ("Verdict", &found.skeleton, self.verdict_colours(&found.skeleton)),
        ];
        for (title, skeleton, colours) in pictures {
            let _ = write!(html, "<h2>{title}</h2>");
            if title == "Verdict" {
                html.push_str("<p>Pale: good. Orange: doubtful. Red: failed.</p>");
            }
            for view in [View::Front, View::Side] {
                let png = picture(skeleton, &colours, view);
                let png = base64::engine::general_purpose::STANDARD.encode(png);
                let _ = write!(html, "<img alt=\"{title}\" src=\"data:image/png;base64,{png}\">");
            }
        }
        html.push_str(
            "<h2>Bones</h2><table><tr><th>bone<th>verdict<th>mean residual<th>largest<th>seen %\
             <th>deepest inside another bone<th class=\"words\">why</tr>",
        );
        for b in &self.bones {
            let _ = write!(
                html,
                "<tr><td>{}<td class=\"{1}\">{1}<td>{2:.3}<td>{3:.3}<td>{4:.0}<td>{5}<td class=\"words\">{6}</tr>",
                escaped(&b.name),
                b.verdict.name(),
                b.mean_residual,
                b.max_residual,
                100.0 * b.seen,
                b.penetrates.as_ref().map_or_else(String::new, |other| {
                    format!("{:.2} in {}", b.penetration, escaped(other))
                }),
                escaped(&b.reasons.join("; "))
            );
        }
        html.push_str(
            "</table><h2>Joints</h2><table><tr><th>joint<th>rotation, degrees<th>share of range\
             <th>data go beyond, degrees<th>centre<th>centres apart</tr>",
        );
        for j in &self.joints {
            let r = j.rotation.map(f64::to_degrees);
            let _ = write!(
                html,
                "<tr><td>{}<td>{:.1} {:.1} {:.1}<td>{:.2}<td>{:.1}<td>{:.2} {:.2} {:.2}<td>{:.2}</tr>",
                escaped(&j.name),
                r.x,
                r.y,
                r.z,
                j.usage,
                j.wanted_excess_degrees,
                j.centre.x,
                j.centre.y,
                j.centre.z,
                j.seam
            );
        }
        html.push_str("</table>");
        self.landmark_table(&mut html);
        html
    }

    fn landmark_table(&self, html: &mut String) {
        if self.landmarks.is_empty() {
            return;
        }
        html.push_str(
            "<h2>Landmarks</h2><table><tr><th>landmark<th class=\"words\">bone<th>ends off by</tr>",
        );
        for l in &self.landmarks {
            let (name, bone) = (escaped(&l.name), escaped(&l.bone));
            let _ =
                write!(html, "<tr><td>{name}<td class=\"words\">{bone}<td>{:.3}</tr>", l.distance);
        }
        html.push_str("</table>");
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

/// A colour for each vertex, by its bone.
fn palette(skeleton: &Skeleton) -> Vec<Colour> {
    skeleton.bone_of_vertex().iter().map(|&b| PALETTE[b as usize % PALETTE.len()]).collect()
}

fn picture(skeleton: &Skeleton, colours: &[Colour], view: View) -> Vec<u8> {
    let mesh = TriMesh { points: skeleton.points.clone(), triangles: skeleton.triangles.clone() };
    draw(&mesh, colours, &[], &mesh.points, view)
}
