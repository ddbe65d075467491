//! One reshaping from files to files.

use super::fill::{fill, new_tets};
use super::inputs::Inputs;
use super::output;
use super::page::page;
use super::report::{Ending, Report};
use super::result::Outcome;
use super::spec::ReshapeJob;
use crate::align::{Freedom, Similarity, pre_align};
use crate::error::{Error, Result};
use crate::job::images::compare::Person;
use crate::job::report::files::write_report;
use crate::job::report::stages::Stages;
use crate::math::Vec3;
use crate::measure::{Spread, marker_distances};
use crate::mesh::TriMesh;
use crate::reshape::{
    Marker, Options, Pair, Problem, Refinement, Reshaped, Uncertainty, find_borders, reshape,
    uncertainty,
};
use crate::run::Run;
use crate::tetrahedralize::Tetrahedralization;
use crate::threads::on_threads;

/// What a finished job tells its caller.
#[derive(Clone, Debug)]
pub struct JobResult {
    /// All figures, also in `report.json`.
    pub report: Report,
    /// The template's vertices in the person's shape.
    pub points: Vec<Vec3>,
}

/// Reads, checks, reshapes and writes all that `job` names. A run that is cancelled, or whose
/// solver gives up, writes its best shape; [`Report::ending`] tells. Nothing is written if the
/// inputs cannot be worked with.
pub fn run_reshape(job: &ReshapeJob, run: &Run) -> Result<JobResult> {
    on_threads(job.threads, || run_here(job, run))
}

fn run_here(job: &ReshapeJob, run: &Run) -> Result<JobResult> {
    let mut stages = Stages::begin();
    run.enter("reading", 0.0);
    let mut inputs = Inputs::read(job)?;
    if job.refine == Some(true) && job.volume.is_none() {
        return Err(no_image());
    }
    let person = Person::read(job.volume.as_ref(), job.label_map.as_ref(), job.label)?;
    output::check_places(job)?;
    if samples(job) > 0 {
        Uncertainty::check(samples(job))?;
    }
    let align = job.align.unwrap_or_default().freedom();
    let suspicions = inputs.inspect(align)?;
    inputs.warnings.extend(suspicions);
    if let Some(freedom) = align {
        place(&mut inputs, freedom)?;
    }
    stages.end("reading");
    run.enter("filling with tets", 0.0);
    let filling = fill(job, &inputs.surface, run)?;
    inputs.warnings.extend(filling.warnings.iter().cloned());
    stages.end("tets");
    let (mut problem, options) = (problem(job, &inputs, filling), options(job));
    let mut reshaped = reshape(&problem, &options, run)?;
    stages.end("solver");
    let mut refinement = None;
    if job.refine == Some(true) && !run.is_cancelled() {
        refinement = Some(refine_problem(&mut problem, &person, &reshaped.surface_points)?);
        reshaped = reshape(&problem, &options, run)?;
        stages.end("solver, with the image");
    }
    let uncertainty = sampled(job, &reshaped, run).unwrap_or_else(|error| {
        // The result is there, whatever becomes of this.
        inputs.warnings.push(format!("how sure the result is cannot be said: {error}"));
        None
    });
    stages.end("plausible shapes");
    inputs.warnings.append(&mut reshaped.summary.warnings);
    let outcome = Outcome::new(&inputs, &options, reshaped, uncertainty);
    let mut report = outcome.report(&inputs)?;
    let result = TriMesh {
        points: outcome.reshaped.surface_points.clone(),
        triangles: inputs.surface.triangles.clone(),
    };
    report.refinement = refinement;
    report.millimetres = job.volume.is_some() || job.label_map.is_some();
    report.label_fit = person.fit(&result)?;
    if job.report.is_some() {
        report.slices = person.figures(&result, Some(&inputs.surface), &outcome.markers)?;
    }
    run.enter("writing", 1.0);
    report.written = output::write(job, &inputs, &outcome)?;
    stages.end("writing");
    report.stages = stages.done();
    if let Some(folder) = &job.report {
        report.written.extend(["report.html", "report.json"].map(|name| folder.join(name)));
        write_report(folder, &report, &page(&report, &outcome.shapes(&inputs)))?;
    }
    Ok(JobResult { points: outcome.reshaped.surface_points, report })
}

