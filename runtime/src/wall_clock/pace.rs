//! Detects that the mission time of others runs faster than here, as if their `real_time_factor` were another.

use std::time::Duration;

/// Time over which adjustments of the clock are compared with the time that has passed.
const WINDOW: Duration = Duration::from_secs(10);
/// Adjustments within it, at least. A team that is met again sets the clock once or twice.
const LEAST_ADJUSTMENTS: u32 = 5;
/// Adjustments without the largest, together, as a share of the mission time that has passed. Clocks of computers
/// differ by less than a thousandth.
const LEAST_SHARE: f64 = 0.02;

/// The adjustments of a window.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pace {
    window: Option<Window>,
    /// Whether it ran faster in the last window: while a team gathers, it may seem so in one.
    was_faster: bool,
}

#[derive(Clone, Copy, Debug)]
struct Window {
    began: Duration,
    adjustments: u32,
    sum: Duration,
    largest: Duration,
}

impl Pace {
    /// Takes an adjustment of mission time, at a time since the process started, and returns how many times as fast as
    /// here the mission's time runs, at the end of the second window in which it ran faster.
    pub(super) fn adjust(&mut self, local: Duration, by: Duration, real_time_factor: f64) -> Option<f64> {
        if by.is_zero() {
            return None;
        }
        let fresh = Window { began: local, adjustments: 0, sum: Duration::ZERO, largest: Duration::ZERO };
        let window = self.window.get_or_insert(fresh);
        window.adjustments += 1;
        window.sum += by;
        window.largest = window.largest.max(by);
        let elapsed = local.saturating_sub(window.began);
        if elapsed < WINDOW {
            return None;
        }
        let Window { adjustments, sum, largest, .. } = *window;
        self.window = None;
        let share = sum.saturating_sub(largest).div_duration_f64(elapsed.mul_f64(real_time_factor));
        let is_faster = adjustments >= LEAST_ADJUSTMENTS && share >= LEAST_SHARE;
        let was_faster = std::mem::replace(&mut self.was_faster, is_faster);
        (is_faster && was_faster).then_some(1.0 + share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adjustments at these times, seconds.
    fn first_told(adjustments: impl IntoIterator<Item = (f64, f64)>, factor: f64) -> Option<f64> {
        let mut pace = Pace::default();
        adjustments.into_iter().find_map(|(local, by)| {
            pace.adjust(Duration::from_secs_f64(local), Duration::from_secs_f64(by), factor)
        })
    }

    #[test]
    fn another_factor_is_told_and_a_team_that_is_met_again_is_not() {
        // Heartbeats each half second, at ten times real time here and twenty there.
        let twice = first_told((0..60).map(|beat| (f64::from(beat) / 2.0, 5.0)), 10.0).unwrap();
        assert!((twice - 2.0).abs() < 0.02, "{twice}");
        let met = [(1.0, 300.0), (1.1, 0.2), (15.0, 0.1), (30.0, 250.0), (45.0, 0.1), (60.0, 0.2)];
        assert_eq!(first_told(met, 1.0), None);
        // Fifty robots that start one after the other.
        let gathering = (0..50).map(|robot| (f64::from(robot) / 20.0, 1.0)).chain([(12.0, 0.1), (40.0, 0.1)]);
        assert_eq!(first_told(gathering, 1.0), None);
        // The clock of a bad computer, and messages of unlike delay.
        let drift = (0..4000).map(|beat| (f64::from(beat) / 2.0, 0.0005));
        assert_eq!(first_told(drift, 1.0), None);
    }
}
