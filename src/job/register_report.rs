//! `report.html` and `report.json` of a registration.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use base64::Engine;
use serde::Serialize;

use super::register_job::{RegisterJob, SkeletonFiles};
use super::report::picture::{Colour, View, draw};
use crate::error::{Error, Result};
use crate::io::markup::escaped;
use crate::io::write_beside;
use crate::mesh::TriMesh;
use crate::register::summary::{BoneSummary, JointSummary, LevelTrace};
use crate::register::{Registered, Skeleton};

/// Colours of neighbouring bones.
const PALETTE: [Colour; 6] = [
    [0.90, 0.86, 0.74],
    [0.55, 0.75, 0.92],
    [0.95, 0.70, 0.55],
    [0.65, 0.85, 0.60],
    [0.85, 0.65, 0.85],
    [0.80, 0.80, 0.80],
];

/// What to look at in a result, in sentences.
pub fn warnings(template: &Skeleton, found: &Registered) -> Vec<String> {
    let mut warnings = Vec::new();
    for bone in &found.bones {
        if bone.suspicious {
            warnings.push(format!(
                "bone {} fits much worse than the others ({:.3}); it may lie on its neighbour's surface",
                bone.name, bone.mean_residual
            ));
        }
        if bone.seen < 0.3 {
            warnings.push(format!(
                "bone {} is seen by the target only on {:.0} % of its surface",
                bone.name,
                100.0 * bone.seen
            ));
        }
    }
    let apart: Vec<&str> = found
        .joints
        .iter()
        .zip(&template.joints)
        .filter(|(joint, template)| joint.seam > 2.0 * template.limits.shift)
        .map(|(joint, _)| joint.name.as_str())
        .collect();
    if !apart.is_empty() {
        warnings.push(format!(
            "the two bones disagree on the centre by more than twice the allowed shift in {}",
            apart.join(", ")
        ));
    }
    warnings
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
    /// The levels.
    pub levels: Vec<LevelTrace>,
    /// What to look at.
    pub warnings: Vec<String>,
    /// Files written.
    pub written: Vec<PathBuf>,
}

impl RegisterReport {
    pub(super) fn new(
        job: &RegisterJob,
        files: &SkeletonFiles,
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
            prepare_seconds,
            seconds,
            iterations: found.iterations(),
            cancelled: found.cancelled,
            bones: found.bones.clone(),
            joints: found.joints.clone(),
            levels: found.levels.clone(),
            warnings: warnings(&files.skeleton, found),
            written: Vec::new(),
        }
    }

    /// Mean residual of all bones, weighted equally.
    pub fn mean_residual(&self) -> f64 {
        self.bones.iter().map(|b| b.mean_residual).sum::<f64>() / self.bones.len().max(1) as f64
    }

    pub(super) fn write(
        &self,
        folder: &Path,
        template: &Skeleton,
        found: &Registered,
    ) -> Result<()> {
        let json = serde_json::to_string_pretty(self)
            .map_err(|e| Error::invalid(format!("the report cannot be written as JSON: {e}")))?;
        write_beside(&folder.join("report.json"), |out| out.write_all(json.as_bytes()))?;
        let page = self.page(template, &found.skeleton);
        write_beside(&folder.join("report.html"), |out| out.write_all(page.as_bytes()))
    }

    fn page(&self, template: &Skeleton, found: &Skeleton) -> String {
        let mut html = String::from(
            "<!doctype html><meta charset=\"utf-8\"><title>Registration</title>\
             <style>body{font:15px sans-serif;margin:2em;max-width:70em}td,th{padding:.1em .8em;\
             text-align:right}td:first-child,th:first-child{text-align:left}img{margin:.3em}\
             .warn{color:#a40}</style><h1>Registration</h1>",
        );
        // Writing to a string cannot fail.
        let _ = write!(
            html,
            "<p>{} bones, {} joints; {} iterations in {:.2} s; mean residual {:.3}.</p>",
            self.bones.len(),
            self.joints.len(),
            self.iterations,
            self.seconds,
            self.mean_residual()
        );
        for warning in &self.warnings {
            let _ = write!(html, "<p class=\"warn\">{}</p>", escaped(warning));
        }
        for (title, skeleton) in [("Template", template), ("Person", found)] {
            let _ = write!(html, "<h2>{title}</h2>");
            for view in [View::Front, View::Side] {
                let png = base64::engine::general_purpose::STANDARD.encode(picture(skeleton, view));
                let _ = write!(html, "<img alt=\"{title}\" src=\"data:image/png;base64,{png}\">");
            }
        }
        html.push_str(
            "<h2>Bones</h2><table><tr><th>bone<th>mean residual<th>largest<th>seen %\
             <th>deepest inside another bone</tr>",
        );
        for b in &self.bones {
            let _ = write!(
                html,
                "<tr><td>{}<td>{:.3}<td>{:.3}<td>{:.0}<td>{}</tr>",
                escaped(&b.name),
                b.mean_residual,
                b.max_residual,
                100.0 * b.seen,
                b.penetrates.as_ref().map_or_else(String::new, |other| {
                    format!("{:.2} in {}", b.penetration, escaped(other))
                })
            );
        }
        html.push_str(
            "</table><h2>Joints</h2><table><tr><th>joint<th>rotation, degrees<th>share of range\
             <th>centre<th>centres apart</tr>",
        );
        for j in &self.joints {
            let r = j.rotation.map(f64::to_degrees);
            let _ = write!(
                html,
                "<tr><td>{}<td>{:.1} {:.1} {:.1}<td>{:.2}<td>{:.2} {:.2} {:.2}<td>{:.2}</tr>",
                escaped(&j.name),
                r.x,
                r.y,
                r.z,
                j.usage,
                j.centre.x,
                j.centre.y,
                j.centre.z,
                j.seam
            );
        }
        html.push_str("</table>");
        html
    }
}

fn picture(skeleton: &Skeleton, view: View) -> Vec<u8> {
    let bone_of = skeleton.bone_of_vertex();
    let colours: Vec<Colour> =
        bone_of.iter().map(|&b| PALETTE[b as usize % PALETTE.len()]).collect();
    let mesh = TriMesh { points: skeleton.points.clone(), triangles: skeleton.triangles.clone() };
    draw(&mesh, &colours, &[], &mesh.points, view)
}
