//! Where the things are that cameras see, from bearings alone, seen from a vehicle that moves.
//!
//! Each track is a range-parameterized cubature Kalman filter ([`mixture`]). A frame is what one camera saw
//! at one time. Its bearings go to the tracks that make them likely ([`crate::assignment`]), to confirmed ones
//! first; those that no track explains become new tracks. A track is confirmed once it was seen in enough of its first frames, and lost
//! when it is missed too often ([`track`]).
//!
//! The only way anything changes is [`Tracker::handle`]: what cannot be is refused there, and then nothing
//! has changed.

pub mod cubature;
pub mod frame;
pub mod mixture;
pub mod pose_error;
mod refinement;
pub mod settings;
pub mod track;
mod view_share;
mod visibility;

use std::collections::BTreeSet;

use nalgebra::Vector2;

use crate::assignment::{Assignment, AssignmentError, assign};
use frame::{Frame, FrameError};
use settings::{Settings, SettingsError};
use track::{Fate, Rank, Track, TrackId};

/// A bearing that surprises a track by more than this is none of its own, nats.
const MOST_SURPRISE_NATS: f64 = 6.0;

/// All tracks of a vehicle.
#[derive(Clone, Debug)]
pub struct Tracker {
    settings: Settings,
    tracks: Vec<Track>,
    next_id: u64,
    latest: Option<Latest>,
    /// As far as any camera has seen until now, meters.
    max_range_meters: f64,
}

/// The latest time that frames were taken at.
#[derive(Clone, Debug)]
struct Latest {
    time_ns: u64,
    cameras: BTreeSet<u16>,
}

/// What a frame changed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Tracks that were seen, each with the place of its bearing in the frame.
    pub seen: Vec<(TrackId, usize)>,
    /// Tracks that begin with a bearing of the frame.
    pub born: Vec<TrackId>,
    /// Tracks that are confirmed from now on.
    pub confirmed: Vec<TrackId>,
    /// Tracks that are no more.
    pub lost: Vec<TrackId>,
    /// Bearings that would have begun a track beyond [`Tracker::MAX_TRACKS`].
    pub refused_births: usize,
}

impl Tracker {
    /// So many tracks are kept: more come of a detector at fault.
    pub const MAX_TRACKS: usize = 256;

    /// A tracker that has seen nothing yet.
    ///
    /// # Errors
    /// If a setting is out of its range.
    pub fn new(settings: Settings) -> Result<Self, SettingsError> {
        settings.check()?;
        Ok(Self { settings, tracks: Vec::new(), next_id: 0, latest: None, max_range_meters: 0.0 })
    }

    /// All tracks, oldest first, as of the latest frame.
    #[must_use]
    pub fn tracks(&self) -> &[Track] {
        &self.tracks
    }

    /// When the latest frame was taken, nanoseconds of mission time; none before the first.
    #[must_use]
    pub fn latest_ns(&self) -> Option<u64> {
        self.latest.as_ref().map(|latest| latest.time_ns)
    }

    /// Takes in what one camera saw at one time. Several cameras may have frames of one time.
    ///
    /// # Errors
    /// If the frame cannot be, is older than the latest, or is its camera's second of one time.
    /// Nothing has changed then.
    pub fn handle(&mut self, frame: &Frame) -> Result<Outcome, FrameError> {
        self.handle_where_unseen(frame, &|_| 1.0)
    }

    /// The same where it is known what was seen before: `unseen` is the probability that a thing at a place,
    /// meters east and north, would have been missed by now.
    ///
    /// # Errors
    /// As [`Tracker::handle`].
    pub fn handle_where_unseen(
        &mut self,
        frame: &Frame,
        unseen: &dyn Fn(Vector2<f64>) -> f64,
    ) -> Result<Outcome, FrameError> {
        frame.check()?;
        self.check_order(frame)?;
        let tracks = self.predicted(frame.time_ns);
        let assignment = self.assigned(&tracks, frame)?;

        let mut outcome = Outcome::default();
        self.tracks = tracks;
        self.judge(frame, &assignment, &mut outcome);
        self.max_range_meters = self.max_range_meters.max(frame.reach().max_range_meters);
        self.give_birth(frame, &assignment.observed_alone, unseen, &mut outcome);
        self.note(frame);
        Ok(outcome)
    }

