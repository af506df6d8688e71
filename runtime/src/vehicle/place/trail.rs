//! Recent poses by odometry.

use std::collections::VecDeque;

use dragnet_lattice::plane::{Pose, turn_radians, wrapped_radians};

/// How long poses are kept, nanoseconds.
const KEPT_NS: u64 = 60_000_000_000;
/// Minimum time between kept poses, nanoseconds, which bounds their number.
const STEP_NS: u64 = 10_000_000;

/// Poses in odometry's frame.
#[derive(Clone, Debug, Default)]
pub(super) struct Trail {
    /// By time, each once; nanoseconds of mission time.
    poses: VecDeque<(u64, Pose)>,
    /// The last one, which may be closer in time.
    latest: Option<(u64, Pose)>,
}

impl Trail {
    /// Adds a pose. If the clock was set back, earlier poses are dropped.
    pub(super) fn push(&mut self, time_ns: u64, pose: Pose) {
        if self.latest_ns().is_some_and(|latest_ns| time_ns < latest_ns) {
            self.poses.clear();
        }
        self.latest = Some((time_ns, pose));
        if self.poses.back().is_none_or(|(last_ns, _)| time_ns - last_ns >= STEP_NS) {
            self.poses.push_back((time_ns, pose));
        }
        while self.poses.front().is_some_and(|(first_ns, _)| time_ns - first_ns > KEPT_NS) {
            self.poses.pop_front();
        }
    }

    pub(super) fn latest(&self) -> Option<Pose> {
        self.latest.map(|(_, pose)| pose)
    }

    pub(super) fn latest_ns(&self) -> Option<u64> {
        self.latest.map(|(time_ns, _)| time_ns)
    }

    /// Whether the pose at a time is known.
    pub(super) fn reaches(&self, time_ns: u64) -> bool {
        self.poses.front().is_some_and(|&(first_ns, _)| first_ns <= time_ns)
    }

    /// The pose at a time: linearly interpolated between two poses; before the first and after the last it is constant.
    pub(super) fn at(&self, time_ns: u64) -> Option<Pose> {
        let after = self.poses.partition_point(|&(kept_ns, _)| kept_ns <= time_ns);
        let Some(&(before_ns, before)) = after.checked_sub(1).and_then(|index| self.poses.get(index)) else {
            return self.poses.front().map(|&(_, first)| first);
        };
        let (next_ns, next) = self.poses.get(after).copied().or(self.latest)?;
        if next_ns <= before_ns || time_ns >= next_ns {
            return Some(next);
        }
        let share = (time_ns - before_ns) as f64 / (next_ns - before_ns) as f64;
        let turn = turn_radians(before.heading_radians, next.heading_radians);
        let place = before.position_meters().lerp(&next.position_meters(), share);
        Some(Pose::new(place.x, place.y, wrapped_radians(before.heading_radians + turn * share)))
    }
}

/// Distance and angle between two poses: meters, and radians.
pub(super) fn apart(from: &Pose, to: &Pose) -> (f64, f64) {
    let turn = turn_radians(from.heading_radians, to.heading_radians);
    ((to.position_meters() - from.position_meters()).norm(), turn.abs())
}
