//! When a vehicle stands, and how often it may tell of what it comes to know meanwhile.
//!
//! The team believes of a robot no more than some looks in the time in which it crosses a cell, and it tells of each cell
//! that it enters. So while it stands it tells no more than one in that time, but may save up a few.

use nalgebra::Vector2;

use super::PoseEstimate;

/// Who has come no farther than this stands, meters, and than so many standard deviations of its place.
const STILL_METERS: f64 = 0.25;
const STILL_DEVIATIONS: f64 = 3.0;
/// So long it has stood before it looks whether there is news, and so long after the last time, nanoseconds.
const PAUSE_NS: u64 = 2_000_000_000;
/// So many looks may be saved up.
const SAVED_LOOKS: u64 = 4;

/// Where a vehicle stands, and what it has told meanwhile.
#[derive(Clone, Debug, Default)]
pub(super) struct Standing {
    /// Where, meters east and north, and since when.
    place: Option<(Vector2<f64>, u64)>,
    /// When it last looked whether there is news.
    looked_ns: u64,
    /// Until when its looks would have lasted, were they no more often than it could enter cells.
    paid_ns: u64,
}

impl Standing {
    /// Takes in where the vehicle is.
    pub(super) fn note(&mut self, now_ns: u64, fix: &PoseEstimate) {
        let here = fix.pose.position_meters();
        let still_meters = STILL_METERS + STILL_DEVIATIONS * fix.deviation_meters;
        if self.place.is_none_or(|(place, _)| (here - place).norm() > still_meters) {
            self.place = Some((here, now_ns));
        }
    }

    /// The clock was set, or the vehicle is elsewhere: nothing from before means anything.
    pub(super) fn forget(&mut self, now_ns: u64) {
        *self = Self { place: None, looked_ns: now_ns, paid_ns: now_ns };
    }

    /// Whether it has stood for so long, since it told of its cell too, that it may look for news. `cell_ns`: how long it
    /// takes across a cell at full speed.
    pub(super) fn may_look(&mut self, now_ns: u64, told_ns: u64, cell_ns: u64) -> bool {
        let Some((_, since_ns)) = self.place else { return false };
        let begun_ns = since_ns.max(told_ns).max(self.looked_ns);
        let saved_ns = cell_ns.saturating_mul(SAVED_LOOKS - 1);
        let may_look =
            now_ns.saturating_sub(begun_ns) >= PAUSE_NS && self.paid_ns <= now_ns.saturating_add(saved_ns);
        if may_look {
            self.looked_ns = now_ns;
        }
        may_look
    }

    /// It has told.
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
    fn a_few_looks_come_at_once_and_then_one_for_each_cell_that_could_have_been_entered() {
        let mut standing = Standing::default();
        let mut looks = Vec::new();
        for tenth in 0..1000 {
            let now_ns = tenth * SECOND / 10;
            standing.note(now_ns, &fix(5.0, 0.05));
            if standing.may_look(now_ns, 0, 15 * SECOND) {
                standing.pay(now_ns, 15 * SECOND);
                looks.push(now_ns as f64 / 1e9);
            }
        }
        assert_eq!(looks, [2.0, 4.0, 6.0, 8.0, 17.0, 32.0, 47.0, 62.0, 77.0, 92.0]);
    }

    #[test]
    fn who_drives_does_not_stand_and_who_is_badly_located_may() {
        for (deviation_meters, stands) in [(0.05, false), (2.0, true)] {
            let mut standing = Standing::default();
            let mut may_look = false;
            for tenth in 0..30 {
                let now_ns = tenth * SECOND / 10;
                standing.note(now_ns, &fix(tenth as f64 * 0.2, deviation_meters));
                may_look |= standing.may_look(now_ns, 0, SECOND);
            }
            assert_eq!(may_look, stands, "{deviation_meters} m");
        }
    }
}
