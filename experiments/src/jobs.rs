//! Runs the jobs of an experiment in parallel.

use std::time::{Duration, Instant};

use rayon::ThreadPoolBuilder;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::ExperimentError;
use crate::progress::Progress;

/// The results of jobs.
pub struct Done<T> {
    /// One for each job, in their order.
    pub results: Vec<T>,
    /// Time and threads.
    pub effort: Effort,
}

/// The time and the threads that jobs took.
#[derive(Clone, Copy)]
pub struct Effort {
    /// Time from the first job's beginning to the last one's end.
    pub elapsed: Duration,
    /// Number of threads.
    pub threads: usize,
}

/// Runs all jobs on this many threads (by default one for each core); `progress` counts them in `units`. No job begins
/// after one has failed, or after the work is no longer wanted.
///
/// # Errors
/// If a job fails, the work is cancelled, or the system provides no threads.
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
    let order = spread(jobs.len());
    // One by one, since some take a thousand times as long as others.
    let mut results = pool.install(|| {
        let results = order.par_iter().with_max_len(1).map(|&index| {
            if work.is_cancelled() {
                return Err(ExperimentError::Cancelled);
            }
            let result = job(&jobs[index])?;
            work.advance(1);
            Ok((index, result))
        });
        results.collect::<Result<Vec<(usize, T)>, ExperimentError>>()
    })?;
    results.sort_unstable_by_key(|&(index, _)| index);
    let results = results.into_iter().map(|(_, result)| result).collect();
    Ok(Done { results, effort: Effort { elapsed: start.elapsed(), threads: pool.current_num_threads() } })
}

/// An order of `count` jobs in which those done so far are a fair sample of all, so that the remaining time can be
/// estimated: neighbors, which are often of one kind, are golden sections apart.
fn spread(count: usize) -> Vec<usize> {
    let section =
        (1..=count).find(|&step| step * 1000 >= count * 618 && are_coprime(step, count)).unwrap_or(1);
    (0..count).map(|place| place * section % count).collect()
}

const fn are_coprime(a: usize, b: usize) -> bool {
    let (mut a, mut b) = (a, b);
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a == 1
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;
    use crate::progress::Work;

    /// Steps announced and steps done.
    #[derive(Default)]
    struct Heard {
        announced: AtomicU64,
        done: Arc<AtomicU64>,
    }

    struct Counter(Arc<AtomicU64>);

    impl Progress for Heard {
        fn begin(&self, steps: u64, _unit: &str) -> Box<dyn Work> {
            self.announced.fetch_add(steps, Ordering::Relaxed);
            Box::new(Counter(Arc::clone(&self.done)))
        }
    }

    impl Work for Counter {
        fn advance(&self, steps: u64) {
            self.0.fetch_add(steps, Ordering::Relaxed);
        }
    }

    #[test]
    fn results_are_in_the_order_of_the_jobs_and_progress_counts_each() {
        for threads in [1, 3] {
            let received = Heard::default();
            let jobs: Vec<u64> = (0..50).collect();
            let done = run(&jobs, Some(threads), "jobs", &received, |&job| Ok(job * job)).unwrap();
            assert!(done.results.iter().copied().eq(jobs.iter().map(|job| job * job)));
            assert_eq!(done.effort.threads, usize::from(threads));
            let Heard { announced, done } = received;
            assert_eq!((announced.into_inner(), done.load(Ordering::Relaxed)), (50, 50));
        }
    }

    #[test]
    fn every_part_of_the_order_is_a_sample_of_all_jobs() {
        for count in [0, 1, 2, 3, 10, 618, 1000] {
            let mut order = spread(count);
            // Of each tenth of the order, about half lies in the first half of the jobs.
            for part in order.chunks(count / 10 + 1).filter(|part| part.len() >= 20) {
                let early = part.iter().filter(|&&index| index < count / 2).count();
                assert!((part.len() / 2).abs_diff(early) <= part.len() / 10, "{early} of {}", part.len());
            }
            order.sort_unstable();
            assert!(order.into_iter().eq(0..count));
        }
    }

    /// Is cancelled after some steps.
    struct Until(u64, Arc<AtomicU64>);

    impl Progress for Until {
        fn begin(&self, _steps: u64, _unit: &str) -> Box<dyn Work> {
            Box::new(Self(self.0, Arc::clone(&self.1)))
        }
    }

    impl Work for Until {
        fn advance(&self, steps: u64) {
            self.1.fetch_add(steps, Ordering::Relaxed);
        }

        fn is_cancelled(&self) -> bool {
            self.1.load(Ordering::Relaxed) >= self.0
        }
    }

    #[test]
    fn no_job_begins_after_the_work_is_cancelled() {
        let progress = Until(3, Arc::default());
        let begun = AtomicU64::new(0);
        let jobs: Vec<u64> = (0..50).collect();
        let ended = run(&jobs, Some(1), "jobs", &progress, |_| Ok(begun.fetch_add(1, Ordering::Relaxed)));
        assert!(matches!(ended, Err(ExperimentError::Cancelled)));
        assert_eq!(begun.into_inner(), 3);
    }

    #[test]
    fn a_job_that_fails_fails_all_and_is_not_counted_as_done() {
        let received = Heard::default();
        let refuse = |&job: &u64| {
            if job == 1 { Err(ExperimentError::Run(format!("job {job}"))) } else { Ok(job) }
        };
        let failed = run(&[0, 1, 2], Some(1), "jobs", &received, refuse);
        assert_eq!(failed.err().map(|error| error.to_string()).as_deref(), Some("job 1"));
        assert!(received.done.load(Ordering::Relaxed) < 3);
    }
}
