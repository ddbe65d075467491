//! Runs: started, polled, cancelled, waited for. No callback crosses the border.

use libc::c_char;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use super::boundary::{
    Failure, MlgError, MlgStatus, Outcome, guard, guard_or, panicked, write_text,
};
use super::buffers::{self, Versioned};
use super::handles;
use super::reshaping::{MlgReshaping, MlgReshapingOptions, ProblemObject, options_of};
use super::result::{MlgReshapingResult, ReshapingResult};
use crate::reshape::{Options, Problem, reshape};
use crate::run::Run;

/// A computation on a thread of its own. May be polled and cancelled from any thread.
pub struct MlgRun;

/// Still at work.
pub const MLG_RUN_RUNNING: u32 = 0;
/// Ended; `mlg_run_wait_reshaping` returns at once.
pub const MLG_RUN_ENDED: u32 = 1;

/// Bytes of `MlgProgress.stage`, the ending zero included.
pub const MLG_STAGE_SIZE: usize = 64;

/// Where a run stands. Lengths are in the template's unit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MlgProgress {
    /// `sizeof` this struct in the caller's header; set by the caller.
    pub struct_size: usize,
    /// `MLG_RUN_RUNNING` or `MLG_RUN_ENDED`.
    pub state: u32,
    /// Iterations of the outer loop so far.
    pub iteration: u32,
    /// Share of the work done, 0 to 1, never falling.
    pub fraction: f64,
    /// Latest value of the objective.
    pub energy: f64,
    /// Mean distance of the markers to the shape; NaN while unknown.
    pub mean_error: f64,
    /// Largest distance of a marker to the shape; NaN while unknown.
    pub max_error: f64,
    /// Seconds since the start.
    pub seconds: f64,
    /// What is being done: UTF-8, zero-terminated.
    pub stage: [c_char; MLG_STAGE_SIZE],
}

// SAFETY: repr(C), plain numbers, size first.
unsafe impl Versioned for MlgProgress {}

type Answer = Arc<Mutex<Option<Outcome<ReshapingResult>>>>;

struct RunObject {
    run: Run,
    worker: Mutex<Option<JoinHandle<()>>>,
    ended: Arc<AtomicBool>,
    answer: Answer,
}

impl RunObject {
    fn start(problem: Problem, options: Options, thread_count: usize) -> Outcome<Self> {
        let run = Run::new();
        let answer = Answer::default();
        let ended = Arc::new(AtomicBool::new(false));
        let (its_run, its_answer, its_end) = (run.clone(), Arc::clone(&answer), Arc::clone(&ended));
        let work = move || {
            let done = catch_unwind(AssertUnwindSafe(|| {
                compute(problem, &options, &its_run, thread_count)
            }))
            .unwrap_or_else(|panic| Err(panicked(panic.as_ref())));
            *its_answer.lock().unwrap_or_else(PoisonError::into_inner) = Some(done);
            its_end.store(true, Ordering::Release);
        };
        let worker = std::thread::Builder::new()
            .name("moulage run".into())
            .spawn(work)
            .map_err(|e| Failure::invalid(format!("no thread could be started: {e}")))?;
        Ok(Self { run, worker: Mutex::new(Some(worker)), ended, answer })
    }

    /// Waits for the end.
    fn join(&self) {
        let worker = self.worker.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(worker) = worker {
            // The worker catches its panics; there is nothing to learn here.
            let _ = worker.join();
        }
    }
}

impl Drop for RunObject {
    fn drop(&mut self) {
        self.run.cancel();
        self.join();
    }
}

fn compute(
    problem: Problem,
    options: &Options,
    run: &Run,
    thread_count: usize,
) -> Outcome<ReshapingResult> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(thread_count)
        .thread_name(|i| format!("moulage {i}"))
        .build()
        .map_err(|e| {
            Failure::invalid(format!("{thread_count} threads could not be started: {e}"))
        })?;
    let reshaped = pool.install(|| reshape(&problem, options, run))?;
    Ok(ReshapingResult::new(problem, reshaped, run.progress().seconds))
}