    fn check_order(&self, frame: &Frame) -> Result<(), FrameError> {
        let Some(latest) = &self.latest else { return Ok(()) };
        if frame.time_ns < latest.time_ns {
            return Err(FrameError::Backwards { time_ns: frame.time_ns, latest_ns: latest.time_ns });
        }
        if frame.time_ns == latest.time_ns && latest.cameras.contains(&frame.camera) {
            return Err(FrameError::Repeated { time_ns: frame.time_ns, camera: frame.camera });
        }
        Ok(())
    }

    fn note(&mut self, frame: &Frame) {
        match &mut self.latest {
            Some(latest) if latest.time_ns == frame.time_ns => {
                latest.cameras.insert(frame.camera);
            }
            latest => {
                let cameras = BTreeSet::from([frame.camera]);
                *latest = Some(Latest { time_ns: frame.time_ns, cameras });
            }
        }
    }

    /// The tracks as they are expected to be at a time that is not before the latest.
    fn predicted(&self, time_ns: u64) -> Vec<Track> {
        let elapsed_seconds = seconds_between(self.latest_ns().unwrap_or(time_ns), time_ns);
        let mut tracks = self.tracks.clone();
        for track in &mut tracks {
            track.mixture.predict(elapsed_seconds, self.settings.acceleration_density);
        }
        tracks
    }

    /// The surest tracks have the first choice: what is not certain to be there takes no bearing from what is.
    fn assigned(&self, tracks: &[Track], frame: &Frame) -> Result<Assignment, AssignmentError> {
        let mut left: Vec<usize> = (0..frame.bearings_radians.len()).collect();
        let mut assignment = Assignment::default();
        let (gate_radians, view) =
            (self.settings.gate_radians, frame.widest_view(self.settings.gate_radians));
        for rank in [Rank::Established, Rank::Confirmed, Rank::Tentative] {
            let chosen: Vec<usize> =
                (0..tracks.len()).filter(|&track| tracks[track].rank() == rank).collect();
            let surprise = |track: usize, bearing: usize| {
                let sight = frame.sight(left[bearing]);
                let mixture = tracks[chosen[track]].mixture();
                mixture.surprise_nats(&sight, &frame.pose_error, gate_radians, &view)
            };
            let part = assign(chosen.len(), left.len(), MOST_SURPRISE_NATS, surprise)?;
            let pairs = part.pairs.iter().map(|&(track, bearing)| (chosen[track], left[bearing]));
            assignment.pairs.extend(pairs);
            assignment.predicted_alone.extend(part.predicted_alone.iter().map(|&track| chosen[track]));
            left = part.observed_alone.iter().map(|&bearing| left[bearing]).collect();
        }
        assignment.observed_alone = left;
        Ok(assignment)
    }

    /// Tells each track whether it was seen, and parts with the lost ones.
    fn judge(&mut self, frame: &Frame, assignment: &Assignment, outcome: &mut Outcome) {
        let mut bearing_of = vec![None; self.tracks.len()];
        assignment.pairs.iter().for_each(|&(track, bearing)| bearing_of[track] = Some(bearing));
        let settings = &self.settings;
        let mut bearing_of = bearing_of.into_iter();
        self.tracks.retain_mut(|track| {
            let fate = match bearing_of.next().flatten() {
                Some(bearing) => {
                    outcome.seen.push((track.id(), bearing));
                    track.seen(&frame.sight(bearing), frame, settings)
                }
                None => track.not_seen(frame, settings),
            };
            match fate {
                Fate::Confirmed => outcome.confirmed.push(track.id()),
                Fate::Lost => outcome.lost.push(track.id()),
                Fate::AsBefore => {}
            }
            fate != Fate::Lost
        });
    }

    fn give_birth(
        &mut self,
        frame: &Frame,
        bearings: &[usize],
        unseen: &dyn Fn(Vector2<f64>) -> f64,
        outcome: &mut Outcome,
    ) {
        let room = Self::MAX_TRACKS - self.tracks.len();
        outcome.refused_births = bearings.len().saturating_sub(room);
        for &bearing in bearings.iter().take(room) {
            let id = TrackId(self.next_id);
            self.next_id += 1;
            let (track, fate) =
                Track::born(id, &frame.sight(bearing), frame, self.max_range_meters, unseen, &self.settings);
            outcome.born.push(id);
            if fate == Fate::Confirmed {
                outcome.confirmed.push(id);
            }
            self.tracks.push(track);
        }
    }
}

pub(crate) fn seconds_between(from_ns: u64, to_ns: u64) -> f64 {
    to_ns.saturating_sub(from_ns) as f64 / 1e9
}

#[cfg(test)]
mod tests;
