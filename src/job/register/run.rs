//! One skeleton registration from files to files.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::bone_landmarks::read_bone_landmarks;
use super::bvh_motion::motion_of_bvh;
use super::image_target::{Measure, appearance, image_target};
use super::model_file::read_shape_model;
use super::output;
use super::report::RegisterReport;
use super::skeleton_build::build_skeleton;
use super::track::relative_reach;
use crate::error::{Error, Result};
use crate::io::bvh::read_bvh;
use crate::io::skeleton::SkeletonDocument;
use crate::io::{SurfaceFile, is_volume, read_bytes, read_surface, read_volume};
use crate::job::images::slice::only_label;
use crate::mesh::TriMesh;
use crate::register::animation::Motion;
use crate::register::options::Levels;
use crate::register::{Limits, Options, Registered, Registration, ShapeModel, Skeleton, Target};
use crate::run::Run;
use crate::threads::on_threads;
use crate::volume::label_surface;

/// All that describes one registration. What is `None` takes its default. Lengths are in the
/// template's unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
#[serde(default, deny_unknown_fields)]
pub struct RegisterJob {
    /// Template: *.skeleton.json
    #[cfg_attr(feature = "cli", arg(value_name = "SKELETON"))]
    pub skeleton: PathBuf,
    /// Surface of all the person's bones: .obj, .ply, .stl, or a label map with one label; bones may be
    /// fused
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Input"))]
    pub target: Option<PathBuf>,
    /// Folder with one surface per bone, named as the bone, or a label map (the skeleton file gives
    /// each bone its label), instead of --target
    #[cfg_attr(feature = "cli", arg(long, value_name = "PATH", help_heading = "Input"))]
    pub labels: Option<PathBuf>,
    /// Image of the person instead of a surface; the template must lie near the bones
    #[cfg_attr(feature = "cli", arg(long, value_name = "VOLUME", help_heading = "Input"))]
    pub volume: Option<PathBuf>,
    /// Image in which the template lies on the bones [default: what the skeleton file names]
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "VOLUME", requires = "volume", help_heading = "Input")
    )]
    pub reference: Option<PathBuf>,
    /// Places of bones that are known on the person: one file with both positions (template_x .. and
    /// target_x ..), or two marker files, of the template and of the person, paired by name; named as
    /// the bone (femur, "femur: head"), else on the nearest one
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "FILE", num_args = 1..=2, help_heading = "Input")
    )]
    pub landmarks: Option<Vec<PathBuf>>,
    /// Soft tissue surfaces in the template's pose to carry along, besides the skeleton's own
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1.., help_heading = "Input"))]
    pub carry: Option<Vec<PathBuf>>,
    /// Shape statistics (.h5.json) of the template's bones, from `moulage model fit` [default: what the
    /// skeleton file names]
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Input"))]
    pub shape_model: Option<PathBuf>,
    /// Motion to put on the person's skeleton: OpenSim (.mot, .sto), or .bvh with nodes named as the bones
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Input"))]
    pub motion: Option<PathBuf>,
    /// Angles of the motion whose sign is the opposite of the skeleton's
    #[cfg_attr(feature = "cli", arg(long, value_name = "NAME", num_args = 1.., help_heading = "Input"))]
    pub flip: Option<Vec<String>>,

    /// Run the loop as published: exact clusters, updates only when the elastic steps rest
    #[cfg_attr(feature = "cli", arg(long, help_heading = "Method"))]
    pub paper: bool,
    /// How images are compared: profiles, or the published moments [default: profiles]
    #[cfg_attr(feature = "cli", arg(long, value_enum, help_heading = "Method"))]
    pub measure: Option<Measure>,
    /// How far an image is searched to each side, at the first and the last level, mm [default: 10 and
    /// 2.5 % of the template's diagonal]
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "MM", num_args = 2, help_heading = "Method")
    )]
    pub reach: Option<Vec<f64>>,
    /// The template already lies where the person is
    #[cfg_attr(feature = "cli", arg(long, help_heading = "Method"))]
    pub no_align: bool,
    /// The target is meant as it is, even if it looks like a mirror image or another unit
    #[cfg_attr(feature = "cli", arg(long, help_heading = "Method"))]
    pub as_is: bool,
    /// What the joints' limits are: walls, soft (10 degrees further where the data insist), or nothing
    /// [default: hard]
    #[cfg_attr(feature = "cli", arg(long, value_enum, help_heading = "Method"))]
    pub limits: Option<Limits>,
    /// Cluster radii from coarse to fine, "inf" for one cluster [default: from the size]
    #[cfg_attr(feature = "cli", arg(long, value_name = "RADIUS", num_args = 1.., help_heading = "Method"))]
    pub radii: Option<Vec<f64>>,
    /// Iterations per level at most [default: 30]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", help_heading = "Method"))]
    pub iterations: Option<usize>,
    /// Threads [default: all cores]
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", help_heading = "Method"))]
    pub threads: Option<usize>,

    /// Folder for the result: bones/, result.skeleton.json, skeleton.glb, soft/
    #[cfg_attr(feature = "cli", arg(short, long, value_name = "FOLDER", help_heading = "Output"))]
    pub out: Option<PathBuf>,
    /// Folder for report.html and report.json
    #[cfg_attr(feature = "cli", arg(long, value_name = "FOLDER", help_heading = "Output"))]
    pub report: Option<PathBuf>,
    /// Metres per unit of the template, for skeleton.glb [default: 0.001]
    #[cfg_attr(feature = "cli", arg(long, value_name = "METRES", help_heading = "Output"))]
    pub metres_per_unit: Option<f64>,
}

