//! Jobs on as many threads as they ask for.

use crate::error::{Error, Result};

/// Does `work` on that many threads; on all of the machine if none are named.
pub(super) fn on_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T> + Send,
) -> Result<T> {
    let Some(threads) = threads else { return work() };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| Error::invalid(format!("{threads} threads cannot be started: {e}")))?;
    pool.install(work)
}
