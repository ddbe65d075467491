//! The anatomy of one person from files to files: bones, then every object, then no overlaps.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::anatomy_page;
use super::anatomy_report::{AnatomyReport, ObjectLine};
use super::anatomy_spec::{AnatomyJob, Object};
use super::case::{Case, CaseRecord, Status, earlier, run_case, run_cases};
use super::provenance::hash_files;
use crate::error::{Error, Result};
use crate::io::{check_writable, read_tets};
use crate::io::{file_names, stem};
use crate::job::register::run::run_register;
use crate::job::register::skeleton_files::read_skeleton;
use crate::job::register::spec::RegisterJob;
use crate::job::report::files::write_report;
use crate::job::report::stages::Stages;
use crate::job::reshape::spec::ReshapeJob;
use crate::job::separate::{BodyFiles, separate_files};
use crate::register::Verdict;
use crate::run::Run;
use crate::separate::Options;

/// Memory that reshaping takes at its peak, beside what each tet takes; measured, docs/many.md.
const BYTES_PER_OBJECT: u64 = 85_000_000;
/// The same, per tet.
const BYTES_PER_TET: u64 = 6_500;
/// Tets where a job names no count.
const USUAL_TETS: usize = 15_000;
/// How often the run is looked after while a part of the job runs.
const INTERVAL: Duration = Duration::from_millis(50);

/// Shares of the whole job at which its parts begin.
const AFTER_BONES: f64 = 0.1;
const AFTER_OBJECTS: f64 = 0.8;

/// The person's bones and the same beside the templates.
struct Bones {
    names: Vec<String>,
    person: Vec<PathBuf>,
    template: Vec<Option<PathBuf>>,
    /// What speaks against them.
    doubt: Option<String>,
}

/// Finds the bones, reshapes all objects, separates them and writes all results into `job.out`. An
/// object that fails does not stop the others; objects and registered bones that an earlier run left
/// from the same inputs are kept. A cancelled run keeps and reports what is ready.
pub fn run_anatomy(job: &AnatomyJob, run: &Run) -> Result<AnatomyReport> {
    let out = job.out.as_deref().ok_or_else(|| {
        Error::invalid("no folder for the results is named; give it with -o or as out in the job")
    })?;
    if job.objects.is_empty() {
        return Err(Error::invalid("the job has no [[object]]; list what is to be reshaped"));
    }
    check_writable(&out.join("report.json"))?;
    let mut stages = Stages::begin();
    let bones = find_bones(job, out, run)?;
    stages.end("bones");
    let cases = reshape_all(job, &bones, out, run);
    let lines = job.objects.iter().zip(cases);
    let objects =
        lines.map(|(o, case)| object_line(o, case, out)).collect::<Result<Vec<ObjectLine>>>()?;
    stages.end("objects");
    let mut report = AnatomyReport::new(bones.names.clone(), objects);
    report.warnings.extend(bones.doubt.clone());
    separate_all(job, &bones, out, run, &mut report);
    stages.end("separation");
    run.enter("writing", 0.97);
    report.interrupted = run.is_cancelled();
    report.stages = stages.done();
    report.written.extend(["report.html", "report.json"].map(|name| out.join(name)));
    let page = anatomy_page::page(&report, out, &bones.person)?;
    write_report(out, &report, &page)?;
    run.enter("done", 1.0);
    Ok(report)
}

