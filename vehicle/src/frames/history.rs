//! The transforms of one frame over the last seconds.

use std::collections::VecDeque;

use nalgebra::{Isometry3, Translation3};

use super::{Change, LookupError};

/// How long transforms are kept, nanoseconds: as long as `tf2` does.
pub const KEPT_NS: i64 = 10_000_000_000;
/// The longest time between two transforms that is interpolated, nanoseconds: in a longer one the frame may have moved
/// anyhow.
pub const MAX_GAP_NS: i64 = 1_000_000_000;
/// By how much a transform may be older than one that arrived before it, nanoseconds: a network delays none for longer, so
/// that the clock must have been set back.
const MAX_DELAY_NS: i64 = 2_000_000_000;
/// The most transforms that are kept, which bounds memory: [`KEPT_NS`] at 200 Hz.
const MAX_KEPT: usize = 2000;

/// By time, each once; at least one.
#[derive(Clone, Debug)]
pub(super) struct History(VecDeque<(i64, Isometry3<f64>)>);

/// Why a history has no transform of a time, and the seconds by which it misses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Outside {
    After(f64),
    Before(f64),
    Gap(f64),
}

impl History {
    pub(super) fn new(time_ns: i64, transform: Isometry3<f64>) -> Self {
        Self(VecDeque::from([(time_ns, transform)]))
    }

    pub(super) fn newest_ns(&self) -> Option<i64> {
        self.0.back().map(|&(newest_ns, _)| newest_ns)
    }

    /// Adds a transform, in the order of time: a network may change the order of messages.
    pub(super) fn insert(&mut self, time_ns: i64, transform: Isometry3<f64>) -> Change {
        let newest_ns = self.newest_ns().unwrap_or(time_ns);
        if newest_ns.saturating_sub(time_ns) > MAX_DELAY_NS {
            *self = Self::new(time_ns, transform);
            return Change::Restarted;
        }
        let place = self.0.partition_point(|&(kept_ns, _)| kept_ns < time_ns);
        if self.0.get(place).is_some_and(|&(kept_ns, _)| kept_ns == time_ns) {
            return Change::Known;
        }
        self.0.insert(place, (time_ns, transform));
        let oldest_ns = newest_ns.max(time_ns).saturating_sub(KEPT_NS);
        while self.0.len() > MAX_KEPT || self.0.front().is_some_and(|&(first_ns, _)| first_ns < oldest_ns) {
            self.0.pop_front();
        }
        Change::Added
    }

    pub(super) fn at(&self, time_ns: i64) -> Result<Isometry3<f64>, Outside> {
        let after = self.0.partition_point(|&(kept_ns, _)| kept_ns < time_ns);
        let before = after.checked_sub(1).and_then(|index| self.0.get(index));
        match (before, self.0.get(after)) {
            (_, Some(&(next_ns, next))) if next_ns == time_ns => Ok(next),
            (Some(&(before_ns, before)), Some(&(next_ns, next))) => {
                let gap_ns = next_ns.saturating_sub(before_ns);
                if gap_ns > MAX_GAP_NS {
                    return Err(Outside::Gap(seconds(gap_ns)));
                }
                Ok(between(&before, &next, (time_ns - before_ns) as f64 / gap_ns as f64))
            }
            (Some(&(newest_ns, _)), None) => Err(Outside::After(seconds(time_ns.saturating_sub(newest_ns)))),
            (None, Some(&(oldest_ns, _))) => Err(Outside::Before(seconds(oldest_ns.saturating_sub(time_ns)))),
            (None, None) => Err(Outside::After(f64::INFINITY)),
        }
    }
}

impl Outside {
    pub(super) fn between(self, parent: &str, child: &str) -> LookupError {
        let (parent, child) = (parent.to_owned(), child.to_owned());
        match self {
            Self::After(seconds) => LookupError::NotYet { parent, child, seconds },
            Self::Before(seconds) => LookupError::Past { parent, child, seconds },
            Self::Gap(seconds) => LookupError::Gap { parent, child, seconds },
        }
    }
}

/// The transform at a share of the way from one to the next: the translation linear, the rotation by slerp along the
/// shorter arc.
fn between(before: &Isometry3<f64>, next: &Isometry3<f64>, share: f64) -> Isometry3<f64> {
    let translation = before.translation.vector.lerp(&next.translation.vector, share);
    // Only of opposite quaternions, which are the same rotation, there is no arc.
    let rotation = before.rotation.try_slerp(&next.rotation, share, 1e-12).unwrap_or(before.rotation);
    Isometry3::from_parts(Translation3::from(translation), rotation)
}

fn seconds(time_ns: i64) -> f64 {
    time_ns as f64 / 1e9
}
