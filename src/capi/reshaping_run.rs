//! Reshaping: started, or run to its end.

use super::boundary::{MlgError, MlgStatus, Outcome};
use super::reshaping::{MlgReshaping, MlgReshapingOptions, ProblemObject, options_of};
use super::result::{MlgReshapingResult, ReshapingResult};
use super::run::{MlgRun, RunObject, result_of};
use super::{access, handles};
use crate::reshape::{Options, Problem, reshape, reshape_again};
use crate::run::Run;
use crate::threads::thread_pool;

fn compute(problem: &Problem, options: &Options, run: &Run) -> Outcome<ReshapingResult> {
    let reshaped = reshape(problem, options, run)?;
    ReshapingResult::new(problem, reshaped, run.progress().seconds)
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
    access::make((out_run, "out_run"), error, || {
        let problem = handles::get::<ProblemObject, _>(problem, "problem")?.lock().clone();
        problem.check()?;
        // SAFETY: the caller's promise (see the module).
        let (options, thread_count) = unsafe { options_of(options)? };
        RunObject::start("a reshaping", thread_count, move |run| compute(&problem, &options, run))
    })
}

/// Starts a reshaping from the shape of an earlier result: the quick way after a landmark was moved,
/// markers came or went. `problem` must have the template and tets of the earlier one, `options` the
/// same values; else the run fails with a sentence. The earlier result may be freed at once. All
/// else is as for `mlg_reshaping_start`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_reshaping_start_again(
    earlier: *const MlgReshapingResult,
    problem: *const MlgReshaping,
    options: *const MlgReshapingOptions,
    out_run: *mut *mut MlgRun,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_run, "out_run"), error, || {
        let earlier = handles::get::<ReshapingResult, _>(earlier, "earlier")?;
        let problem = handles::get::<ProblemObject, _>(problem, "problem")?.lock().clone();
        problem.check()?;
        // SAFETY: the caller's promise (see the module).
        let (options, thread_count) = unsafe { options_of(options)? };
        let run = RunObject::start("a reshaping", thread_count, move |run| {
            let reshaped = reshape_again(earlier.reshaped(), &problem, &options, run)?;
            ReshapingResult::new(&problem, reshaped, run.progress().seconds)
        })?;
        Ok(run)
    })
}

/// Waits for the end of a reshaping and hands its result over, once. A cancelled run gives its best
/// shape so far, marked by `stop` in its summary, or `MLG_STATUS_CANCELLED` if it had none yet. Free
/// the result with `mlg_reshaping_result_free`, and the run with `mlg_run_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_run_wait_reshaping(
    run: *mut MlgRun,
    out_result: *mut *mut MlgReshapingResult,
    error: *mut MlgError,
) -> MlgStatus {
    access::make((out_result, "out_result"), error, || result_of::<ReshapingResult>(run))
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
    access::make((out_result, "out_result"), error, || {
        let problem = handles::get::<ProblemObject, _>(problem, "problem")?.lock().clone();
        // SAFETY: the caller's promise (see the module).
        let (options, thread_count) = unsafe { options_of(options)? };
        thread_pool(thread_count)?.install(|| compute(&problem, &options, &Run::new()))
    })
}
