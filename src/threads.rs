//! As many threads as are asked for.

use crate::error::{Error, Result};

/// More threads than any machine has cores only take memory, and minutes to start.
const MAX_THREADS: usize = 1024;

/// So many threads to compute on; 0: one per core.
pub fn thread_pool(count: usize) -> Result<rayon::ThreadPool> {
    if count > MAX_THREADS {
        return Err(Error::invalid(format!(
            "{count} threads are too many: ask for {MAX_THREADS} at most, or for 0, one per core"
        )));
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .thread_name(|i| format!("moulage {i}"))
        .build()
        .map_err(|e| Error::invalid(format!("{count} threads cannot be started: {e}")))
}

/// Does `work` on that many threads; on all of the machine if none are named.
pub fn on_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T> + Send,
) -> Result<T> {
    match threads {
        Some(count) => thread_pool(count)?.install(work),
        None => work(),
    }
}