fn find_bones(job: &AnatomyJob, out: &Path, run: &Run) -> Result<Bones> {
    let Some(skeleton) = &job.skeleton else {
        let names: Vec<String> = job.bones.iter().map(|p| stem(p)).collect();
        let beside = |name: &String| job.template_bones.iter().find(|p| stem(p) == *name).cloned();
        let template = names.iter().map(beside).collect();
        return Ok(Bones { template, names, person: job.bones.clone(), doubt: None });
    };
    run.enter("bones", 0.0);
    let folder = out.join("skeleton");
    let files = read_skeleton(&skeleton.skeleton)?;
    let templates = skeleton.skeleton.parent().unwrap_or(Path::new(""));
    let meshes: Vec<PathBuf> =
        files.document.bones.iter().map(|bone| templates.join(&bone.mesh)).collect();
    let mut record = CaseRecord::new("skeleton", &skeleton.skeleton);
    let mut inputs = meshes.clone();
    inputs.push(skeleton.skeleton.clone());
    let named = [
        &skeleton.target,
        &skeleton.labels,
        &skeleton.volume,
        &skeleton.reference,
        &skeleton.shape_model,
    ];
    inputs.extend(named.into_iter().flatten().cloned());
    let options = serde_json::to_string(skeleton)
        .map_err(|e| Error::invalid(format!("the skeleton's options cannot be kept: {e}")))?;
    record.depends_on(options, hash_files(inputs)?);
    let record = match earlier(&folder, &record.key) {
        Some(kept) => kept,
        None => register_bones(skeleton, &folder, meshes.len(), record, run)?,
    };
    Ok(Bones {
        names: file_names(files.document.bones.iter().map(|bone| bone.name.as_str())),
        person: record.surfaces.iter().map(|surface| folder.join(surface)).collect(),
        template: meshes.into_iter().map(Some).collect(),
        doubt: (record.status != Status::Good).then_some(record.message),
    })
}

/// Registers the skeleton; its record has the bones' surfaces, relative to `folder`.
fn register_bones(
    skeleton: &RegisterJob,
    folder: &Path,
    count: usize,
    mut record: CaseRecord,
    run: &Run,
) -> Result<CaseRecord> {
    let mut skeleton = skeleton.clone();
    skeleton.out = Some(folder.to_path_buf());
    skeleton.report = Some(folder.join("report"));
    let started = Instant::now();
    let found = watched(run, |inner| run_register(&skeleton, inner))?;
    if run.is_cancelled() {
        return Err(Error::Cancelled);
    }
    // The bones come first, in the skeleton's order.
    let relative =
        |p: &PathBuf| p.strip_prefix(folder).map_or_else(|_| p.clone(), Path::to_path_buf);
    record.surfaces = found.report.written.iter().take(count).map(relative).collect();
    let judgement = &found.registered.judgement;
    record.status =
        if judgement.verdict == Verdict::Good { Status::Good } else { Status::Doubtful };
    if judgement.verdict > Verdict::Good {
        let reasons = judgement.reasons.join("; ");
        record.message = format!("the skeleton is {}: {reasons}", judgement.verdict.name());
    }
    record.seconds = started.elapsed().as_secs_f64();
    record.write(folder)?;
    Ok(record)
}

