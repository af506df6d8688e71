//! A robot that is not moved: it waits for its first readings, or for those of the next cell of its path, and nothing
//! else tells a person so.

use std::fmt;
use std::time::Duration;

use dragnet_scenario::Scenario;
use dragnet_search::cell::Cell;

/// Time beyond that of two moves after which a robot says what it waits for.
const PATIENCE: Duration = Duration::from_secs(30);
/// Time until it says so again.
const PERIOD: Duration = Duration::from_mins(1);

/// What moves a robot, and sends its readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mover {
    /// The simulator, or a vehicle that speaks Dragnet's own messages.
    Simulator,
    /// The vehicle that its settings describe.
    Vehicle,
}

/// What a robot expects of what moves it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expected {
    mover: Mover,
    /// Time, by the wall clock, without readings that is usual.
    usual: Duration,
}

impl Expected {
    /// What a robot of a scenario expects, at this real-time factor.
    #[must_use]
    pub fn of(mover: Mover, scenario: &Scenario, real_time_factor: f64) -> Self {
        let mission = scenario.mission();
        let cell_meters = scenario.terrain().cell_meters();
        let steps = scenario.robots().iter().map(|robot| robot.class.step_time(cell_meters));
        let step_seconds = steps.max().unwrap_or_default().as_secs_f64();
        let turns = u32::try_from(scenario.robots().len()).unwrap_or(u32::MAX);
        // The simulator begins with one robot after the other.
        let start_seconds = mission.stagger.saturating_mul(turns).as_secs_f64();
        let usual_seconds = (2.0 * step_seconds + start_seconds) / real_time_factor;
        Self { mover, usual: Duration::try_from_secs_f64(usual_seconds).unwrap_or(Duration::MAX) }
    }
}

/// What a robot waits for. Times are by one monotonic clock.
#[derive(Clone, Debug)]
pub(crate) struct Progress {
    expected: Option<Expected>,
    has_sensed: bool,
    /// The end of its path, if it is not to stay where it is.
    waypoint: Option<Cell>,
    /// When readings or a path last arrived.
    since: Duration,
    /// When it last said what it waits for since then.
    reported: Option<Duration>,
}

/// Nothing has arrived for long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Standstill {
    mover: Mover,
    has_sensed: bool,
    lasts: Duration,
}

impl Progress {
    /// A robot that starts; `None` if nothing is to be expected, as for a coordinator.
    pub(crate) const fn new(expected: Option<Expected>) -> Self {
        Self { expected, has_sensed: false, waypoint: None, since: Duration::ZERO, reported: None }
    }

    /// Readings arrive.
    pub(crate) fn sense(&mut self, now: Duration) {
        self.has_sensed = true;
        (self.since, self.reported) = (now, None);
    }

    /// The robot has a new path: an empty one if it stays where it is.
    pub(crate) fn route(&mut self, now: Duration, route: &[Cell]) {
        self.waypoint = route.last().copied();
        (self.since, self.reported) = (now, None);
    }

    /// When there is something to say, if nothing happens before.
    pub(crate) fn due(&self) -> Option<Duration> {
        let usual = self.expected.filter(|_| self.waypoint.is_some() || !self.has_sensed)?.usual;
        let first = self.since.saturating_add(usual).saturating_add(PATIENCE);
        Some(self.reported.map_or(first, |reported| reported + PERIOD))
    }

    /// What is to be said now.
    pub(crate) fn tell(&mut self, now: Duration) -> Option<Standstill> {
        if now < self.due()? {
            return None;
        }
        self.reported = Some(now);
        let (mover, has_sensed) = (self.expected?.mover, self.has_sensed);
        Some(Standstill { mover, has_sensed, lasts: now.saturating_sub(self.since) })
    }
}

