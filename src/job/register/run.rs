//! One skeleton registration from files to files.

use std::path::Path;
use std::time::Instant;

use super::bone_landmarks::read_bone_landmarks;
use super::image_target::relative_reach;
use super::model_file::read_shape_model;
use super::motion_files::read_motion;
use super::output;
use super::report::RegisterReport;
use super::skeleton_files::{SkeletonFiles, read_skeleton, read_tissue_files};
use super::spec::RegisterJob;
use super::target::read_target;
use crate::error::Result;
use crate::io::skeleton::SkeletonDocument;
use crate::register::options::Levels;
use crate::register::{Options, Registered, Registration, ShapeModel, Skeleton, Target};
use crate::run::Run;
use crate::threads::on_threads;

/// What a finished registration tells its caller.
#[derive(Clone, Debug)]
pub struct RegisterResult {
    /// All figures, also in `report.json`.
    pub report: RegisterReport,
    /// The person's skeleton.
    pub registered: Registered,
}

/// Reads, registers and writes all that `job` names. A cancelled run writes what it has.
pub fn run_register(job: &RegisterJob, run: &Run) -> Result<RegisterResult> {
    on_threads(job.threads, || run_here(job, run))
}

fn run_here(job: &RegisterJob, run: &Run) -> Result<RegisterResult> {
    output::check_places(job)?;
    run.enter("reading", 0.0);
    let files = read_skeleton(&job.skeleton)?;
    let (target, mut notes) = read_target(job, &files)?;
    let landmarks =
        read_bone_landmarks(job.landmarks.as_deref().unwrap_or_default(), &files.skeleton)?;
    let target = target.with_landmarks(&files.skeleton, &landmarks.landmarks)?;
    notes.extend(landmarks.warning.clone());
    let more = job.carry.as_deref().unwrap_or_default();
    let tissues = read_tissue_files(&job.skeleton, &files.document, more)?;
    let flip = job.flip.as_deref().unwrap_or_default();
    let motion = job.motion.as_deref();
    let motion = motion.map(|path| read_motion(path, &files.skeleton, flip)).transpose()?;
    let mut options = options(job, &files.document);
    if let Some(reach) = job.reach.as_deref() {
        options.image_reach = relative_reach(reach, &files.skeleton)?;
    }
    let prepared = Instant::now();
    let mut registration = Registration::new(files.skeleton.clone(), options)?;
    if let Some(model) = shape_model(job, &files)? {
        registration = registration.with_shape_model(model)?;
    }
    let prepared = prepared.elapsed().as_secs_f64();
    let started = Instant::now();
    let registered = registration.register(&target, run)?;
    let seconds = started.elapsed().as_secs_f64();
    let mut report = RegisterReport::new(job, &files, &landmarks, &registered, [prepared, seconds]);
    report.warnings.splice(0..0, notes);
    run.enter("writing", 0.97);
    if let Some(folder) = &job.out {
        let written = output::write(folder, job, &files, &registered, &tissues, motion.as_ref())?;
        report.written = written.files;
        report.warnings.extend(written.notes);
    }
    if job.ply_out.is_some() || job.report.is_some() {
        write_to_look_at(job, &files.skeleton, &target, &registered, &mut report)?;
    }
    run.enter("done", 1.0);
    Ok(RegisterResult { report, registered })
}

/// Writes the bones with what is known at each vertex, and the report.
fn write_to_look_at(
    job: &RegisterJob,
    template: &Skeleton,
    target: &Target,
    found: &Registered,
    report: &mut RegisterReport,
) -> Result<()> {
    let distances = target.distances(&found.skeleton);
    let in_report = job.report.as_ref().map(|folder| folder.join("result.ply"));
    for path in job.ply_out.iter().chain(&in_report) {
        output::write_seen(path, &distances, found)?;
        report.written.push(path.clone());
    }
    if let Some(folder) = &job.report {
        report.write(folder, template, target, &distances, found)?;
    }
    Ok(())
}

/// The statistics that the job or the skeleton file names.
fn shape_model(job: &RegisterJob, files: &SkeletonFiles) -> Result<Option<ShapeModel>> {
    let folder = job.skeleton.parent().unwrap_or(Path::new(""));
    let own = files.document.statistics.as_ref().map(|name| folder.join(name));
    let path = job.shape_model.clone().or(own);
    path.map(|path| read_shape_model(&files.skeleton, &path)).transpose()
}

fn options(job: &RegisterJob, document: &SkeletonDocument) -> Options {
    let mut options = if job.paper { Options::published() } else { Options::default() };
    options.align = !job.no_align;
    options.as_is = job.as_is;
    options.limits = job.limits.unwrap_or(options.limits);
    if let Some(iterations) = job.iterations {
        options.max_iterations = iterations;
    }
    let from_file = document
        .clusters
        .as_ref()
        .map(|radii| radii.iter().map(|r| r.unwrap_or(f64::INFINITY)).collect::<Vec<f64>>());
    if let Some(radii) = job.radii.clone().or(from_file) {
        options.levels = Levels::Radii(radii);
    }
    options
}
