//! Many jobs of one command, side by side.

use std::fmt;
use std::time::{Duration, Instant};

use rayon::ThreadPoolBuilder;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::Failure;
use crate::terminal::{counted, progress};

/// What jobs came to.
pub(super) struct Done<T> {
    /// Of each, in their order.
    pub(super) results: Vec<T>,
    pub(super) effort: Effort,
}

/// What jobs took.
#[derive(Clone, Copy)]
pub(super) struct Effort {
    pub(super) elapsed: Duration,
    pub(super) threads: usize,
}

/// Does all jobs, so many at a time (without a number, as many as there are cores), behind a progress bar that counts
/// `units`. No job begins after one failed.
pub(super) fn run<J: Sync, T: Send>(
    jobs: &[J],
    threads: Option<u16>,
    units: &'static str,
    job: impl Fn(&J) -> Result<T, Failure> + Sync,
) -> Result<Done<T>, Failure> {
    let threads = usize::from(threads.unwrap_or(0));
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(Failure::run)?;
    let bar = progress::alone(jobs.len() as u64, units);
    let start = Instant::now();
    // One by one, since some take a thousand times as long as others.
    let results = pool.install(|| {
        let results = jobs.par_iter().with_max_len(1).map(|it| job(it).inspect(|_| bar.inc(1)));
        results.collect::<Result<Vec<T>, Failure>>()
    })?;
    bar.finish_and_clear();
    Ok(Done { results, effort: Effort { elapsed: start.elapsed(), threads: pool.current_num_threads() } })
}

/// `in 1.5 s on 2 threads`
impl fmt::Display for Effort {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "in {:.1} s on {}", self.elapsed.as_secs_f64(), counted(self.threads, "thread"))
    }
}