/// What lacks, and what to do.
impl fmt::Display for Standstill {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = self.lasts.as_secs();
        match (self.mover, self.has_sensed) {
            (Mover::Simulator, false) => write!(
                formatter,
                "no readings for {seconds} s, so it does not know its cell: its settings have no [vehicle], so `dragnet sim` \
                 moves it; start that for the same mission, and see that one of the two connects to the other"
            ),
            (Mover::Simulator, true) => write!(
                formatter,
                "no readings for {seconds} s, so it does not move: see that `dragnet sim` still runs and is connected; if it \
                 is started again the robot goes on"
            ),
            (Mover::Vehicle, false) => write!(
                formatter,
                "no readings of its vehicle for {seconds} s, so it does not know its cell: its diagnostics and `dragnet doctor` \
                 say what is missing"
            ),
            (Mover::Vehicle, true) => write!(
                formatter,
                "its vehicle has entered no cell for {seconds} s: see that it follows the paths or goals that are published, \
                 and that nothing is in its way; its diagnostics and `dragnet doctor` say what is missing"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::cell::Grid;

    use super::*;

    const USUAL: Duration = Duration::from_secs(10);

    fn progress(mover: Mover) -> Progress {
        Progress::new(Some(Expected { mover, usual: USUAL }))
    }

    fn seconds(seconds: u64) -> Duration {
        Duration::from_secs(seconds)
    }

    fn cell() -> Cell {
        Grid::new(2, 2).unwrap().cells().last().unwrap()
    }

    #[test]
    fn a_robot_without_readings_says_so_after_a_while_and_then_each_minute() {
        let mut progress = progress(Mover::Simulator);
        assert_eq!(progress.due(), Some(seconds(40)));
        let told: Vec<u64> = (0..200).filter(|&second| progress.tell(seconds(second)).is_some()).collect();
        assert_eq!(told, [40, 100, 160]);
        let line = progress.tell(seconds(220)).unwrap().to_string();
        assert!(line.starts_with("no readings for 220 s") && line.contains("`dragnet sim`"), "{line}");
        // As one that has to stand, and may go on before it knows its cell.
        progress.route(seconds(221), &[]);
        assert_eq!(progress.due(), Some(seconds(261)));
    }

    #[test]
    fn readings_begin_it_anew_and_a_robot_that_rests_waits_for_nothing() {
        let mut progress = progress(Mover::Vehicle);
        progress.route(seconds(5), &[cell()]);
        progress.sense(seconds(30));
        assert_eq!(progress.tell(seconds(69)), None);
        let told = progress.tell(seconds(70)).unwrap();
        assert_eq!((told.has_sensed, told.lasts), (true, seconds(40)));
        assert!(told.to_string().contains("entered no cell for 40 s"), "{told}");
        progress.route(seconds(71), &[]);
        assert_eq!((progress.due(), progress.tell(seconds(1000))), (None, None));
        progress.sense(seconds(1001));
        assert_eq!(progress.due(), None, "it still rests");
        progress.route(seconds(1002), &[cell()]);
        assert_eq!(progress.due(), Some(seconds(1042)));
    }

    #[test]
    fn a_slow_robot_and_a_large_team_are_given_time() {
        let scenario = |speed: f64| {
            let text = format!(
                "name = 'slow'\nmap = {{ shape = 'all_traversable', rows = 5, columns = 5, cell_meters = 10.0 }}\n\
                 objects.count = 1\nrobots.count = 4\nmission = {{ budget_seconds = 900.0, speed_meters_per_second = {speed:?}, \
                 start_stagger_seconds = 3.0 }}\n"
            );
            Scenario::from_text(std::path::Path::new("slow.toml"), text).unwrap()
        };
        let usual = |speed, factor| Expected::of(Mover::Vehicle, &scenario(speed), factor).usual.as_secs();
        assert_eq!(usual(1.0, 1.0), 28 + 12);
        assert_eq!(usual(1.0, 10.0), 4);
        assert_eq!(usual(1e-3, 1.0), 2 * 3600 + 12);
    }

    #[test]
    fn a_coordinator_waits_for_nothing() {
        let mut nothing = Progress::new(None);
        assert_eq!((nothing.due(), nothing.tell(seconds(1000))), (None, None));
    }
}