/// What a finished registration tells its caller.
#[derive(Clone, Debug)]
pub struct RegisterResult {
    /// All figures, also in `report.json`.
    pub report: RegisterReport,
    /// The person's skeleton.
    pub registered: Registered,
}

/// A template with its files.
#[derive(Clone, Debug)]
pub struct SkeletonFiles {
    /// The skeleton file.
    pub document: SkeletonDocument,
    /// The skeleton.
    pub skeleton: Skeleton,
    /// The bones' mesh files, in their order.
    pub surfaces: Vec<SurfaceFile>,
}

/// Reads a skeleton file and the meshes it names.
pub fn read_skeleton(path: &Path) -> Result<SkeletonFiles> {
    let bytes = read_bytes(path)?;
    let text = std::str::from_utf8(&bytes)
        .map_err(|_| Error::parse(path, None, "not UTF-8 text; a skeleton file is JSON"))?;
    let document = SkeletonDocument::parse(text, path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let surfaces: Vec<SurfaceFile> = document
        .bones
        .iter()
        .map(|b| read_surface(&folder.join(&b.mesh)))
        .collect::<Result<_>>()?;
    let meshes = surfaces.iter().map(SurfaceFile::mesh).collect::<Result<Vec<TriMesh>>>()?;
    let skeleton = build_skeleton(&document, meshes)?;
    Ok(SkeletonFiles { document, skeleton, surfaces })
}

/// Reads, registers and writes all that `job` names. A cancelled run writes what it has.
pub fn run_register(job: &RegisterJob, run: &Run) -> Result<RegisterResult> {
    on_threads(job.threads, || run_here(job, run))
}

fn run_here(job: &RegisterJob, run: &Run) -> Result<RegisterResult> {
    if job.out.is_none() && job.report.is_none() {
        return Err(Error::invalid("no output is named; give the result's folder with -o"));
    }
    run.enter("reading", 0.0);
    let files = read_skeleton(&job.skeleton)?;
    let (target, mut notes) = read_target(job, &files)?;
    let landmarks =
        read_bone_landmarks(job.landmarks.as_deref().unwrap_or_default(), &files.skeleton)?;
    let target = target.with_landmarks(&files.skeleton, &landmarks.landmarks)?;
    notes.extend(landmarks.warning.clone());
    let carried = output::read_carried(job, &files)?;
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
        report.written =
            output::write(folder, job, &files, &registered, &carried, motion.as_ref())?;
    }
    if let Some(folder) = &job.report {
        report.write(folder, &files.skeleton, &registered)?;
    }
    run.enter("done", 1.0);
    Ok(RegisterResult { report, registered })
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

/// The target, and what its reader noticed.
fn read_target(job: &RegisterJob, files: &SkeletonFiles) -> Result<(Target, Vec<String>)> {
    if let (None, None, Some(volume)) = (&job.target, &job.labels, &job.volume) {
        let measure = job.measure.unwrap_or_default();
        let looks = appearance(&job.skeleton, files, job.reference.as_deref(), measure)?;
        return image_target(&files.skeleton, volume, looks);
    }
    surface_target(job, &files.skeleton).map(|target| (target, Vec::new()))
}

fn surface_target(job: &RegisterJob, skeleton: &Skeleton) -> Result<Target> {
    match (&job.target, &job.labels) {
        (Some(map), None) if job.volume.is_none() && is_volume(map) => bone_label_target(map),
        (Some(path), None) if job.volume.is_none() => Target::whole(read_surface(path)?.mesh()?),
        (None, Some(map)) if job.volume.is_none() && map.is_file() => {
            labelled_target(map, skeleton)
        }
        (None, Some(folder)) if job.volume.is_none() => {
            let mut surfaces = Vec::new();
            for bone in &skeleton.bones {
                let file = ["ply", "obj", "stl"]
                    .map(|e| folder.join(format!("{}.{e}", output::file_name(&bone.name))))
                    .into_iter()
                    .find(|p| p.is_file());
                if let Some(path) = file {
                    surfaces.push((bone.name.clone(), read_surface(&path)?.mesh()?));
                }
            }
            if surfaces.is_empty() {
                return Err(Error::invalid(format!(
                    "{} holds no surface named after a bone, such as {}.ply",
                    folder.display(),
                    skeleton.bones[0].name
                )));
            }
            Target::per_bone(skeleton, surfaces)
        }
        _ => Err(Error::invalid(
            "give the person's bones as one surface with --target, a folder with --labels, or an image with --volume: one of them",
        )),
    }
}

/// One surface of the only label of a map: all bones together.
fn bone_label_target(path: &Path) -> Result<Target> {
    let labels = read_volume(path)?.volume;
    let wrong = |e: Error| Error::parse(path, None, e.to_string());
    let label = only_label(&labels).map_err(wrong)?;
    let (points, triangles) = label_surface(&labels, label)
        .ok_or_else(|| wrong(Error::invalid("the label fills the whole image")))?;
    Target::whole(TriMesh::new(points, triangles)?)
}

/// A surface for each bone whose label the map holds.
fn labelled_target(path: &Path, skeleton: &Skeleton) -> Result<Target> {
    let labels = read_volume(path)?.volume;
    let mut surfaces = Vec::new();
    for bone in &skeleton.bones {
        let found = bone.label.and_then(|label| label_surface(&labels, label));
        if let Some((points, triangles)) = found {
            surfaces.push((bone.name.clone(), TriMesh::new(points, triangles)?));
        }
    }
    if surfaces.is_empty() {
        return Err(Error::parse(
            path,
            None,
            "the label map holds no bone's label; give each bone its \"label\" in the skeleton file",
        ));
    }
    Target::per_bone(skeleton, surfaces)
}

/// Reads a motion, OpenSim's or a BVH of the skeleton's bones; the angles named in `flip` change their
/// sign.
pub fn read_motion(path: &Path, skeleton: &Skeleton, flip: &[String]) -> Result<Motion> {
    let mut motion = if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("bvh")) {
        motion_of_bvh(skeleton, &read_bvh(path)?, path)?
    } else {
        let table = crate::io::mot::read_motion(path)?;
        Motion { names: table.names, times: table.times, frames: table.rows }
    };
    for name in flip {
        let column = motion.names.iter().position(|n| n == name).ok_or_else(|| {
            Error::invalid(format!("--flip {name}: {} has no such column", path.display()))
        })?;
        for row in &mut motion.frames {
            row[column] = -row[column];
        }
    }
    Ok(motion)
}
