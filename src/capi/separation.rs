//! Separation of bodies that overlap: the problem, its options, the run.

use libc::c_char;
use std::ptr;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::boundary::{Failure, MlgError, MlgStatus, Outcome, guard};
use super::buffers::{self, Versioned};
use super::mesh::{MlgTetMesh, MlgTriMesh, Surface};
use super::result::{MlgReshapingResult, ReshapingResult};
use super::run::{MlgRun, RunObject, result_of};
use super::separation_result::{MlgSeparationResult, SeparationResult};
use super::{access, handles};
use crate::mesh::TetMesh;
use crate::run::Run;
use crate::separate::{Body, Obstacle, Options, separate};
use crate::threads::thread_pool;

/// Bodies that overlap each other or obstacles. May be used by one thread at a time.
pub struct MlgSeparation;

/// How to separate. Set with `mlg_separation_options_init`. Lengths are in the bodies' unit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgSeparationOptions {
    /// `sizeof` this struct in the caller's header.
    pub struct_size: usize,
    /// Distance to leave between surfaces; 0 (default): the median diagonal of the bodies / 2000.
    pub gap: f64,
    /// Vertices up to this many edges away from an overlap may move. Default 5.
    pub rings: u32,
    /// Threads to use; 0 (default): all. The result does not depend on it.
    pub thread_count: u32,
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgSeparationOptions {}

/// What is to be separated.
#[derive(Clone, Default)]
struct Scene {
    bodies: Vec<Body>,
    obstacles: Vec<Obstacle>,
}

#[derive(Default)]
struct ProblemObject {
    scene: Mutex<Scene>,
}

impl ProblemObject {
    fn lock(&self) -> MutexGuard<'_, Scene> {
        self.scene.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Scene {
    /// Overlaps are told by names, so that no two may be the same.
    fn check_name(&self, name: &str) -> Outcome<()> {
        let bodies = self.bodies.iter().map(|b| &b.name);
        if bodies.chain(self.obstacles.iter().map(|o| &o.name)).any(|known| known == name) {
            return Err(Failure::invalid(format!("there is a '{name}' already; names are unique")));
        }
        Ok(())
    }

    fn add(&mut self, body: Body) -> Outcome<()> {
        self.check_name(&body.name)?;
        self.bodies.push(body);
        Ok(())
    }

    fn compute(&self, options: &Options, run: &Run) -> Outcome<SeparationResult> {
        let separation = separate(&self.bodies, &self.obstacles, options, run)?;
        let seconds = run.progress().seconds;
        Ok(SeparationResult::new(&self.bodies, &self.obstacles, separation, seconds))
    }
}

fn defaults() -> MlgSeparationOptions {
    MlgSeparationOptions {
        struct_size: size_of::<MlgSeparationOptions>(),
        gap: 0.0,
        rings: Options::default().rings as u32,
        thread_count: 0,
    }
}

/// Writes the defaults. `struct_size`: `sizeof *out_options`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_options_init(
    out_options: *mut MlgSeparationOptions,
    struct_size: usize,
) -> MlgStatus {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write_versioned(out_options, struct_size, defaults(), "out_options") }
    })
}

unsafe fn options_of(given: *const MlgSeparationOptions) -> Outcome<(Options, usize)> {
    // SAFETY: passed on from the caller.
    let given = unsafe { buffers::options(given, defaults())? };
    let gap = (given.gap != 0.0).then_some(given.gap);
    let options = Options { gap, rings: given.rings as usize, ..Options::default() };
    options.check()?;
    Ok((options, given.thread_count as usize))
}

/// Makes a separation without bodies yet. Free with `mlg_separation_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_new(
    out_problem: *mut *mut MlgSeparation,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        let handle = || handles::give(ProblemObject::default());
        buffers::check_out(out_problem, "out_problem")?;
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write(out_problem, handle(), "out_problem") }
    })
}

/// Adds a soft body in its present shape; bodies are numbered from 0 in the order of being added.
///
/// `name`: UTF-8, unique among bodies and obstacles. `surface`: lies in the tets, also in its present
/// shape; NULL: the boundary of the tets, whose vertices then come in their order in the tet mesh.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_add_body(
    problem: *mut MlgSeparation,
    name: *const c_char,
    tets: *const MlgTetMesh,
    surface: *const MlgTriMesh,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        // SAFETY: the caller's promise (see the module).
        let name = unsafe { buffers::text(name, "name")? };
        let tets = handles::get::<TetMesh, _>(tets, "tets")?;
        let tets = TetMesh::clone(&tets);
        let body = if surface.is_null() {
            Body::from_tets(name, tets)?
        } else {
            let surface = handles::get::<Surface, _>(surface, "surface")?;
            surface.check_triangles("surface")?;
            Body::with_surface(name, tets, &surface.mesh)?
        };
        problem.lock().add(body)
    })
}

