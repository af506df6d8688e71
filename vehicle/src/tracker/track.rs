//! The life of a track: born of one bearing, confirmed or given up after its first looks, lost when it is
//! missed.
//!
//! What speaks for there being a thing at all is its score (Blackman and Popoli, Design and Analysis of Modern
//! Tracking Systems, 1999, section 6.2): the logarithm of how many times as likely a thing makes all that was
//! seen and missed as a detector's mistakes do.
//!
//! What the vehicle drives straight at has one bearing all the way, which tells nothing of its range but that it is not
//! passed yet; and of all ranges the near ones become unlikely, since what is near is seldom so straight ahead. So
//! when it is missed where it was expected, it may have been anywhere on the way there (`Track::may_have_passed`): a
//! mixture must not lack what is likely by now, however unlikely it was before (a defensive mixture, Hesterberg,
//! Technometrics 37(2), 1995).
//!
//! A look counts where the camera could see the track: one out of view is neither seen nor missed.

use std::collections::BTreeMap;

use nalgebra::{Matrix2, Vector2};

use super::cubature::{Gaussian, Sight};
use super::frame::Frame;
use super::mixture::{Mixture, Reach};
use super::pose_error::PoseError;
use super::seconds_between;
use super::settings::Settings;
use super::view_share::{SEEN_OUTSIDE, mean_over, seen_in};
use super::visibility::Missed;
use crate::camera::View;
use dragnet_lattice::plane::{bearing_radians, turn_radians};

/// What is seen within this time has one cause, seconds: together it counts once. So does what is missed, since it was
/// seen or missed before.
const INDEPENDENT_SECONDS: f64 = 0.2;
/// Score of one bearing alone, nats: most are mistakes.
const FIRST_NATS: f64 = -4.0;
/// With this score a track can be confirmed,
const CONFIRMING_NATS: f64 = 3.0;
/// and below this it is given up.
const HOPELESS_NATS: f64 = -6.0;
/// A score grows no further: what is missed later counts against it.
const MOST_NATS: f64 = 50.0;
/// Below this probability of a bearing's being a mistake it is taken for none.
const LEAST_DOUBT: f64 = 0.01;
/// What would be seen with less than this probability was not missed.
const LEAST_EXPECTED: f64 = 0.25;
/// Beyond this score no other track has a better claim to a bearing.
const ESTABLISHED_NATS: f64 = 25.0;
/// What was not seen before may have been hidden, with this probability at least.
const LEAST_UNSEEN: f64 = 0.01;
/// A single bearing may be a mistake, and the next one of something that this camera does not see.
const BORN_OUTSIDE: f64 = 0.05;
/// A tentative track is forgotten as soon as this, seconds: nobody looks where it might be.
const TENTATIVE_SECONDS: f64 = 5.0;
/// What two cameras have missed within this time, seconds, was not between them either.
const SEAM_SECONDS: f64 = 1.0;
/// After so many misses in a row a thing may have been passed,
const PASSING_MISSES: f64 = 2.0;
/// with this probability,
const PASSED: f64 = 0.05;
/// if its range is not known better than this share of it.
const KNOWN_SHARE: f64 = 0.1;
/// Of the error of a pose so much may last for ever, of its standard deviation: no number of bearings averages
/// it away.
const LASTING_SHARE: f64 = 0.5;

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

/// Who has the first choice of bearings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rank {
    /// Confirmed, and long beyond doubt.
    Established,
    Confirmed,
    Tentative,
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
    /// Those that are independent.
    misses_in_a_row: f64,
    /// How much speaks for there being a thing, nats.
    score_nats: f64,
    seen_ns: u64,
    /// When it was last seen or missed.
    judged_ns: u64,
    /// What is never known better of its place, meters.
    lasting_std_meters: f64,
    /// From where and how it was seen last, until it is taken for passed or another track has its bearing.
    last_seen: Option<LastSeen>,
    /// Views in which it was missed since: each camera's latest, and of when that is, nanoseconds.
    missed_in: BTreeMap<u16, (u64, View)>,
    /// How often each camera has missed it since that camera saw it.
    missed_by: BTreeMap<u16, u32>,
}

/// A bearing, and what is to be known of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LastSeen {
    sight: Sight,
    pose_error: PoseError,
    min_range_meters: f64,
}

