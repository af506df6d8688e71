//! The life of a track: born of one bearing, confirmed or given up after its first looks, lost when it is
//! missed.
//!
//! A look counts where the camera could see the track: one out of view is neither seen nor missed.

use super::cubature::{Gaussian, Sight};
use super::mixture::Mixture;
use super::seconds_between;
use super::settings::Settings;

/// Names a track of one tracker for ever.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TrackId(pub u64);

/// How sure it is that there is something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// It may be a detector's mistake.
    Tentative,
    /// It was seen often enough.
    Confirmed,
}

/// What became of a track in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fate {
    AsBefore,
    Confirmed,
    Lost,
}

/// One thing that is followed.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    id: TrackId,
    pub(super) mixture: Mixture,
    standing: Standing,
    /// Of the first looks; they stop counting when it is confirmed.
    hits: u32,
    misses: u32,
    misses_in_a_row: u32,
    seen_ns: u64,
}

impl Track {
    pub(super) fn born(id: TrackId, mixture: Mixture, time_ns: u64, settings: &Settings) -> (Self, Fate) {
        let standing = Standing::Tentative;
        let mut track =
            Self { id, mixture, standing, hits: 1, misses: 0, misses_in_a_row: 0, seen_ns: time_ns };
        let fate = track.promoted(settings);
        (track, fate)
    }

    /// Its name.
    #[must_use]
    pub const fn id(&self) -> TrackId {
        self.id
    }

    /// How sure it is that there is something.
    #[must_use]
    pub const fn standing(&self) -> Standing {
        self.standing
    }

    /// When it was last seen, nanoseconds of mission time.
    #[must_use]
    pub const fn seen_ns(&self) -> u64 {
        self.seen_ns
    }

    /// All that is known of where it is.
    #[must_use]
    pub const fn mixture(&self) -> &Mixture {
        &self.mixture
    }

    /// Mean and covariance of that.
    #[must_use]
    pub fn estimate(&self) -> Gaussian {
        self.mixture.estimate()
    }

    pub(super) fn seen(&mut self, sight: &Sight, time_ns: u64, settings: &Settings) -> Fate {
        let Some(mixture) = self.mixture.updated(sight) else { return Fate::Lost };
        self.mixture = mixture;
        self.seen_ns = time_ns;
        self.misses_in_a_row = 0;
        self.hits = self.hits.saturating_add(1);
        self.promoted(settings)
    }

    pub(super) fn missed(&mut self, time_ns: u64, settings: &Settings) -> Fate {
        self.misses = self.misses.saturating_add(1);
        self.misses_in_a_row = self.misses_in_a_row.saturating_add(1);
        let is_lost = match self.standing {
            Standing::Tentative => self.misses > settings.first_looks - settings.confirming_hits,
            Standing::Confirmed => self.misses_in_a_row >= settings.losing_misses,
        };
        if is_lost { Fate::Lost } else { self.out_of_view(time_ns, settings) }
    }

    pub(super) fn out_of_view(&mut self, time_ns: u64, settings: &Settings) -> Fate {
        let is_forgotten = seconds_between(self.seen_ns, time_ns) > settings.forgetting_seconds;
        if is_forgotten { Fate::Lost } else { Fate::AsBefore }
    }

    fn promoted(&mut self, settings: &Settings) -> Fate {
        if self.standing == Standing::Confirmed || self.hits < settings.confirming_hits {
            return Fate::AsBefore;
        }
        self.standing = Standing::Confirmed;
        Fate::Confirmed
    }
}
