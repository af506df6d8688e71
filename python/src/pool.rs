//! Threads that share the work, in whichever process asks.
//!
//! `fork` copies a process without its threads, so that whoever waits for rayon's own in a child waits for ever. Each
//! process therefore has threads of its own, started when it first asks.

use std::process;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::Python;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The threads of a process, by its number.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// The threads of this process; none if the system gives none, and the work is done without.
///
/// Whoever forks from Python holds the interpreter's lock, and so does whoever calls this: no child finds the pool taken.
pub(crate) fn threads(_: Python<'_>) -> Option<Arc<ThreadPool>> {
    let mut known = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let here = process::id();
    if let Some((of, pool)) = &*known
        && *of == here
    {
        return Some(Arc::clone(pool));
    }
    let pool = Arc::new(ThreadPoolBuilder::new().build().ok()?);
    // Those of the parent are not here, and cannot be told to end.
    std::mem::forget(known.replace((here, Arc::clone(&pool))));
    Some(pool)
}
