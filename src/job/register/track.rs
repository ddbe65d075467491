//! `moulage track`: one person's bones followed through images of other poses.

use std::fmt::Write;
use std::path::PathBuf;

use super::image_target::{Measure, appearance, image_target, relative_reach};
use super::output;
use super::skeleton_files::read_skeleton;
use super::spec::RegisterJob;
use crate::error::{Error, Result};
use crate::io::write_beside;
use crate::register::animation::present_angles;
use crate::register::{Options, Registered, Registration};
use crate::run::Run;

/// All that describes one tracking.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct TrackJob {
    /// The person's own bones, such as the result.skeleton.json of a registration
    #[cfg_attr(feature = "cli", arg(value_name = "SKELETON"))]
    pub skeleton: PathBuf,
    /// Images of other poses in their order; the first pose is near the skeleton's own
    #[cfg_attr(feature = "cli", arg(long, value_name = "VOLUME", num_args = 1.., required = true))]
    pub volume: Vec<PathBuf>,
    /// Image in which the skeleton lies on the bones [default: what the skeleton file names]
    #[cfg_attr(feature = "cli", arg(long, value_name = "VOLUME"))]
    pub reference: Option<PathBuf>,
    /// profiles, or the published moments
    #[cfg_attr(feature = "cli", arg(long, value_enum, default_value_t))]
    pub measure: Measure,
    /// How far to look to each side, at most and at least, mm [default: 8 and 0.5 % of the skeleton's
    /// diagonal]
    #[cfg_attr(feature = "cli", arg(long, value_name = "MM", num_args = 2))]
    pub reach: Option<Vec<f64>>,
    /// Leave the joints out, for comparison: bones fly apart
    #[cfg_attr(feature = "cli", arg(long))]
    pub no_limits: bool,
    /// Folder for the frames: 001/, 002/, ... and angles.csv
    #[cfg_attr(feature = "cli", arg(short, long, value_name = "FOLDER"))]
    pub out: PathBuf,
}

/// One frame of a tracking.
#[derive(Clone, Debug)]
pub struct TrackedFrame {
    /// Its image.
    pub volume: PathBuf,
    /// The pose.
    pub registered: Registered,
    /// Share of the surface that was recognized, 0 to 1.
    pub seen: f64,
}

/// Follows the bones and writes each frame as it is found. A cancelled run keeps the frames it has.
pub fn run_track(job: &TrackJob, run: &Run) -> Result<Vec<TrackedFrame>> {
    run.enter("reading", 0.0);
    let files = read_skeleton(&job.skeleton)?;
    let looks = appearance(&job.skeleton, &files, job.reference.as_deref(), job.measure)?;
    let mut options = Options { use_joints: !job.no_limits, ..Options::tracking() };
    if let Some(reach) = job.reach.as_deref() {
        options.image_reach = relative_reach(reach, &files.skeleton)?;
    }
    let tracker = Registration::new(files.skeleton.clone(), options)?;
    let mut pose = files.skeleton.clone();
    let mut frames: Vec<TrackedFrame> = Vec::new();
    for (k, path) in job.volume.iter().enumerate() {
        let count = job.volume.len();
        run.enter(&format!("image {} of {count}", k + 1), k as f64 / count as f64);
        let (target, _) = image_target(&files.skeleton, path, looks.clone())?;
        let found = tracker.track(&pose, &target, run)?;
        if run.is_cancelled() {
            break;
        }
        let folder = job.out.join(format!("{:03}", k + 1));
        output::write(&folder, &RegisterJob::default(), &files, &found, &[], None)?;
        pose = found.skeleton.clone();
        let seen = found.bones.iter().map(|b| b.seen).sum::<f64>() / found.bones.len() as f64;
        frames.push(TrackedFrame { volume: path.clone(), registered: found, seen });
        let table = angles(&frames);
        write_beside(&job.out.join("angles.csv"), |out| out.write_all(table.as_bytes()))?;
    }
    if frames.is_empty() { Err(Error::Cancelled) } else { Ok(frames) }
}

/// One row per frame: the image, the verdict, the share seen, all named angles in degrees.
fn angles(frames: &[TrackedFrame]) -> String {
    let mut text = String::from("frame,volume,verdict,seen");
    for (name, _) in
        frames.first().map(|f| present_angles(&f.registered.skeleton)).unwrap_or_default()
    {
        let _ = write!(text, ",{name}_deg");
    }
    for (k, frame) in frames.iter().enumerate() {
        let name = frame.volume.file_name().unwrap_or_default().to_string_lossy();
        let verdict = frame.registered.judgement.verdict.name();
        let name = name.replace(',', "_");
        let _ = write!(text, "\n{},{name},{verdict},{:.3}", k + 1, frame.seen);
        for (_, angle) in present_angles(&frame.registered.skeleton) {
            let _ = write!(text, ",{:.4}", angle.to_degrees());
        }
    }
    text.push('\n');
    text
}
