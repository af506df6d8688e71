//! Validation of poses and times.
//!
//! A pose that is farther from the last good one than the vehicle can have driven is a jump. It is rejected; the new
//! position is accepted only when poses have agreed with each other for the recovery time. A clock that was set back is
//! treated alike.

use std::collections::VecDeque;

use dragnet_search::terrain::Terrain;

use super::diagnostic::Fault;
use super::{PoseEstimate, seconds, stamp};
use crate::settings::Checked;
use dragnet_lattice::plane::{Pose, turn_radians, wrapped_radians};

/// Factor by which poses may exceed full speed.
const SPEED_TOLERANCE: f64 = 1.2;
/// Additional distance, in standard deviations.
const DEVIATIONS: f64 = 5.0;
/// Additional distance, meters.
const SLACK_METERS: f64 = 0.5;
/// Number of poses that are kept for late frames.
const KEPT_FIXES: usize = 256;

/// The result of validating a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Judgment {
    Good,
    /// It is already known.
    Repeated,
    /// It contradicts the earlier ones, and has been consistent for long enough.
    Restarted,
    Doubtful,
}

/// The caller's time.
#[derive(Clone, Debug)]
pub(super) struct Clock {
    recovery_ns: u64,
    latest_ns: u64,
    /// First and last reading of a clock that was set back.
    doubted: Option<(u64, u64)>,
}

impl Clock {
    pub(super) const fn new(recovery_ns: u64) -> Self {
        Self { recovery_ns, latest_ns: 0, doubted: None }
    }

    pub(super) const fn now_ns(&self) -> u64 {
        self.latest_ns
    }

    pub(super) fn read(&mut self, now_ns: u64) -> Judgment {
        if now_ns >= self.latest_ns {
            self.latest_ns = now_ns;
            self.doubted = None;
            return Judgment::Good;
        }
        let (first, last) = self.doubted.filter(|&(_, last)| now_ns >= last).unwrap_or((now_ns, now_ns));
        self.doubted = Some((first, now_ns.max(last)));
        if now_ns - first < self.recovery_ns {
            return Judgment::Doubtful;
        }
        self.latest_ns = now_ns;
        self.doubted = None;
        Judgment::Restarted
    }
}

/// The vehicle's accepted poses.
#[derive(Clone, Debug)]
pub(super) struct Localization {
    speed_meters_per_second: f64,
    max_position_std_meters: f64,
    recovery_ns: u64,
    /// Maximum difference between a pose's stamp and now.
    max_age_ns: u64,
    /// By time, each once.
    fixes: VecDeque<PoseEstimate>,
    /// When the last of them arrived; before the first, when it was expected to.
    received_ns: Option<u64>,
    /// When the last repeated or rejected pose arrived.
    unused_ns: Option<u64>,
    /// The stamp of the last pose, accepted or not.
    stamp_ns: Option<u64>,
    /// Since when poses are known.
    known_since_ns: Option<u64>,
    /// First and last of the consistent poses elsewhere.
    elsewhere: Option<(PoseEstimate, PoseEstimate)>,
}

impl Localization {
    pub(super) fn new(settings: &Checked) -> Self {
        Self {
            speed_meters_per_second: settings.speed_meters_per_second,
            max_position_std_meters: settings.max_position_std_meters,
            recovery_ns: settings.recovery_ns,
            max_age_ns: settings.pose_timeout_ns,
            fixes: VecDeque::new(),
            received_ns: None,
            unused_ns: None,
            stamp_ns: None,
            known_since_ns: None,
            elsewhere: None,
        }
    }

    /// The last accepted pose.
    pub(super) fn pose(&self) -> Option<Pose> {
        self.fix().map(|fix| fix.pose)
    }

    /// The same with its standard deviations.
    pub(super) fn fix(&self) -> Option<&PoseEstimate> {
        self.fixes.back()
    }

    /// From the first event on, poses are expected.
    pub(super) fn begin(&mut self, now_ns: u64) {
        self.received_ns.get_or_insert(now_ns);
    }

    /// Time since the last valid pose.
    pub(super) fn silence_ns(&self, now_ns: u64) -> u64 {
        self.received_ns.map_or(0, |received_ns| now_ns.saturating_sub(received_ns))
    }

    /// Time since the last invalid pose.
    pub(super) fn unused_for_ns(&self, now_ns: u64) -> u64 {
        self.unused_ns.map_or(u64::MAX, |unused_ns| now_ns.saturating_sub(unused_ns))
    }

    /// Time since poses are known.
    pub(super) fn known_for_ns(&self, now_ns: u64) -> u64 {
        self.known_since_ns.map_or(0, |since_ns| now_ns.saturating_sub(since_ns))
    }

    /// The clock was set: earlier times have no meaning.
    pub(super) fn forget(&mut self, now_ns: u64) {
        self.fixes.clear();
        self.elsewhere = None;
        self.received_ns = Some(now_ns);
        (self.unused_ns, self.stamp_ns) = (None, None);
        self.known_since_ns = None;
    }

    /// Validates a pose, and stores it if valid.
    pub(super) fn judge(
        &mut self,
        now_ns: u64,
        fix: &PoseEstimate,
        terrain: &Terrain,
    ) -> Result<Judgment, Fault> {
        let stamped = stamp::check(now_ns, fix.time_ns, self.stamp_ns, self.max_age_ns);
        self.stamp_ns = Some(fix.time_ns);
        let judged = self.check(fix, terrain).and(stamped).and_then(|()| self.place(now_ns, fix));
        if matches!(judged, Err(_) | Ok(Judgment::Repeated)) {
            self.unused_ns = Some(now_ns);
        }
        judged
    }

