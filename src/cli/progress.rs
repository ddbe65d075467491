//! A progress bar on the terminal, and Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Once, OnceLock};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use moulage::Run;

/// How often the bar is drawn.
const INTERVAL: Duration = Duration::from_millis(120);
/// Steps of the bar.
const STEPS: u64 = 1000;

/// Watches a run until dropped.
pub struct Progress {
    done: Arc<AtomicBool>,
    watcher: Option<JoinHandle<()>>,
}

impl Progress {
    /// Shows `run` on the terminal (nothing if standard error is none).
    pub fn watch(run: &Run) -> Self {
        let done = Arc::new(AtomicBool::new(false));
        let (run, stop) = (run.clone(), done.clone());
        let watcher = std::thread::spawn(move || {
            let bar = ProgressBar::new(STEPS);
            bar.set_style(
                ProgressStyle::with_template("{bar:30} {percent:>3}% {elapsed} {msg}")
                    .unwrap_or_else(|_| ProgressStyle::default_bar()),
            );
            while !stop.load(Ordering::Relaxed) {
                let state = run.progress();
                bar.set_position((state.fraction * STEPS as f64) as u64);
                let stage = if run.is_cancelled() { "stopping" } else { &state.stage };
                bar.set_message(if state.mean_error.is_finite() {
                    format!(
                        "{stage}, iteration {}: markers {:.3} off, at most {:.3}",
                        state.iteration, state.mean_error, state.max_error
                    )
                } else {
                    stage.to_owned()
                });
                std::thread::sleep(INTERVAL);
            }
            bar.finish_and_clear();
        });
        Self { done, watcher: Some(watcher) }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Relaxed);
        if let Some(watcher) = self.watcher.take() {
            let _ = watcher.join();
        }
    }
}

/// The first Ctrl-C asks `run` to stop with its best shape, the second ends the program at once.
pub fn stop_on_ctrl_c(run: &Run) {
    static RUN: OnceLock<Run> = OnceLock::new();
    static ONCE: Once = Once::new();
    let _ = RUN.set(run.clone());
    ONCE.call_once(|| {
        // Without a handler Ctrl-C ends the program, which is a fair second best.
        let _ = ctrlc::set_handler(|| {
            let Some(run) = RUN.get() else { return };
            if run.is_cancelled() {
                std::process::exit(i32::from(super::INTERRUPTED));
            }
            run.cancel();
            eprintln!("\nstopping with the best shape so far; again to stop at once");
        });
    });
}
