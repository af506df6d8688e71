//! The forecast of a plan: at most one at a time, on a thread of its own. A new one ends the one before.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use dragnet_scenario::Scenario;
use serde_json::{Value, json};

use super::Desk;

/// The largest team, as in scenarios.
const MOST_ROBOTS: u32 = 1_000;
/// Teams up to this size are all simulated; of larger ones each is twice as large as the one before.
const MOST_OF_EACH: u32 = 6;
/// The most missions of one team.
const MOST_MISSIONS: u64 = 1_000;
/// Missions after which the time that is left is estimated.
const FIRST_MISSIONS: u64 = 4;

/// The progress of a forecast, and whether it is still wanted.
#[derive(Debug, Default)]
pub struct Watched {
    done: AtomicU64,
    total: AtomicU64,
    is_cancelled: AtomicBool,
}

impl Watched {
    /// Stores the number of missions.
    pub fn begin(&self, missions: u64) {
        self.total.store(missions, Ordering::Relaxed);
    }

    /// Counts further missions.
    pub fn advance(&self, missions: u64) {
        self.done.fetch_add(missions, Ordering::Relaxed);
    }

    /// Whether the forecast is not wanted any more.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }
}

/// A forecast that is asked for.
pub(super) struct Asked {
    /// The revision of the plan.
    pub(super) revision: u64,
    pub(super) scenario: Scenario,
    /// Numbers of robots.
    pub(super) teams: Vec<u32>,
    /// Missions of each team.
    pub(super) missions: u64,
}

/// The forecast that is made, or was made last.
#[derive(Default)]
pub(super) struct Forecasts(Mutex<Option<Forecast>>);

struct Forecast {
    revision: u64,
    watched: Arc<Watched>,
    begun: Instant,
    /// Its teams, or why there are none; `None` while it is made.
    result: Option<Result<Value, String>>,
}

/// The team sizes up to the largest one.
pub(super) fn teams(robots: u32, missions: u64) -> Result<Vec<u32>, String> {
    if !(1..=MOST_ROBOTS).contains(&robots) {
        return Err(format!("{robots} robots; allowed are 1 to {MOST_ROBOTS}"));
    }
    if !(1..=MOST_MISSIONS).contains(&missions) {
        return Err(format!("{missions} missions; allowed are 1 to {MOST_MISSIONS}"));
    }
    if robots <= MOST_OF_EACH {
        return Ok((1..=robots).collect());
    }
    let doubled = std::iter::successors(Some(1_u32), |size| size.checked_mul(2));
    Ok(doubled.take_while(|&size| size < robots).chain([robots]).collect())
}

/// Minutes until all missions are done, if the rest takes as long for each as those did that are done; rounded up, so that
/// a page has news only once a minute. Unknown before the first ones.
fn minutes_left([done, total]: [u64; 2], elapsed: Duration) -> Option<f64> {
    let rest = total.saturating_sub(done) as f64;
    let minutes = elapsed.as_secs_f64() / 60.0 * rest / done as f64;
    (done >= FIRST_MISSIONS).then(|| minutes.ceil())
}

impl Forecasts {
    /// Begins a forecast, and ends the one before.
    pub(super) fn begin(desk: &Arc<Desk>, asked: Asked) {
        let watched = Arc::new(Watched::default());
        let begun = Instant::now();
        let forecast =
            Forecast { revision: asked.revision, watched: Arc::clone(&watched), begun, result: None };
        if let Some(before) = desk.forecasts.last().replace(forecast) {
            before.watched.is_cancelled.store(true, Ordering::Relaxed);
        }
        let desk = Arc::clone(desk);
        tokio::task::spawn_blocking(move || {
            let Asked { scenario, teams, missions, .. } = asked;
            let result = desk.planner.forecast(&scenario, &teams, missions, Arc::clone(&watched));
            let mut last = desk.forecasts.last();
            // Not that of the forecast that has taken its place.
            if let Some(forecast) = last.as_mut().filter(|it| Arc::ptr_eq(&it.watched, &watched)) {
                forecast.result = Some(result);
            }
        });
    }

    /// Ends the forecast that is made, if there is one.
    pub(super) fn cancel(&self) {
        let mut last = self.last();
        if last.as_ref().is_some_and(|forecast| forecast.result.is_none())
            && let Some(forecast) = last.take()
        {
            forecast.watched.is_cancelled.store(true, Ordering::Relaxed);
        }
    }

    pub(super) fn state(&self) -> Value {
        let last = self.last();
        let Some(Forecast { revision, watched, begun, result }) = last.as_ref() else { return Value::Null };
        let progress = [&watched.done, &watched.total].map(|count| count.load(Ordering::Relaxed));
        match result {
            None => json!({
                "revision": revision,
                "state": "running",
                "progress": progress,
                "minutes_left": minutes_left(progress, begun.elapsed()),
            }),
            Some(Ok(teams)) => json!({ "revision": revision, "state": "done", "teams": teams }),
            Some(Err(why)) => json!({ "revision": revision, "state": "failed", "why": why }),
        }
    }

    fn last(&self) -> MutexGuard<'_, Option<Forecast>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_follows_from_the_first_missions() {
        let check = |done, seconds, minutes: Option<&str>| {
            let found = minutes_left([done, 80], Duration::from_secs(seconds)).map(|it| it.to_string());
            assert_eq!(found.as_deref(), minutes, "{done} after {seconds} s");
        };
        check(0, 60, None);
        check(3, 60, None);
        check(20, 60, Some("3"));
        check(40, 70, Some("2"));
        check(79, 60, Some("1"));
        check(80, 600, Some("0"));
    }

    #[test]
    fn small_teams_are_all_forecast_and_larger_ones_are_doubled() {
        assert_eq!(teams(1, 1), Ok(vec![1]));
        assert_eq!(teams(4, 50), Ok(vec![1, 2, 3, 4]));
        assert_eq!(teams(20, 50), Ok(vec![1, 2, 4, 8, 16, 20]));
        assert_eq!(teams(8, 50), Ok(vec![1, 2, 4, 8]));
        assert!(teams(0, 50).unwrap_err().contains("1 to 1000"));
        assert!(teams(1, 0).unwrap_err().contains("1 to 1000"));
    }
}