fn samples(job: &ReshapeJob) -> usize {
    job.samples.unwrap_or(Uncertainty::SAMPLES)
}

/// Plausible shapes, as many as asked for; none of a run that was interrupted.
fn sampled(job: &ReshapeJob, reshaped: &Reshaped, run: &Run) -> Result<Option<Uncertainty>> {
    let samples = samples(job);
    if samples == 0 || run.is_cancelled() {
        return Ok(None);
    }
    match uncertainty(reshaped, samples, run) {
        Err(Error::Cancelled) => Ok(None),
        other => other.map(Some),
    }
}

/// Adds to the problem what the image shows where the user marked nothing.
fn refine_problem(problem: &mut Problem, person: &Person, points: &[Vec3]) -> Result<Refinement> {
    let volume = person.volume.as_ref().ok_or_else(no_image)?;
    let triangles = problem.surface.triangles.clone();
    let result = TriMesh { points: points.to_vec(), triangles };
    let users: Vec<Vec3> = problem.markers.iter().map(|m| m.position).collect();
    let before = Spread::of(&marker_distances(&result.points, &result.triangles, &users));
    let (markers, refinement) = find_borders(volume, &result, &users, before)?;
    problem.markers.extend(markers);
    Ok(refinement)
}

fn no_image() -> Error {
    Error::invalid("to refine by the image, an image is needed; name it with --volume")
}

/// Moves template, template points and carried meshes to where the person is.
fn place(inputs: &mut Inputs, freedom: Freedom) -> Result<()> {
    if !inputs.fixed.is_empty() {
        return Err(Error::invalid(
            "fixed points stay where they are, so the template cannot be aligned; leave one of the two out",
        ));
    }
    let markers: Vec<Vec3> = inputs.markers.iter().map(|m| m.position).collect();
    let (from, to): (Vec<Vec3>, Vec<Vec3>) =
        inputs.landmarks.iter().map(|l| (l.position, l.target)).unzip();
    let motion = pre_align(&inputs.surface, &markers, Some((&from, &to)), freedom)?;
    let apply = |motion: &Similarity, points: &mut [Vec3]| {
        for p in points {
            *p = motion.apply(p);
        }
    };
    apply(&motion, &mut inputs.surface.points);
    for (_, _, points) in &mut inputs.carried {
        apply(&motion, points);
    }
    for pair in inputs.landmarks.iter_mut().chain(&mut inputs.attachments) {
        pair.position = motion.apply(&pair.position);
    }
    Ok(())
}

fn problem(job: &ReshapeJob, inputs: &Inputs, filling: Tetrahedralization) -> Problem {
    let mut problem = Problem::new(inputs.surface.clone(), filling);
    problem.new_tets = new_tets(job);
    problem.markers = inputs
        .markers
        .iter()
        .map(|m| Marker { position: m.position, weight: m.weight.unwrap_or(1.0), sigma: m.sigma })
        .collect();
    problem.landmarks = inputs.landmarks.iter().map(Pair::landmark).collect();
    problem.attachments = inputs.attachments.iter().map(Pair::landmark).collect();
    problem.fixed.clone_from(&inputs.fixed);
    problem
}

fn options(job: &ReshapeJob) -> Options {
    let mut options = Options::default();
    set(&mut options.hard_attachments, job.hard_attachments);
    set(&mut options.paper, job.paper);
    set(&mut options.reverse_term, job.reverse_term);
    set(&mut options.smoothness, job.smoothness);
    set(&mut options.poisson, job.poisson);
    set(&mut options.max_iterations, job.max_iterations);
    set(&mut options.max_remeshes, job.remesh);
    options.screening = job.screening;
    options.tolerance = job.tolerance;
    options.landmark_tolerance = job.landmark_tolerance;
    options.attachment_tolerance = job.attachment_tolerance;
    options
}

fn set<T>(option: &mut T, wish: Option<T>) {
    if let Some(wish) = wish {
        *option = wish;
    }
}

impl JobResult {
    /// Whether the solver was satisfied.
    pub fn is_good(&self) -> bool {
        self.report.ending == Ending::Good
    }
}