    fn place(&mut self, now_ns: u64, fix: &PoseEstimate) -> Result<Judgment, Fault> {
        let judgment = match self.fixes.back() {
            Some(last) if fix.time_ns == last.time_ns => return Ok(Judgment::Repeated),
            Some(last) if !self.can_follow(last, fix) => {
                let jumped = jump(last, fix);
                self.settle(fix).ok_or(jumped)?
            }
            _ => Judgment::Good,
        };
        if judgment == Judgment::Restarted {
            self.fixes.clear();
        }
        self.elsewhere = None;
        self.received_ns = Some(now_ns);
        self.known_since_ns.get_or_insert(now_ns);
        self.fixes.push_back(*fix);
        if self.fixes.len() > KEPT_FIXES {
            self.fixes.pop_front();
        }
        Ok(judgment)
    }

    fn check(&self, fix: &PoseEstimate, terrain: &Terrain) -> Result<(), Fault> {
        let PoseEstimate { pose, deviation_meters, heading_deviation_radians, .. } = *fix;
        let are_deviations = deviation_meters >= 0.0 && heading_deviation_radians >= 0.0;
        if !(pose.is_finite() && are_deviations && heading_deviation_radians.is_finite()) {
            return Err(Fault::new("no_number", "a pose that is no number", &[]));
        }
        if deviation_meters > self.max_position_std_meters {
            let numbers =
                [("deviation_meters", deviation_meters), ("max_meters", self.max_position_std_meters)];
            return Err(Fault::new("vague", "the pose is not known well enough", &numbers));
        }
        let (grid, edge) = (terrain.grid(), terrain.cell_meters());
        if grid.cell_at(pose.x_meters / edge, pose.y_meters / edge).is_none() {
            let numbers = [("x_meters", pose.x_meters), ("y_meters", pose.y_meters)];
            return Err(Fault::new("outside", "a pose outside of the map", &numbers));
        }
        Ok(())
    }

    fn can_follow(&self, before: &PoseEstimate, fix: &PoseEstimate) -> bool {
        if fix.time_ns < before.time_ns {
            return false;
        }
        let path = self.speed_meters_per_second * seconds(fix.time_ns - before.time_ns);
        let deviation = before.deviation_meters.hypot(fix.deviation_meters);
        distance_meters(before, fix) <= path * SPEED_TOLERANCE + deviation * DEVIATIONS + SLACK_METERS
    }

    /// Whether poses elsewhere have agreed for long enough.
    fn settle(&mut self, fix: &PoseEstimate) -> Option<Judgment> {
        let agreeing = self.elsewhere.filter(|(_, last)| self.can_follow(last, fix));
        let (first, _) = agreeing.unwrap_or((*fix, *fix));
        self.elsewhere = Some((first, *fix));
        (fix.time_ns - first.time_ns >= self.recovery_ns).then_some(Judgment::Restarted)
    }

    /// The vehicle's pose at a time: linearly interpolated between two poses, unless poses were missing in between,
    /// when its rotation is unknown.
    pub(super) fn at(&self, time_ns: u64) -> At {
        let after = self.fixes.partition_point(|fix| fix.time_ns < time_ns);
        let Some(next) = self.fixes.get(after) else { return At::NotYet };
        let before = after.checked_sub(1).and_then(|index| self.fixes.get(index));
        let interval_ns = before.map_or(0, |before| next.time_ns - before.time_ns);
        if next.time_ns == time_ns {
            return At::Known { fix: *next, interval_ns };
        }
        match before {
            Some(before) if interval_ns <= self.max_age_ns => {
                At::Known { fix: between(before, next, time_ns), interval_ns }
            }
            // The oldest ones are dropped.
            None if self.fixes.len() < KEPT_FIXES => At::TooEarly,
            _ => At::Never,
        }
    }
}

/// The pose of a vehicle at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum At {
    Known {
        fix: PoseEstimate,
        /// Time from the pose before to the one after it.
        interval_ns: u64,
    },
    /// A later pose is needed.
    NotYet,
    /// Before the first pose.
    TooEarly,
    /// Before all poses that are kept, or while poses were missing.
    Never,
}

fn between(before: &PoseEstimate, next: &PoseEstimate, time_ns: u64) -> PoseEstimate {
    let share = (time_ns - before.time_ns) as f64 / (next.time_ns - before.time_ns) as f64;
    let along = |from: f64, to: f64| from + (to - from) * share;
    let (a, b) = (before.pose, next.pose);
    let turn = turn_radians(a.heading_radians, b.heading_radians);
    PoseEstimate {
        time_ns,
        pose: Pose {
            x_meters: along(a.x_meters, b.x_meters),
            y_meters: along(a.y_meters, b.y_meters),
            heading_radians: wrapped_radians(a.heading_radians + turn * share),
        },
        deviation_meters: before.deviation_meters.max(next.deviation_meters),
        heading_deviation_radians: before.heading_deviation_radians.max(next.heading_deviation_radians),
    }
}

fn distance_meters(a: &PoseEstimate, b: &PoseEstimate) -> f64 {
    (b.pose.position_meters() - a.pose.position_meters()).norm()
}

fn jump(last: &PoseEstimate, fix: &PoseEstimate) -> Fault {
    if fix.time_ns < last.time_ns {
        let numbers = [("behind_seconds", seconds(last.time_ns - fix.time_ns))];
        return Fault::new("backwards", "the stamps of poses run backwards", &numbers);
    }
    let numbers = [
        ("distance_meters", distance_meters(last, fix)),
        ("elapsed_seconds", seconds(fix.time_ns) - seconds(last.time_ns)),
    ];
    Fault::new("jump", "the pose has jumped farther than the vehicle drives", &numbers)
}