/// Adds the result of a reshaping as a soft body, with its surface and its markers. `name`: UTF-8,
/// unique. The result may be freed at once.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_add_result(
    problem: *mut MlgSeparation,
    name: *const c_char,
    result: *const MlgReshapingResult,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        // SAFETY: the caller's promise (see the module).
        let name = unsafe { buffers::text(name, "name")? };
        let result = handles::get::<ReshapingResult, _>(result, "result")?;
        problem.lock().add(result.body(name))
    })
}

/// Adds something that does not move, such as a bone; obstacles are numbered after all bodies.
/// `name`: UTF-8, unique. `surface`: may be freed afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_add_obstacle(
    problem: *mut MlgSeparation,
    name: *const c_char,
    surface: *const MlgTriMesh,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        // SAFETY: the caller's promise (see the module).
        let name = unsafe { buffers::text(name, "name")? };
        let surface = handles::get::<Surface, _>(surface, "surface")?;
        surface.check_triangles("surface")?;
        let mut scene = problem.lock();
        scene.check_name(&name)?;
        scene.obstacles.push(Obstacle { name, surface: surface.mesh.clone() });
        Ok(())
    })
}

/// Sets markers of the person's surface that a body meets: its surface is held there as far as
/// contact allows; replaces earlier ones. `body`: a number from 0. `points`: `3 * count` coordinates,
/// finite; may be NULL if `count` is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_set_markers(
    problem: *mut MlgSeparation,
    body: usize,
    points: *const f64,
    count: usize,
    error: *mut MlgError,
) -> MlgStatus {
    access::with((problem, "problem"), error, |problem: &ProblemObject| {
        // SAFETY: the caller's promise (see the module).
        let points = unsafe { buffers::points(points, count, "points")? };
        let mut scene = problem.lock();
        buffers::entry(&scene.bodies, body, "body")?;
        scene.bodies[body].markers = points;
        Ok(())
    })
}

/// Starts a separation on a thread of its own and returns at once. The problem is copied: it may be
/// changed or freed while the run goes on. Its preview has the surfaces of all bodies. `options`:
/// NULL for the defaults. Free the run with `mlg_run_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_start(
    problem: *const MlgSeparation,
    options: *const MlgSeparationOptions,
    out_run: *mut *mut MlgRun,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_run, "out_run"), error, || {
        let scene = handles::get::<ProblemObject, _>(problem, "problem")?.lock().clone();
        // SAFETY: the caller's promise (see the module).
        let (options, thread_count) = unsafe { options_of(options)? };
        RunObject::start("a separation", thread_count, move |run| scene.compute(&options, run))
    })
}

/// Waits for the end of a separation and hands its result over, once. A cancelled run gives the shapes
/// with the least overlap so far, marked by `ending` in its summary, or `MLG_STATUS_CANCELLED` if it
/// had none yet. Free the result with `mlg_separation_result_free`, and the run with `mlg_run_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_run_wait_separation(
    run: *mut MlgRun,
    out_result: *mut *mut MlgSeparationResult,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_result, "out_result"), error, || result_of::<SeparationResult>(run))
}

/// Separates and returns when it is done: `mlg_separation_start` and `mlg_run_wait_separation` in one.
/// Free the result with `mlg_separation_result_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_run(
    problem: *const MlgSeparation,
    options: *const MlgSeparationOptions,
    out_result: *mut *mut MlgSeparationResult,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_result, "out_result"), error, || {
        let scene = handles::get::<ProblemObject, _>(problem, "problem")?.lock().clone();
        // SAFETY: the caller's promise (see the module).
        let (options, thread_count) = unsafe { options_of(options)? };
        thread_pool(thread_count)?.install(|| scene.compute(&options, &Run::new()))
    })
}

/// Frees a separation. NULL and handles freed already are allowed. Runs started from it go on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_separation_free(problem: *mut MlgSeparation) {
    access::free::<ProblemObject, _>(problem);
}
