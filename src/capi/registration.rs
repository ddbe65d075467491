//! Registration of a skeleton: the problem, its options, the run.

use std::ptr;
use std::sync::{Arc, Mutex, PoisonError};

use super::boundary::{Failure, MlgError, MlgStatus, Outcome, guard};
use super::buffers::{self, Versioned};
use super::mesh::{MlgTriMesh, Surface};
use super::registration_result::{MlgRegistrationResult, RegistrationResult};
use super::run::{MlgRun, RunObject, result_of};
use super::shape_model::{MlgShapeModel, ModelObject};
use super::skeleton::{MlgSkeleton, SkeletonObject};
use super::volume::MlgVolume;
use super::{access, handles};
use crate::io::VolumeFile;
use crate::job::read_shape_model;
use crate::register::options::Levels;
use crate::register::{Appearance, Limits, Options, Registration, ShapeModel, Target};
use crate::run::Run;
use crate::threads::thread_pool;

/// A template skeleton and the surface it is to follow. May be used by one thread at a time.
pub struct MlgRegistration;

#[derive(Clone)]
enum Seen {
    Nothing,
    Whole(Arc<Surface>),
    PerBone(Vec<Option<Arc<Surface>>>),
    Image { person: Arc<VolumeFile>, reference: Arc<VolumeFile> },
}

struct ProblemObject {
    template: Arc<SkeletonObject>,
    seen: Mutex<Seen>,
    /// Statistics in place of those that the template's file names.
    model: Mutex<Option<Arc<ModelObject>>>,
}

/// What the limits of joints are to a registration.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MlgLimits {
    /// Walls.
    Hard = 0,
    /// Where the data insist, a joint turns up to 10 degrees further. The default.
    Soft = 1,
    /// Joints turn freely; the bones still hang together.
    None = 2,
}

/// How to register. Set with `mlg_registration_options_init`. Lengths are in the template's unit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgRegistrationOptions {
    /// `sizeof` this struct in the caller's header.
    pub struct_size: usize,
    /// 1 (default): many orientations of the template are tried. 0: it already lies where the person
    /// is.
    pub align: u32,
    /// 1: the loop as published, for comparison. 0 (default): the improved one.
    pub paper: u32,
    /// Iterations per level at most; 0 (default): 30.
    pub max_iterations: u32,
    /// Threads to use; 0 (default): all. The result does not depend on it.
    pub thread_count: u32,
    /// Cluster radii from coarse to fine, INFINITY for one cluster; NULL (default): as the skeleton's
    /// file says, else chosen from its size. Read during the call only.
    pub radii: *const f64,
    /// Number of radii.
    pub radius_count: usize,
    /// 1: the target is meant as it is, even if it looks like a mirror image or another unit. 0
    /// (default): such a target is refused.
    pub as_is: u32,
    /// 0.
    pub reserved: u32,
    /// What the joints' limits are to the search: a number of `MlgLimits`. A joint whose file has a rule
    /// of its own keeps it.
    pub limits: u32,
    /// 0.
    pub reserved_too: u32,
}

// SAFETY: repr(C), plain numbers and a pointer, size first.
unsafe impl Versioned for MlgRegistrationOptions {}

const DEFAULTS: MlgRegistrationOptions = MlgRegistrationOptions {
    struct_size: size_of::<MlgRegistrationOptions>(),
    align: 1,
    paper: 0,
    max_iterations: 0,
    thread_count: 0,
    radii: ptr::null(),
    radius_count: 0,
    as_is: 0,
    reserved: 0,
    limits: MlgLimits::Soft as u32,
    reserved_too: 0,
};

/// Writes the defaults. `struct_size`: `sizeof *out_options`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_options_init(
    out_options: *mut MlgRegistrationOptions,
    struct_size: usize,
) -> MlgStatus {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write_versioned(out_options, struct_size, DEFAULTS, "out_options") }
    })
}

fn limits(number: u32) -> Outcome<Limits> {
    const KNOWN: [Limits; 3] = [Limits::Hard, Limits::Soft, Limits::None];
    KNOWN.get(number as usize).copied().ok_or_else(|| {
        Failure::invalid(format!("options.limits is {number}; 0 to 2 are known (MlgLimits)"))
    })
}