impl Track {
    /// Of a bearing that no track explains. It may be of something that only another camera can see, whose
    /// sights will be taken for the same track: so all ranges are there, to as far as any camera sees. Where it
    /// would have been seen before it is less likely: `unseen` is the probability that it was missed there.
    pub(super) fn born(
        id: TrackId,
        sight: &Sight,
        frame: &Frame,
        max_range_meters: f64,
        unseen: &dyn Fn(Vector2<f64>) -> f64,
        settings: &Settings,
    ) -> (Self, Fate) {
        let reach = Reach { max_range_meters, ..frame.reach() };
        let view = frame.widest_view(settings.gate_radians);
        let mixture = Mixture::born(sight, &frame.pose_error, reach, settings);
        let mut track = Self {
            id,
            mixture: mixture.reweighted(|state| {
                let before = mean_over(state, unseen).max(LEAST_UNSEEN);
                seen_in(state, &view).max(BORN_OUTSIDE) * before
            }),
            standing: Standing::Tentative,
            hits: 1,
            misses: 0,
            misses_in_a_row: 0.0,
            score_nats: FIRST_NATS,
            seen_ns: frame.time_ns,
            judged_ns: frame.time_ns,
            lasting_std_meters: f64::INFINITY,
            last_seen: None,
            missed_in: BTreeMap::new(),
            missed_by: BTreeMap::new(),
        };
        track.note_lasting_error(frame);
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

    /// Where it is expected, meters east and north.
    #[must_use]
    pub fn position_meters(&self) -> Vector2<f64> {
        self.estimate().position_meters()
    }

    /// Covariance of that place, square meters, with what the vehicle's poses may be off for ever.
    #[must_use]
    pub fn position_covariance(&self) -> Matrix2<f64> {
        self.estimate().place_covariance() + Matrix2::identity() * self.lasting_std_meters.powi(2)
    }

    /// What no number of bearings tells better, meters: each coordinate's standard deviation.
    #[must_use]
    pub const fn lasting_std_meters(&self) -> f64 {
        self.lasting_std_meters
    }

    /// How often it was seen.
    #[must_use]
    pub const fn hits(&self) -> u32 {
        self.hits
    }

    /// How much speaks for there being a thing, nats: the logarithm of its odds.
    #[must_use]
    pub const fn score_nats(&self) -> f64 {
        self.score_nats
    }

    pub(super) fn rank(&self) -> Rank {
        match self.standing {
            Standing::Tentative => Rank::Tentative,
            Standing::Confirmed if self.score_nats >= ESTABLISHED_NATS => Rank::Established,
            Standing::Confirmed => Rank::Confirmed,
        }
    }

    pub(super) fn seen(&mut self, sight: &Sight, frame: &Frame, settings: &Settings) -> Fate {
        let pose_error = frame.pose_error.after(seconds_between(self.seen_ns, frame.time_ns));
        self.mixture.refine(sight.from_meters);
        let widest = frame.widest_view(settings.gate_radians);
        let expected = self.mixture.mean_of(&|point| frame.visibility(point)).max(SEEN_OUTSIDE);
        let Some((mixture, log_density)) = self.mixture.explained(sight, &pose_error) else {
            return Fate::Lost;
        };
        let mistakes = settings.false_alarms_per_frame / frame.view.width_radians();
        let log_odds = ((1.0 - settings.miss_probability) * expected / mistakes).ln() + log_density;
        // The bearing may be a mistake, and the track as it was. What a camera has missed so far it sees as seldom as by
        // Laplace's rule of succession: else one mistake would outweigh all that it has missed at the end of its range.
        let missed = f64::from(self.missed_by.remove(&frame.camera).unwrap_or(0));
        let doubt = 1.0 / (1.0 + log_odds.exp() * 2.0 / (missed + 2.0));
        let seen = mixture.after_seen(&widest);
        self.mixture = if doubt < LEAST_DOUBT { seen } else { seen.or(&self.mixture, doubt) };
        self.mixture.condense();
        // Not since it was missed: on the seam of two cameras one misses what the other sees just then.
        self.count(log_odds, independent_share(self.seen_ns, frame), frame);
        self.seen_ns = frame.time_ns;
        let min_range_meters = frame.reach().min_range_meters;
        self.last_seen = Some(LastSeen { sight: *sight, pose_error: frame.pose_error, min_range_meters });
        self.missed_in.clear();
        self.misses_in_a_row = 0.0;
        self.hits = self.hits.saturating_add(1);
        self.note_lasting_error(frame);
        self.promoted(settings)
    }

    /// Adds to the score, as much as is independent of what was added before.
    fn count(&mut self, nats: f64, share: f64, frame: &Frame) {
        self.score_nats = (self.score_nats + share * nats).min(MOST_NATS);
        self.judged_ns = frame.time_ns;
    }

    /// It was not seen: where it would have been it is less likely from now on.
    pub(super) fn not_seen(&mut self, frame: &Frame, settings: &Settings) -> Fate {
        let expected = self.mixture.mean_of(&|point| frame.visibility(point));
        let view = frame.surest_view(0.0);
        let others = self.missed_by_others(frame);
        self.missed_in.insert(frame.camera, (frame.time_ns, view));
        if self.is_another_seen_there(frame, settings.gate_radians) {
            self.last_seen = None;
        }
        let is_missed = expected >= LEAST_EXPECTED;
        if expected > 0.0 {
            let missed = self.missed_by.entry(frame.camera).or_insert(0);
            *missed = missed.saturating_add(1);
            let share = independent_share(self.judged_ns, frame);
            self.misses_in_a_row += if is_missed { share } else { 0.0 };
            self.may_have_passed(settings);
            self.mixture.refine(frame.position_meters());
            let missed = Missed { view, others: &others, edge_radians: settings.gate_radians };
            self.mixture = self.mixture.after_missed(&missed, settings.miss_probability.powf(share));
            self.count((1.0 - (1.0 - settings.miss_probability) * expected).ln(), share, frame);
        }
        if self.is_hopeless(settings) || (is_missed && self.is_lost_by_a_miss(settings)) {
            return Fate::Lost;
        }
        let patience_seconds = match self.standing {
            Standing::Tentative => settings.track_timeout_seconds.min(TENTATIVE_SECONDS),
            Standing::Confirmed => settings.track_timeout_seconds,
        };
        let is_forgotten = seconds_between(self.seen_ns, frame.time_ns) > patience_seconds;
        if is_forgotten { Fate::Lost } else { Fate::AsBefore }
    }

    /// Views of the other cameras in which it was missed just before.
    fn missed_by_others(&self, frame: &Frame) -> Vec<View> {
        let is_new = |time_ns: u64| seconds_between(time_ns, frame.time_ns) <= SEAM_SECONDS;
        let others = self.missed_in.iter().filter(|&(&camera, _)| camera != frame.camera);
        others.filter(|&(_, &(time_ns, _))| is_new(time_ns)).map(|(_, &(_, view))| view).collect()
    }

    /// Whether a bearing that was not its own is where its own was or would be: then it was not passed, another track
    /// has it.
    fn is_another_seen_there(&self, frame: &Frame, gate_radians: f64) -> bool {
        let expected = bearing_radians(frame.position_meters(), self.position_meters());
        let last = self.last_seen.map_or(expected, |seen| seen.sight.bearing_radians);
        let is_near = |bearing: f64, own: f64| turn_radians(own, bearing).abs() <= gate_radians;
        frame.bearings_radians.iter().any(|&bearing| is_near(bearing, expected) || is_near(bearing, last))
    }

    /// Takes into account, once for each time that it was seen, that it may be nearer than all that is left of it.
    fn may_have_passed(&mut self, settings: &Settings) {
        if self.misses_in_a_row < PASSING_MISSES {
            return;
        }
        let Some(LastSeen { sight, pose_error, min_range_meters }) = self.last_seen.take() else { return };
        let estimate = self.estimate();
        let max_range_meters = (estimate.position_meters() - sight.from_meters).norm();
        let std_meters = estimate.place_covariance().symmetric_eigenvalues().max().max(0.0).sqrt();
        if max_range_meters > min_range_meters && std_meters > KNOWN_SHARE * max_range_meters {
            let nearer =
                Mixture::born(&sight, &pose_error, Reach { min_range_meters, max_range_meters }, settings);
            self.mixture = self.mixture.or(&nearer, PASSED);
        }
    }

    fn is_lost_by_a_miss(&mut self, settings: &Settings) -> bool {
        self.misses = self.misses.saturating_add(1);
        if self.standing == Standing::Tentative && self.hits < settings.confirm_hits {
            return self.misses > settings.initial_frames - settings.confirm_hits;
        }
        self.misses_in_a_row >= f64::from(settings.max_misses) - 1e-9
    }

    fn is_hopeless(&self, settings: &Settings) -> bool {
        self.hits >= settings.confirm_hits && self.score_nats < HOPELESS_NATS
    }

    fn note_lasting_error(&mut self, frame: &Frame) {
        let range_meters = (self.position_meters() - frame.position_meters()).norm();
        let turned = frame.pose_error.heading_std_radians * range_meters;
        let std_meters = LASTING_SHARE * turned.hypot(frame.pose_error.position_std_meters);
        self.lasting_std_meters = self.lasting_std_meters.min(std_meters);
    }

    fn promoted(&mut self, settings: &Settings) -> Fate {
        let is_seen = self.hits >= settings.confirm_hits && self.score_nats >= CONFIRMING_NATS;
        if self.standing == Standing::Confirmed || !is_seen {
            return Fate::AsBefore;
        }
        self.standing = Standing::Confirmed;
        Fate::Confirmed
    }
}

/// How much of what a frame tells is not told by what came before it at a time.
fn independent_share(before_ns: u64, frame: &Frame) -> f64 {
    (seconds_between(before_ns, frame.time_ns) / INDEPENDENT_SECONDS).min(1.0)
}
