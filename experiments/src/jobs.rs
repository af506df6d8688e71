//! Many jobs of one experiment, side by side.

use std::time::{Duration, Instant};

use rayon::ThreadPoolBuilder;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::ExperimentError;
use crate::progress::Progress;

/// What jobs came to.
pub struct Done<T> {
    /// Of each, in their order.
    pub results: Vec<T>,
    /// What they took.
    pub effort: Effort,
}

/// What jobs took.
#[derive(Clone, Copy)]
pub struct Effort {
    /// Time from the first job's beginning to the last one's end.
    pub elapsed: Duration,
    /// How many jobs ran at a time.
    pub threads: usize,
}

/// Does all jobs, so many at a time (without a number, as many as there are cores); `progress` hears of each, counted in
/// `units`. No job begins after one failed.
///
/// # Errors
/// If a job fails, or the system gives no threads.
pub fn run<J: Sync, T: Send>(
    jobs: &[J],
    threads: Option<u16>,
    units: &str,
    progress: &dyn Progress,
    job: impl Fn(&J) -> Result<T, ExperimentError> + Sync,
) -> Result<Done<T>, ExperimentError> {
    let threads = usize::from(threads.unwrap_or(0));
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(ExperimentError::run)?;
    let work = progress.begin(jobs.len() as u64, units);
    let start = Instant::now();
    // One by one, since some take a thousand times as long as others.
    let results = pool.install(|| {
        let results = jobs.par_iter().with_max_len(1).map(|it| job(it).inspect(|_| work.advance(1)));
        results.collect::<Result<Vec<T>, ExperimentError>>()
    })?;
    Ok(Done { results, effort: Effort { elapsed: start.elapsed(), threads: pool.current_num_threads() } })
}
