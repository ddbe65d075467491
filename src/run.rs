//! A long computation seen from outside: progress, cancel, live preview.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use nalgebra::Vector3;

/// Shared between the thread that computes and those that watch. Cloning gives another handle on
/// the same run.
#[derive(Clone, Debug)]
pub struct Run {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    cancelled: AtomicBool,
    started: Instant,
    progress: Mutex<Progress>,
    preview: Mutex<Option<Vec<Vector3<f64>>>>,
}

/// The latest state of a run. Lengths are in the template's unit.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    /// What is being done, in words for the user.
    pub stage: String,
    /// Share of the work done, 0 to 1, never falling.
    pub fraction: f64,
    /// Iterations of the outer loop so far.
    pub iteration: usize,
    /// Latest value of the objective.
    pub energy: f64,
    /// Mean distance of the markers to the shape; NaN while unknown.
    pub mean_error: f64,
    /// Largest distance of a marker to the shape; NaN while unknown.
    pub max_error: f64,
    /// Seconds since the run was made.
    pub seconds: f64,
}

impl Default for Run {
    fn default() -> Self {
        Self::new()
    }
}

impl Run {
    /// A run that nobody has cancelled yet; its clock starts here.
    pub fn new() -> Self {
        let progress = Progress {
            stage: "starting".into(),
            mean_error: f64::NAN,
            max_error: f64::NAN,
            ..Progress::default()
        };
        Self {
            shared: Arc::new(Shared {
                cancelled: AtomicBool::new(false),
                started: Instant::now(),
                progress: Mutex::new(progress),
                preview: Mutex::new(None),
            }),
        }
    }

    /// Asks the computation to stop; it keeps its best result. Sticky, callable from any thread.
    pub fn cancel(&self) {
        self.shared.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether [`Run::cancel`] was called.
    pub fn is_cancelled(&self) -> bool {
        self.shared.cancelled.load(Ordering::Relaxed)
    }

    /// Changes the progress; the fraction never falls.
    pub fn update(&self, change: impl FnOnce(&mut Progress)) {
        let mut progress = lock(&self.shared.progress);
        let before = progress.fraction;
        change(&mut progress);
        progress.fraction = progress.fraction.clamp(before, 1.0);
    }

    /// Names the stage and the fraction done when it starts.
    pub fn enter(&self, stage: &str, fraction: f64) {
        self.update(|p| {
            stage.clone_into(&mut p.stage);
            p.fraction = fraction;
        });
    }

    /// The latest progress.
    pub fn progress(&self) -> Progress {
        let mut progress = lock(&self.shared.progress).clone();
        progress.seconds = self.shared.started.elapsed().as_secs_f64();
        progress
    }

    /// Publishes the current shape for a live view.
    pub fn publish_preview(&self, points: &[Vector3<f64>]) {
        *lock(&self.shared.preview) = Some(points.to_vec());
    }

    /// The latest published shape, if any.
    pub fn preview(&self) -> Option<Vec<Vector3<f64>>> {
        lock(&self.shared.preview).clone()
    }
}

/// The data behind these locks stays valid whatever panicked while holding one.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fraction_never_falls_and_cancel_is_sticky() {
        let run = Run::new();
        let watcher = run.clone();
        run.update(|p| p.fraction = 0.5);
        run.update(|p| p.fraction = 0.2);
        assert!((watcher.progress().fraction - 0.5).abs() < 1e-15);
        watcher.cancel();
        assert!(run.is_cancelled());
    }
}
