//! The life of a track: created by one bearing, confirmed or dropped after its first frames, lost when it is missed.
//!
//! The evidence that an object exists is the track's score (Blackman and Popoli, Design and Analysis of Modern Tracking
//! Systems, 1999, section 6.2): the logarithm of the likelihood ratio of all detections and misses between an object
//! and false alarms.
//!
//! An object that the vehicle drives straight toward keeps its bearing, which gives no range except that it is not
//! passed yet; near ranges become unlikely, since near objects are seldom so straight ahead. So when it is missed where
//! it was expected, it may have been anywhere along the bearing (`Track::may_have_passed`): a mixture must not lack
//! what is likely now, however unlikely it was before (a defensive mixture, Hesterberg, Technometrics 37(2), 1995).
//!
//! A frame counts only if the track could be in view: out of view it is neither detected nor missed.

use std::collections::BTreeMap;

use nalgebra::{Matrix2, Vector2};

use super::cubature::{BearingMeasurement, Gaussian};
use super::frame::Frame;
use super::mixture::{Mixture, Reach};
use super::pose_error::PoseError;
use super::settings::Settings;
use super::view_share::{SEEN_OUTSIDE, mean_over, seen_in};
use super::visibility::Missed;
use super::{Surroundings, largest_std_meters, seconds_between};
use crate::camera::View;
use dragnet_lattice::plane::{bearing_radians, turn_radians};

/// Detections within this time have one cause, seconds: together they count once. So do misses, since the last
/// detection or miss.
const INDEPENDENT_SECONDS: f64 = 0.2;
/// Score of a single bearing, nats: most are false alarms.
const FIRST_NATS: f64 = -4.0;
/// Score from which a track can be confirmed,
const CONFIRMING_NATS: f64 = 3.0;
/// and below which it is dropped.
const HOPELESS_NATS: f64 = -6.0;
/// Maximum score: later misses count against it.
const MOST_NATS: f64 = 50.0;
/// Probability of a false alarm below which a bearing counts as a detection.
const LEAST_DOUBT: f64 = 0.01;
/// Detection probability below which a track was not missed.
const LEAST_EXPECTED: f64 = 0.25;
/// Score beyond which no other track has a better claim to a bearing.
const ESTABLISHED_NATS: f64 = 25.0;
/// Minimum probability that an undetected object was hidden.
const LEAST_UNSEEN: f64 = 0.01;
/// A single bearing may be a false alarm, and the next one of an object out of this camera's view.
const BORN_OUTSIDE: f64 = 0.05;
/// Probability that an object is detected where the map has a wall before it: the map may be wrong there, or the wall be low.
const SEEN_BEHIND_A_WALL: f64 = 0.05;
/// Share of an object's range by which a camera has to move to look at it anew.
const ANOTHER_SIGHT: f64 = 0.5;
/// Timeout of a tentative track, seconds.
const TENTATIVE_SECONDS: f64 = 5.0;
/// Time within which misses of two cameras, seconds, also cover the seam between them.
const SEAM_SECONDS: f64 = 1.0;
/// Misses in a row after which an object may have been passed,
const PASSING_MISSES: f64 = 2.0;
/// with this probability,
const PASSED: f64 = 0.05;
/// if its range is uncertain by more than this share.
const KNOWN_SHARE: f64 = 0.1;
/// Share of a pose error's standard deviation that may last for ever: no number of bearings averages it away.
const LASTING_SHARE: f64 = 0.5;

/// The permanent identifier of a track of one tracker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TrackId(pub u64);

/// Whether a track is confirmed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// It may be a false alarm.
    Tentative,
    /// It was detected often enough.
    Confirmed,
}

/// Order in which tracks choose bearings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rank {
    /// Confirmed, and certain for a long time.
    Established,
    Confirmed,
    Tentative,
}

/// The result of a frame for a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FrameResult {
    AsBefore,
    Confirmed,
    Lost,
}

/// One tracked object.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    id: TrackId,
    pub(super) mixture: Mixture,
    standing: Standing,
    /// Number of detections in the first frames; counting ends when it is confirmed.
    hits: u32,
    misses: u32,
    /// Independent misses.
    misses_in_a_row: f64,
    /// Evidence that an object exists, nats.
    score_nats: f64,
    seen_ns: u64,
    /// Time of its last detection or miss.
    judged_ns: u64,
    /// Lasting standard deviation of its position, meters.
    lasting_std_meters: f64,
    /// Its last detection, until it counts as passed or another track has its bearing.
    last_seen: Option<LastSeen>,
    /// Views in which it was missed since: each camera's latest, with its time, nanoseconds.
    missed_in: BTreeMap<u16, (u64, View)>,
    /// Number of misses of each camera since its last detection.
    missed_by: BTreeMap<u16, u32>,
}

/// A detection with its circumstances.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LastSeen {
    measurement: BearingMeasurement,
    pose_error: PoseError,
    min_range_meters: f64,
}

