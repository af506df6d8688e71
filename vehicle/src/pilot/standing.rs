//! Limits the observations of a standing vehicle.
//!
//! The team accepts only some observations of a robot in the time in which it crosses a cell, and each entered cell
//! needs one. So a standing vehicle makes at most one in that time, but may save up a few.

use nalgebra::Vector2;

use super::PoseEstimate;

/// Distance up to which a vehicle counts as standing, meters, and in standard deviations of its position.
const STILL_METERS: f64 = 0.25;
const STILL_DEVIATIONS: f64 = 3.0;
/// Time between checks for news, nanoseconds.
const PAUSE_NS: u64 = 2_000_000_000;
/// The maximum number of saved observations.
const SAVED_OBSERVATIONS: u64 = 4;

/// Position of a standing vehicle, and its observations there.
#[derive(Clone, Debug, Default)]
pub(super) struct Standing {
    /// Position, meters east and north, and since when.
    place: Option<(Vector2<f64>, u64)>,
    /// Whether it has ever moved.
    has_moved: bool,
    /// When it last checked for news.
    checked_ns: u64,
    /// The time up to which its observations are used up, at the rate of entering cells.
    paid_ns: u64,
}

impl Standing {
    /// Updates the position.
    pub(super) fn note(&mut self, now_ns: u64, fix: &PoseEstimate) {
        let here = fix.pose.position_meters();
        let still_meters = STILL_METERS + STILL_DEVIATIONS * fix.deviation_meters;
        if self.place.is_none_or(|(place, _)| (here - place).norm() > still_meters) {
            self.has_moved |= self.place.is_some();
            self.place = Some((here, now_ns));
        }
    }

    /// The clock was set, or the vehicle is elsewhere: earlier times have no meaning.
    pub(super) fn forget(&mut self, now_ns: u64) {
        *self = Self { place: None, checked_ns: now_ns, paid_ns: now_ns, ..*self };
    }

    /// Since when a vehicle that has moved before stands in one place.
    pub(super) fn since_ns(&self) -> Option<u64> {
        self.place.filter(|_| self.has_moved).map(|(_, since_ns)| since_ns)
    }

    /// Whether it has stood for long enough since its last report to check for news. `cell_ns`: the time to cross a
    /// cell at full speed.
    pub(super) fn may_observe(&mut self, now_ns: u64, reported_ns: u64, cell_ns: u64) -> bool {
        let Some((_, since_ns)) = self.place else { return false };
        let begun_ns = since_ns.max(reported_ns).max(self.checked_ns);
        let saved_ns = cell_ns.saturating_mul(SAVED_OBSERVATIONS - 1);
        let may_observe =
            now_ns.saturating_sub(begun_ns) >= PAUSE_NS && self.paid_ns <= now_ns.saturating_add(saved_ns);
        if may_observe {
            self.checked_ns = now_ns;
        }
        may_observe
    }

    /// It has made an observation.
    pub(super) fn pay(&mut self, now_ns: u64, cell_ns: u64) {
        self.paid_ns = self.paid_ns.max(now_ns).saturating_add(cell_ns);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dragnet_lattice::plane::Pose;

    const SECOND: u64 = 1_000_000_000;

    fn fix(east: f64, deviation_meters: f64) -> PoseEstimate {
        let pose = Pose::new(east, 5.0, 0.0);
        PoseEstimate { time_ns: 0, pose, deviation_meters, heading_deviation_radians: 0.01 }
    }

    #[test]
    fn a_few_observations_need_no_time_and_then_one_fits_each_cell_that_could_have_been_entered() {
        let mut standing = Standing::default();
        let mut observations = Vec::new();
        for tenth in 0..1000 {
            let now_ns = tenth * SECOND / 10;
            standing.note(now_ns, &fix(5.0, 0.05));
            if standing.may_observe(now_ns, 0, 15 * SECOND) {
                standing.pay(now_ns, 15 * SECOND);
                observations.push(now_ns as f64 / 1e9);
            }
        }
        assert_eq!(observations, [2.0, 4.0, 6.0, 8.0, 17.0, 32.0, 47.0, 62.0, 77.0, 92.0]);
    }

    #[test]
    fn a_driving_vehicle_does_not_stand_and_a_badly_located_one_may() {
        for (deviation_meters, stands) in [(0.05, false), (2.0, true)] {
            let mut standing = Standing::default();
            let mut may_observe = false;
            for tenth in 0..30 {
                let now_ns = tenth * SECOND / 10;
                standing.note(now_ns, &fix(tenth as f64 * 0.2, deviation_meters));
                may_observe |= standing.may_observe(now_ns, 0, SECOND);
            }
            assert_eq!(may_observe, stands, "{deviation_meters} m");
        }
    }
}
