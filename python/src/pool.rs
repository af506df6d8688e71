//! A thread pool for each process.
//!
//! `fork` copies a process without its threads, so that a child that waits for rayon's global pool waits for ever. Each
//! process therefore has its own threads, started on first use.

use std::process;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::Python;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The thread pool and the process that it belongs to.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// The threads of this process; `None` if the system provides none, and the work is done on the calling thread.
///
/// A process that forks from Python holds the interpreter's lock, as does every caller of this function: no child finds
/// the pool locked.
pub(crate) fn threads(_: Python<'_>) -> Option<Arc<ThreadPool>> {
    let mut known = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let here = process::id();
    if let Some((of, pool)) = &*known
        && *of == here
    {
        return Some(Arc::clone(pool));
    }
    let pool = Arc::new(ThreadPoolBuilder::new().build().ok()?);
    // The parent's threads do not exist here, and cannot be told to end.
    std::mem::forget(known.replace((here, Arc::clone(&pool))));
    Some(pool)
}

/// The results of all work, in its order, with the interpreter lock released; in parallel, at least `least` together, if there
/// is more than one.
pub(crate) fn map<W: Send, R: Send>(
    py: Python<'_>,
    work: Vec<W>,
    least: usize,
    perform: impl Fn(W) -> R + Send + Sync,
) -> Vec<R> {
    let threads = if work.len() > 1 { threads(py) } else { None };
    py.detach(|| match threads {
        Some(threads) => threads.install(|| work.into_par_iter().with_min_len(least).map(perform).collect()),
        None => work.into_iter().map(perform).collect(),
    })
}