/// Runs `work` with a run of its own, whose fraction begins at zero; it is cancelled with `run`.
fn watched<T: Send>(run: &Run, work: impl FnOnce(&Run) -> Result<T> + Send) -> Result<T> {
    let inner = Run::new();
    std::thread::scope(|scope| {
        let worker = scope.spawn(|| work(&inner));
        while !worker.is_finished() {
            if run.is_cancelled() {
                inner.cancel();
            }
            std::thread::sleep(INTERVAL);
        }
        worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Reshapes every object, several at once.
fn reshape_all(
    job: &AnatomyJob,
    bones: &Bones,
    out: &Path,
    run: &Run,
) -> Vec<Option<Result<Case>>> {
    let count = job.objects.len();
    let tell = |done: usize| {
        let share = done as f64 / count as f64;
        let stage = format!("reshaping, {done} of {count} done");
        run.enter(&stage, AFTER_BONES + (AFTER_OBJECTS - AFTER_BONES) * share);
    };
    run_cases(count, at_once(job), run, tell, |k, own| {
        let object = &job.objects[k];
        let options = object.options.clone();
        let reshape = reshape_job(object, bones).map(|reshape| (reshape, options));
        let template = object.reshape.template.as_deref().unwrap_or(Path::new(""));
        run_case(&object.name, template, reshape, &folder_of(out, &object.name), own)
    })
}

/// Where an object's results are before it is separated.
pub(crate) fn folder_of(out: &Path, object: &str) -> PathBuf {
    out.join("objects").join(object)
}

/// The object's job with its bones.
fn reshape_job(object: &Object, bones: &Bones) -> Result<ReshapeJob> {
    let mut job = object.reshape.clone();
    let (mut templates, mut targets) = (Vec::new(), Vec::new());
    for name in &object.attached_to {
        let known = bones.names.iter().position(|n| n == name);
        let template = known.and_then(|k| bones.template[k].clone());
        let (Some(k), Some(template)) = (known, template) else {
            return Err(Error::invalid(format!(
                "it is attached to '{name}', which is not a bone of this job that has a template"
            )));
        };
        templates.push(template);
        targets.push(bones.person[k].clone());
    }
    if !templates.is_empty() {
        (job.attachments, job.attachment_targets) = (Some(templates), Some(targets));
    }
    Ok(job)
}

fn object_line(object: &Object, case: Option<Result<Case>>, out: &Path) -> Result<ObjectLine> {
    match case {
        None | Some(Err(Error::Cancelled)) => Ok(ObjectLine::not_done(&object.name)),
        Some(case) => ObjectLine::new(&case?, &folder_of(out, &object.name)),
    }
}

/// Pushes apart what was reshaped; what stands in the way becomes a warning.
fn separate_all(
    job: &AnatomyJob,
    bones: &Bones,
    out: &Path,
    run: &Run,
    report: &mut AnatomyReport,
) {
    if job.separate == Some(false) || run.is_cancelled() {
        return;
    }
    let mut files = Vec::new();
    for (object, line) in job.objects.iter().zip(&report.objects) {
        let (Some(surface), folder) = (&line.surface, folder_of(out, &object.name)) else {
            continue;
        };
        let tets = folder.join("tets.vtu");
        match read_tets(&tets).map(|mesh| (0..mesh.tets.len()).any(|t| mesh.volume(t) <= 0.0)) {
            Ok(false) => {}
            Ok(true) => {
                report.warnings.push(format!(
                    "'{}' was left out of the separation because tets of it are inverted",
                    object.name
                ));
                continue;
            }
            Err(error) => {
                report.warnings.push(format!("'{}' was not separated: {error}", object.name));
                continue;
            }
        }
        let extension = surface.extension().unwrap_or_default().to_string_lossy();
        files.push(BodyFiles {
            name: object.name.clone(),
            tets,
            surface: Some(out.join(surface)),
            surface_name: Some(format!("{}.{extension}", object.name)),
            markers: object.reshape.markers.clone().unwrap_or_default(),
        });
    }
    if files.is_empty() {
        return;
    }
    run.enter("separating", AFTER_OBJECTS);
    let options = Options { gap: job.gap, ..Options::default() };
    let folder = out.join("separated");
    match watched(run, |inner| separate_files(&files, &bones.person, &options, &folder, inner)) {
        Ok(separation) => {
            for (body, file) in separation.summary.bodies.iter().zip(&files) {
                let name =
                    Path::new("separated").join(file.surface_name.as_deref().unwrap_or_default());
                for line in report.objects.iter_mut().filter(|line| line.name == body.name) {
                    line.surface = Some(name.clone());
                }
            }
            report.written.extend(separation.written.iter().cloned());
            report.separation = Some(separation);
        }
        Err(error) => report.warnings.push(format!("nothing was separated: {error}")),
    }
}

/// How many objects are reshaped at once: as many as there are cores and as fit into half of the
/// memory that is free.
fn at_once(job: &AnatomyJob) -> usize {
    let cores = rayon::current_num_threads();
    let tets = job.objects.iter().map(|o| o.reshape.tet_count.unwrap_or(USUAL_TETS)).max();
    let each = BYTES_PER_OBJECT + tets.unwrap_or(USUAL_TETS) as u64 * BYTES_PER_TET;
    let fit = available_memory().map_or(cores, |bytes| (bytes / 2 / each) as usize);
    job.jobs.unwrap_or(cores.min(fit)).max(1)
}

/// Bytes that programs may still take, where the system tells.
fn available_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}
