//! Runs: started, polled, cancelled, waited for. No callback crosses the border.

use libc::c_char;
use std::any::{Any, TypeId};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use super::boundary::{
    Failure, MlgError, MlgStatus, Outcome, guard, guard_or, panicked, write_text,
};
use super::buffers::{self, Versioned};
use super::{access, handles};
use crate::run::Run;
use crate::threads::thread_pool;

/// A computation on a thread of its own. May be polled and cancelled from any thread.
pub struct MlgRun;

/// Still at work.
pub const MLG_RUN_RUNNING: u32 = 0;
/// Ended; waiting for its result returns at once.
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
    /// Share of the work done, 0 to 1, never falling; 1 once it has ended with a result and was not
    /// cancelled.
    pub fraction: f64,
    /// Latest value of the objective.
    pub energy: f64,
    /// Mean distance of the markers (registrations: of the pairs) to the shape; NaN while unknown.
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

/// A result of any kind; `RunObject::take` knows which.
type Answer = Box<dyn Any + Send>;

/// Whether a computation has ended, and who waits for that.
#[derive(Default)]
struct End {
    reached: Mutex<bool>,
    signal: Condvar,
}

impl End {
    fn tell(&self) {
        *self.reached.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.signal.notify_all();
    }

    /// Whether it is reached within a time; `None`: without a limit.
    fn wait(&self, at_most: Option<Duration>) -> bool {
        let reached = self.reached.lock().unwrap_or_else(PoisonError::into_inner);
        let not_yet = |reached: &mut bool| !*reached;
        match at_most {
            None => {
                *self.signal.wait_while(reached, not_yet).unwrap_or_else(PoisonError::into_inner)
            }
            Some(time) => {
                let waited = self.signal.wait_timeout_while(reached, time, not_yet);
                *waited.unwrap_or_else(PoisonError::into_inner).0
            }
        }
    }
}

pub(super) struct RunObject {
    run: Run,
    /// What it computes, for error messages: "a reshaping".
    kind: &'static str,
    result_type: TypeId,
    worker: Mutex<Option<JoinHandle<()>>>,
    end: Arc<End>,
    answer: Arc<Mutex<Option<Outcome<Answer>>>>,
}

impl RunObject {
    /// Starts `compute` on a thread of its own, over a pool of `thread_count` threads (0: all).
    pub fn start<T: Any + Send>(
        kind: &'static str,
        thread_count: usize,
        compute: impl FnOnce(&Run) -> Outcome<T> + Send + 'static,
    ) -> Outcome<Self> {
        let pool = thread_pool(thread_count)?;
        let run = Run::new();
        let answer = Arc::new(Mutex::new(None));
        let end = Arc::new(End::default());
        let (its_run, its_answer, its_end) = (run.clone(), Arc::clone(&answer), Arc::clone(&end));
        let work = move || {
            let done: Outcome<Answer> = catch_unwind(AssertUnwindSafe(|| {
                let computed = pool.install(|| compute(&its_run))?;
                if !its_run.is_cancelled() {
                    its_run.update(|p| p.fraction = 1.0);
                }
                Ok(Box::new(computed) as Answer)
            }))
            .unwrap_or_else(|panic| Err(panicked(panic.as_ref())));
            *its_answer.lock().unwrap_or_else(PoisonError::into_inner) = Some(done);
            its_end.tell();
        };
        let worker = std::thread::Builder::new()
            .name("moulage run".into())
            .spawn(work)
            .map_err(|e| Failure::invalid(format!("no thread could be started: {e}")))?;
        Ok(Self {
            run,
            kind,
            result_type: TypeId::of::<T>(),
            worker: Mutex::new(Some(worker)),
            end,
            answer,
        })
    }

    /// Waits for the end.
    fn join(&self) {
        let worker = self.worker.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(worker) = worker {
            // The worker catches its panics; there is nothing to learn here.
            let _ = worker.join();
        }
    }

    /// Waits for the result, once. A wait for another kind fails at once and takes nothing.
    fn take<T: Any>(&self) -> Outcome<T> {
        let kind = self.kind;
        let other_kind =
            || Failure::invalid(format!("this run is {kind}; wait with the function for its kind"));
        if TypeId::of::<T>() != self.result_type {
            return Err(other_kind());
        }
        self.join();
        let mut slot = self.answer.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(answer) = slot.take() else {
            return Err(Failure::invalid("the result of this run was waited for already"));
        };
        answer?.downcast::<T>().map(|boxed| *boxed).map_err(|_| other_kind())
    }
}