impl Track {
    /// Creates a track from an unassigned bearing. The object may be in range of another camera only, whose bearings
    /// will be assigned to the same track: so the ranges extend to the largest range of any camera. Positions where it
    /// would have been detected before are less likely, and so are those behind walls.
    pub(super) fn born(
        id: TrackId,
        measurement: &BearingMeasurement,
        frame: &Frame,
        max_range_meters: f64,
        surroundings: &Surroundings<'_>,
        settings: &Settings,
    ) -> (Self, FrameResult) {
        let reach = Reach { max_range_meters, ..frame.reach() };
        let view = frame.widest_view(settings.gate_radians);
        let mut mixture = Mixture::born(measurement, &frame.pose_error, reach, settings);
        mixture.split_at_walls(&view, surroundings.is_hidden);
        let mut track = Self {
            id,
            mixture: mixture.reweighted(|state| {
                let before = mean_over(state, surroundings.unseen).max(LEAST_UNSEEN);
                seen_in(state, &view).max(BORN_OUTSIDE) * before * past_walls(state, surroundings)
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

    /// Its identifier.
    #[must_use]
    pub const fn id(&self) -> TrackId {
        self.id
    }

    /// Whether it is confirmed.
    #[must_use]
    pub const fn standing(&self) -> Standing {
        self.standing
    }

    /// Time of its last detection, nanoseconds of mission time.
    #[must_use]
    pub const fn seen_ns(&self) -> u64 {
        self.seen_ns
    }

    /// The distribution of its state.
    #[must_use]
    pub const fn mixture(&self) -> &Mixture {
        &self.mixture
    }

    /// Mean and covariance of its state.
    #[must_use]
    pub fn estimate(&self) -> Gaussian {
        self.mixture.estimate()
    }

    /// Expected position, meters east and north.
    #[must_use]
    pub fn position_meters(&self) -> Vector2<f64> {
        self.estimate().position_meters()
    }

    /// Covariance of the position, square meters, including the lasting error of the vehicle's poses.
    #[must_use]
    pub fn position_covariance(&self) -> Matrix2<f64> {
        self.estimate().place_covariance() + Matrix2::identity() * self.lasting_std_meters.powi(2)
    }

    /// Standard deviation of the position in its most uncertain direction, meters.
    #[must_use]
    pub fn std_meters(&self) -> f64 {
        largest_std_meters(&self.position_covariance())
    }

    /// Lasting standard deviation of each coordinate, meters, which no number of bearings reduces.
    #[must_use]
    pub const fn lasting_std_meters(&self) -> f64 {
        self.lasting_std_meters
    }

    /// Number of detections.
    #[must_use]
    pub const fn hits(&self) -> u32 {
        self.hits
    }

    /// Evidence that an object exists, nats: the logarithm of its odds.
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

    pub(super) fn seen(
        &mut self,
        measurement: &BearingMeasurement,
        frame: &Frame,
        surroundings: &Surroundings<'_>,
        settings: &Settings,
    ) -> FrameResult {
        let pose_error = frame.pose_error.after(seconds_between(self.seen_ns, frame.time_ns));
        self.mixture.refine(measurement.from_meters);
        let widest = frame.widest_view(settings.gate_radians);
        let expected = self.mixture.mean_of(&|point| frame.visibility(point)).max(SEEN_OUTSIDE);
        let Some((mut mixture, log_density)) = self.mixture.explained(measurement, &pose_error) else {
            return FrameResult::Lost;
        };
        let mistakes = settings.false_alarms_per_frame / frame.view.width_radians();
        let log_odds = ((1.0 - settings.miss_probability) * expected / mistakes).ln() + log_density;
        // The bearing may be a false alarm, and the track unchanged. The detection probability of a camera that has
        // missed it so far follows Laplace's rule of succession: otherwise one false alarm would outweigh all misses at
        // the end of its range.
        let missed = f64::from(self.missed_by.remove(&frame.camera).unwrap_or(0));
        let doubt = 1.0 / (1.0 + log_odds.exp() * 2.0 / (missed + 2.0));
        mixture.split_at_walls(&widest, surroundings.is_hidden);
        let share = |state: &Gaussian| self.looks_anew(measurement.from_meters, state);
        let seen = mixture.after_seen(&widest).reweighted(|state| match share(state) {
            share if share > 0.0 => past_walls(state, surroundings).powf(share),
            _ => 1.0,
        });
        self.mixture = if doubt < LEAST_DOUBT { seen } else { seen.or(&self.mixture, doubt) };
        // Of two bearings either may be the false alarm.
        if self.hits == 1 && doubt >= LEAST_DOUBT {
            let begun_now = Mixture::born(measurement, &frame.pose_error, frame.reach(), settings);
            self.mixture = self.mixture.or(&begun_now, doubt);
        }
        self.mixture.condense();
        // Not since it was missed: on the seam of two cameras one misses what the other detects at the same time.
        self.count(log_odds, independent_share(self.seen_ns, frame), frame);
        self.seen_ns = frame.time_ns;
        let min_range_meters = frame.reach().min_range_meters;
        self.last_seen =
            Some(LastSeen { measurement: *measurement, pose_error: frame.pose_error, min_range_meters });
        self.missed_in.clear();
        self.misses_in_a_row = 0.0;
        self.hits = self.hits.saturating_add(1);
        self.note_lasting_error(frame);
        self.promoted(settings)
    }

    /// By how much, 0 to 1, a camera has moved since the last detection, so that walls between it and an object there are others,
    /// or are the same seen anew: what a map has wrong is wrong for all detections from one place.
    fn looks_anew(&self, from_meters: Vector2<f64>, state: &Gaussian) -> f64 {
        let range_meters = (state.position_meters() - from_meters).norm();
        let moved_meters =
            self.last_seen.map_or(0.0, |last| (last.measurement.from_meters - from_meters).norm());
        (moved_meters / (ANOTHER_SIGHT * range_meters)).min(1.0)
    }

    /// Adds the independent part of a log-likelihood ratio to the score.
    fn count(&mut self, nats: f64, share: f64, frame: &Frame) {
        self.score_nats = (self.score_nats + share * nats).min(MOST_NATS);
        self.judged_ns = frame.time_ns;
    }

    /// It was not detected: positions in view become less likely.
    pub(super) fn not_seen(
        &mut self,
        frame: &Frame,
        surroundings: &Surroundings<'_>,
        settings: &Settings,
    ) -> FrameResult {
        self.mixture.split_at_walls(&frame.view, surroundings.is_hidden);
        let visibility = |point| match frame.visibility(point) {
            seen if seen > 0.0 && (surroundings.is_hidden)(point) => 0.0,
            seen => seen,
        };
        let expected = self.mixture.mean_of(&visibility);
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
            let missed = Missed {
                view,
                others: &others,
                edge_radians: settings.gate_radians,
                is_hidden: surroundings.is_hidden,
            };
            self.mixture = self.mixture.after_missed(&missed, settings.miss_probability.powf(share));
            self.count((1.0 - (1.0 - settings.miss_probability) * expected).ln(), share, frame);
        }
        if self.is_hopeless(settings) || (is_missed && self.is_lost_by_a_miss(settings)) {
            return FrameResult::Lost;
        }
        let patience_seconds = match self.standing {
            Standing::Tentative => settings.track_timeout_seconds.min(TENTATIVE_SECONDS),
            Standing::Confirmed => settings.track_timeout_seconds,
        };
        let is_forgotten = seconds_between(self.seen_ns, frame.time_ns) > patience_seconds;
        if is_forgotten { FrameResult::Lost } else { FrameResult::AsBefore }
    }

    /// Views of the other cameras in which it was missed just before.
    fn missed_by_others(&self, frame: &Frame) -> Vec<View> {
        let is_new = |time_ns: u64| seconds_between(time_ns, frame.time_ns) <= SEAM_SECONDS;
        let others = self.missed_in.iter().filter(|&(&camera, _)| camera != frame.camera);
        others.filter(|&(_, &(time_ns, _))| is_new(time_ns)).map(|(_, &(_, view))| view).collect()
    }

    /// Whether a bearing of another track is where its own was or would be: then it was not passed, and the other track
    /// has its bearing.
    fn is_another_seen_there(&self, frame: &Frame, gate_radians: f64) -> bool {
        let expected = bearing_radians(frame.position_meters(), self.position_meters());
        let last = self.last_seen.map_or(expected, |seen| seen.measurement.bearing_radians);
        let is_near = |bearing: f64, own: f64| turn_radians(own, bearing).abs() <= gate_radians;
        frame.bearings_radians.iter().any(|&bearing| is_near(bearing, expected) || is_near(bearing, last))
    }

    /// Adds, once after each detection, the possibility that it is nearer than all remaining members.
    fn may_have_passed(&mut self, settings: &Settings) {
        if self.misses_in_a_row < PASSING_MISSES {
            return;
        }
        let Some(LastSeen { measurement, pose_error, min_range_meters }) = self.last_seen.take() else {
            return;
        };
        let estimate = self.estimate();
        let max_range_meters = (estimate.position_meters() - measurement.from_meters).norm();
        let std_meters = largest_std_meters(&estimate.place_covariance());
        if max_range_meters > min_range_meters && std_meters > KNOWN_SHARE * max_range_meters {
            let nearer = Mixture::born(
                &measurement,
                &pose_error,
                Reach { min_range_meters, max_range_meters },
                settings,
            );
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

    fn promoted(&mut self, settings: &Settings) -> FrameResult {
        let is_seen = self.hits >= settings.confirm_hits && self.score_nats >= CONFIRMING_NATS;
        if self.standing == Standing::Confirmed || !is_seen {
            return FrameResult::AsBefore;
        }
        self.standing = Standing::Confirmed;
        FrameResult::Confirmed
    }
}

/// The relative probability that an object there is detected past the walls of a map, which may be wrong.
fn past_walls(state: &Gaussian, surroundings: &Surroundings<'_>) -> f64 {
    mean_over(state, &|point| if (surroundings.is_hidden)(point) { SEEN_BEHIND_A_WALL } else { 1.0 })
}

/// The share of a frame's information that is independent of earlier frames.
fn independent_share(before_ns: u64, frame: &Frame) -> f64 {
    (seconds_between(before_ns, frame.time_ns) / INDEPENDENT_SECONDS).min(1.0)
}