/// Starts a reshaping on a thread of its own and returns at once. The problem is copied: it may be
/// changed or freed while the run goes on. `options`: NULL for the defaults. Free the run with
/// `mlg_run_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_start(
    problem: *const MlgReshaping,
    options: *const MlgReshapingOptions,
    out_run: *mut *mut MlgRun,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_run, "out_run")?;
        let problem = handles::get::<ProblemObject, _>(problem, "problem")?.lock().clone();
        problem.check()?;
        // SAFETY: the caller's promise (see the module).
        let (options, thread_count) = unsafe { options_of(options)? };
        let run = RunObject::start(problem, options, thread_count)?;
        // SAFETY: as above.
        unsafe { buffers::write(out_run, handles::give(run), "out_run") }
    })
}

/// Reshapes and returns when it is done: `mlg_reshaping_start` and `mlg_run_wait_reshaping` in one.
/// Free the result with `mlg_reshaping_result_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_run(
    problem: *const MlgReshaping,
    options: *const MlgReshapingOptions,
    out_result: *mut *mut MlgReshapingResult,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_result, "out_result")?;
        let problem = handles::get::<ProblemObject, _>(problem, "problem")?.lock().clone();
        // SAFETY: the caller's promise (see the module).
        let (options, thread_count) = unsafe { options_of(options)? };
        let result = compute(problem, &options, &Run::new(), thread_count)?;
        // SAFETY: as above.
        unsafe { buffers::write(out_result, handles::give(result), "out_result") }
    })
}

/// Tells where a run stands; takes less than a microsecond. `out_progress`: its `struct_size` must
/// be set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_run_poll(
    run: *const MlgRun,
    out_progress: *mut MlgProgress,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        let object = handles::get::<RunObject, _>(run, "run")?;
        let ended = object.ended.load(Ordering::Acquire);
        let now = object.run.progress();
        let mut progress = MlgProgress {
            struct_size: size_of::<MlgProgress>(),
            state: if ended { MLG_RUN_ENDED } else { MLG_RUN_RUNNING },
            iteration: now.iteration as u32,
            fraction: now.fraction,
            energy: now.energy,
            mean_error: now.mean_error,
            max_error: now.max_error,
            seconds: now.seconds,
            stage: [0; MLG_STAGE_SIZE],
        };
        write_text(&now.stage, &mut progress.stage);
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::fill(out_progress, progress, "out_progress") }
    })
}

/// Asks a run to stop; returns at once. The run still hands out the best shape so far, if it has
/// one. Allowed at any time, from any thread (but not from a signal handler: set a flag there).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_run_cancel(run: *const MlgRun) {
    guard_or((), || {
        handles::get::<RunObject, _>(run, "run")?.run.cancel();
        Ok(())
    });
}

/// Copies the latest shape of the surface, for a live view: `3 * *out_count` coordinates into
/// `buffer`, which has room for `3 * capacity`. `*out_count` is the number of points there are: 0
/// before the first shape; if it is above `capacity`, nothing is copied. `buffer` may be NULL if
/// `capacity` is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_run_preview_points(
    run: *const MlgRun,
    buffer: *mut f64,
    capacity: usize,
    out_count: *mut usize,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_count, "out_count")?;
        let object = handles::get::<RunObject, _>(run, "run")?;
        let points = object.run.preview().unwrap_or_default();
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::copy_points(&points, buffer, capacity)? };
        // SAFETY: as above.
        unsafe { buffers::write(out_count, points.len(), "out_count") }
    })
}

/// Waits for the end of a run and hands its result over, once. A cancelled run gives its best shape
/// so far, marked by `stop` in its summary, or `MLG_STATUS_CANCELLED` if it had none yet. Free the
/// result with `mlg_reshaping_result_free`, and the run with `mlg_run_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_run_wait_reshaping(
    run: *mut MlgRun,
    out_result: *mut *mut MlgReshapingResult,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_result, "out_result")?;
        let object = handles::get::<RunObject, _>(run, "run")?;
        object.join();
        let answer = object.answer.lock().unwrap_or_else(PoisonError::into_inner).take();
        let result = answer.unwrap_or_else(|| {
            Err(Failure::invalid("the result of this run was waited for already"))
        })?;
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write(out_result, handles::give(result), "out_result") }
    })
}

/// Cancels a run, waits for its end and frees it. NULL and handles freed already are allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_run_free(run: *mut MlgRun) {
    guard_or((), || {
        // Dropping the object cancels and joins; a thread that waits drops it last.
        if let Some(object) = handles::free::<RunObject, _>(run) {
            object.run.cancel();
        }
        Ok(())
    });
}