impl Drop for RunObject {
    fn drop(&mut self) {
        self.run.cancel();
        self.join();
    }
}

/// The result of a run, for the `mlg_run_wait_...` of its kind: waits for it.
pub(super) fn result_of<T: Any>(run: *mut MlgRun) -> Outcome<T> {
    handles::get::<RunObject, _>(run, "run")?.take()
}

/// Tells where a run stands; takes less than a microsecond. `out_progress`: its `struct_size` must
/// be set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_run_poll(
    run: *const MlgRun,
    out_progress: *mut MlgProgress,
    error: *mut MlgError,
) -> MlgStatus {
    access::fill((run, "run"), (out_progress, "out_progress"), error, |object: &RunObject| {
        let ended = object.end.wait(Some(Duration::ZERO));
        let now = object.run.progress();
        let mut progress = MlgProgress {
            struct_size: size_of::<MlgProgress>(),
            state: state(ended),
            iteration: now.iteration as u32,
            fraction: now.fraction,
            energy: now.energy,
            mean_error: now.mean_error,
            max_error: now.max_error,
            seconds: now.seconds,
            stage: [0; MLG_STAGE_SIZE],
        };
        write_text(&now.stage, &mut progress.stage);
        Ok(progress)
    })
}

/// Waits until a run has ended, at most `seconds`: 0 does not wait, INFINITY waits for the end.
/// `out_state`: `MLG_RUN_RUNNING` or `MLG_RUN_ENDED`. The result is handed over by the
/// `mlg_run_wait_...` of its kind.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mlg_run_wait_for(
    run: *const MlgRun,
    seconds: f64,
    out_state: *mut u32,
    error: *mut MlgError,
) -> MlgStatus {
    guard(error, || {
        buffers::check_out(out_state, "out_state")?;
        if seconds.is_nan() || seconds < 0.0 {
            return Err(Failure::invalid(format!("seconds is {seconds}; it is 0 or more")));
        }
        let object = handles::get::<RunObject, _>(run, "run")?;
        // A time beyond what the clock can say is for ever.
        let ended = object.end.wait(Duration::try_from_secs_f64(seconds).ok());
        // SAFETY: the caller's promise (see the module).
        unsafe { buffers::write(out_state, state(ended), "out_state") }
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

/// Copies the latest shape of the surface (registrations: of all bones, one after the other), for a
/// live view: `3 * *out_count` coordinates into `buffer`, which has room for `3 * capacity`.
/// `*out_count` is the number of points there are: 0 before the first shape; if it is above
/// `capacity`, nothing is copied. `buffer` may be NULL if `capacity` is 0.
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

fn state(ended: bool) -> u32 {
    if ended { MLG_RUN_ENDED } else { MLG_RUN_RUNNING }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_on_the_runs_thread_is_handed_over_as_a_failure() {
        let run = RunObject::start("a test", 1, |_| -> Outcome<u32> { panic!("forced {}", 7) });
        let run = run.unwrap();
        run.join();
        let failure = run.take::<u32>().unwrap_err();
        assert_eq!(failure.status, MlgStatus::Panic);
        assert_eq!(failure.message, "fault in the library: forced 7");
    }

    #[test]
    fn a_wait_ends_with_its_time_or_with_the_run() {
        let (release, held) = std::sync::mpsc::channel::<()>();
        let run = RunObject::start("a test", 1, move |_| Ok(held.recv().is_ok())).unwrap();
        assert!(
            !run.end.wait(Some(Duration::ZERO)) && !run.end.wait(Some(Duration::from_millis(5)))
        );
        release.send(()).unwrap();
        assert!(run.end.wait(None) && run.end.wait(Some(Duration::ZERO)));
        assert!(run.take::<bool>().unwrap());
    }

    #[test]
    fn a_result_is_handed_over_once_and_only_as_what_it_is() {
        let run = RunObject::start("a test", 0, |_| Ok(7_u32)).unwrap();
        run.join();
        let failure = run.take::<String>().unwrap_err();
        assert!(failure.message.starts_with("this run is a test;"), "{}", failure.message);
        assert_eq!(run.take::<u32>().unwrap(), 7);
        assert!(run.take::<u32>().is_err());
    }
}