unsafe fn options_of(
    given: *const MlgRegistrationOptions,
    template: &SkeletonObject,
) -> Outcome<(Options, usize)> {
    // SAFETY: passed on from the caller.
    let given = unsafe { buffers::options(given, DEFAULTS)? };
    let paper = buffers::switch(given.paper, "options.paper")?;
    let mut options = if paper { Options::published() } else { Options::default() };
    options.align = buffers::switch(given.align, "options.align")?;
    options.as_is = buffers::switch(given.as_is, "options.as_is")?;
    options.limits = limits(given.limits)?;
    if given.max_iterations > 0 {
        options.max_iterations = given.max_iterations as usize;
    }
    // SAFETY: as above.
    let radii = unsafe { buffers::numbers(given.radii, given.radius_count, "options.radii")? };
    if let Some(radius) = radii.iter().find(|r| r.is_nan() || **r <= 0.0) {
        return Err(Failure::invalid(format!(
            "options.radii: {radius} is not a cluster radius; radii are above 0"
        )));
    }
    let from_file = template.document.clusters.as_ref();
    let from_file = from_file.map(|radii| radii.iter().map(|r| r.unwrap_or(f64::INFINITY)));
    if !radii.is_empty() {
        options.levels = Levels::Radii(radii);
    } else if let Some(radii) = from_file {
        options.levels = Levels::Radii(radii.collect());
    }
    Ok((options, given.thread_count as usize))
}

/// Makes a registration of a template, without a target yet. Free with `mlg_registration_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_new(
    template_skeleton: *const MlgSkeleton,
    out_problem: *mut *mut MlgRegistration,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_problem, "out_problem"), error, || {
        let template = handles::get::<SkeletonObject, _>(template_skeleton, "template_skeleton")?;
        let (seen, model) = (Mutex::new(Seen::Nothing), Mutex::new(None));
        let problem = ProblemObject { template, seen, model };
        Ok(problem)
    })
}

/// Sets one surface of all the person's bones, which may be fused; replaces earlier targets. Its
/// normals point outwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_set_target(
    problem: *mut MlgRegistration,
    surface: *const MlgTriMesh,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        let surface = handles::get::<Surface, _>(surface, "surface")?;
        surface.check_triangles("surface")?;
        problem.set(Seen::Whole(surface));
        Ok(())
    })
}

/// Sets the person's surface of one bone, a number from 0; a target for all bones is dropped. Bones
/// without a surface follow their joints.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_set_bone_target(
    problem: *mut MlgRegistration,
    bone: usize,
    surface: *const MlgTriMesh,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        let surface = handles::get::<Surface, _>(surface, "surface")?;
        surface.check_triangles("surface")?;
        let count = problem.template.skeleton.bones.len();
        let mut of_bone = match problem.seen() {
            Seen::PerBone(surfaces) => surfaces,
            Seen::Nothing | Seen::Whole(_) | Seen::Image { .. } => vec![None; count],
        };
        let slot = of_bone.get_mut(bone).ok_or_else(|| {
            Failure::invalid(format!(
                "bone {bone} does not exist: there are {count} (numbered from 0)"
            ))
        })?;
        *slot = Some(surface);
        problem.set(Seen::PerBone(of_bone));
        Ok(())
    })
}

/// Sets an image of the person in place of surfaces. `reference`: an image of the same protocol in which
/// the template lies on the bones. In `person` it must lie near them: a tenth of its diagonal is
/// searched, and again from where that ends, whatever `align` says. Millimetres, RAS.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_set_image(
    problem: *mut MlgRegistration,
    person: *const MlgVolume,
    reference: *const MlgVolume,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        let person = handles::get::<VolumeFile, _>(person, "person")?;
        let reference = handles::get::<VolumeFile, _>(reference, "reference")?;
        problem.set(Seen::Image { person, reference });
        Ok(())
    })
}

/// Holds the bones to shapes that statistics know, in place of scaling each by itself. `model`: of this
/// template, or NULL: the one that the template's file names, if any.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_set_shape_model(
    problem: *mut MlgRegistration,
    model: *const MlgShapeModel,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        let model = if model.is_null() {
            None
        } else {
            let model = handles::get::<ModelObject, _>(model, "model")?;
            model.check_template(&problem.template)?;
            Some(model)
        };
        *problem.model.lock().unwrap_or_else(PoisonError::into_inner) = model;
        Ok(())
    })
}

impl ProblemObject {
    fn seen(&self) -> Seen {
        self.seen.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn set(&self, seen: Seen) {
        *self.seen.lock().unwrap_or_else(PoisonError::into_inner) = seen;
    }

    fn model(&self) -> Option<Arc<ModelObject>> {
        self.model.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn check(&self) -> Outcome<()> {
        if matches!(self.seen(), Seen::Nothing) {
            return Err(Failure::invalid(
                "the registration has no target; set one with mlg_registration_set_target",
            ));
        }
        Ok(())
    }

    fn target(&self) -> Outcome<Target> {
        let bones = &self.template.skeleton.bones;
        Ok(match self.seen() {
            Seen::Nothing => return Err(Failure::invalid("the registration has no target")),
            Seen::Whole(surface) => Target::whole(surface.mesh.clone())?,
            Seen::PerBone(surfaces) => {
                let named = bones
                    .iter()
                    .zip(surfaces)
                    .filter_map(|(b, s)| Some((b.name.clone(), s?.mesh.clone())));
                Target::per_bone(&self.template.skeleton, named.collect())?
            }
            Seen::Image { person, reference } => {
                let template = &self.template.skeleton;
                let looks = Appearance::profiles(template, &reference.volume, None)?;
                Target::image(template, person.volume.clone(), looks)?
            }
        })
    }

    /// The statistics that were set, else those that the template's file names.
    fn shape_model(&self) -> Outcome<Option<ShapeModel>> {
        if let Some(object) = self.model() {
            return Ok(Some(object.model.clone()));
        }
        let path = self.template.statistics.as_deref();
        Ok(path.map(|path| read_shape_model(&self.template.skeleton, path)).transpose()?)
    }

    fn compute(&self, options: Options, run: &Run) -> Outcome<RegistrationResult> {
        let target = self.target()?;
        let mut registration = Registration::new(self.template.skeleton.clone(), options)?;
        if let Some(model) = self.shape_model()? {
            registration = registration.with_shape_model(model)?;
        }
        let registered = registration.register(&target, run)?;
        let seconds = run.progress().seconds;
        Ok(RegistrationResult::new(Arc::clone(&self.template), registered, seconds))
    }

    /// What a run keeps: the problem may change meanwhile.
    fn copy(&self) -> Self {
        Self {
            template: Arc::clone(&self.template),
            seen: Mutex::new(self.seen()),
            model: Mutex::new(self.model()),
        }
    }
}

/// Starts a registration on a thread of its own and returns at once. The problem is copied: it may be
/// changed or freed while the run goes on. `options`: NULL for the defaults. Free the run with
/// `mlg_run_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_start(
    problem: *const MlgRegistration,
    options: *const MlgRegistrationOptions,
    out_run: *mut *mut MlgRun,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_run, "out_run"), error, || {
        let problem = handles::get::<ProblemObject, _>(problem, "problem")?.copy();
        problem.check()?;
        // SAFETY: the caller's promise (see the module).
        let (options, thread_count) = unsafe { options_of(options, &problem.template)? };
        RunObject::start("a registration", thread_count, move |run| problem.compute(options, run))
    })
}

/// Waits for the end of a registration and hands its result over, once. A cancelled run gives what it
/// has, marked by `cancelled` in its summary. Free the result with `mlg_registration_result_free`,
/// and the run with `mlg_run_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_run_wait_registration(
    run: *mut MlgRun,
    out_result: *mut *mut MlgRegistrationResult,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_result, "out_result"), error, || result_of::<RegistrationResult>(run))
}

/// Registers and returns when it is done: `mlg_registration_start` and `mlg_run_wait_registration` in
/// one. Free the result with `mlg_registration_result_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_run(
    problem: *const MlgRegistration,
    options: *const MlgRegistrationOptions,
    out_result: *mut *mut MlgRegistrationResult,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_result, "out_result"), error, || {
        let problem = handles::get::<ProblemObject, _>(problem, "problem")?.copy();
        problem.check()?;
        // SAFETY: the caller's promise (see the module).
        let (options, thread_count) = unsafe { options_of(options, &problem.template)? };
        thread_pool(thread_count)?.install(|| problem.compute(options, &Run::new()))
    })
}

/// Frees a registration. NULL and handles freed already are allowed. Runs started from it go on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_registration_free(problem: *mut MlgRegistration) {
    access::free::<ProblemObject, _>(problem);
}
