//! Positions of objects from bearings alone, measured by the cameras of a moving vehicle.
//!
//! Each track is a range-parameterized cubature Kalman filter ([`mixture`]). A frame is one image of one camera. Its
//! bearings are assigned to tracks by likelihood ([`crate::assignment`]), to confirmed ones first; unassigned ones
//! become new tracks. A track is confirmed once it was detected in enough of its first frames, and lost when it is
//! missed too often ([`track`]).
//!
//! State changes only in [`Tracker::handle`], which rejects an invalid frame without changing anything.

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

use nalgebra::{Matrix2, Vector2};

use crate::assignment::{Assignment, AssignmentError, assign};
use frame::{Frame, FrameError};
use settings::{Settings, SettingsError};
use track::{FrameResult, Rank, Track, TrackId};

/// Surprise above which a bearing is not assigned to a track, nats.
const MOST_SURPRISE_NATS: f64 = 6.0;

/// All tracks of a vehicle.
#[derive(Clone, Debug)]
pub struct Tracker {
    settings: Settings,
    tracks: Vec<Track>,
    next_id: u64,
    latest: Option<Latest>,
    /// The largest range of any camera so far, meters.
    max_range_meters: f64,
}

/// The latest time of frames.
#[derive(Clone, Debug)]
struct Latest {
    time_ns: u64,
    cameras: BTreeSet<u16>,
}

/// The changes by a frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Detected tracks, each with the index of its bearing in the frame.
    pub seen: Vec<(TrackId, usize)>,
    /// New tracks, each with the index of the bearing of the frame with which it begins.
    pub born: Vec<(TrackId, usize)>,
    /// Tracks that are confirmed from now on.
    pub confirmed: Vec<TrackId>,
    /// Tracks that have ended.
    pub lost: Vec<TrackId>,
    /// Bearings that would have begun a track beyond [`Tracker::MAX_TRACKS`].
    pub refused_births: usize,
}

/// What is known of the ground when a frame is taken, by position, meters east and north.
pub struct Surroundings<'a> {
    /// The probability, 0 to 1, that an object there has been missed so far.
    pub unseen: &'a dyn Fn(Vector2<f64>) -> f64,
    /// Whether a wall hides an object there from the frame's camera.
    pub is_hidden: &'a dyn Fn(Vector2<f64>) -> bool,
}

impl Tracker {
    /// The maximum number of tracks: more are caused by a faulty detector.
    pub const MAX_TRACKS: usize = 256;

    /// A tracker without tracks.
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

    /// Time of the latest frame, nanoseconds of mission time; `None` before the first.
    #[must_use]
    pub fn latest_ns(&self) -> Option<u64> {
        self.latest.as_ref().map(|latest| latest.time_ns)
    }

    /// Processes one frame of one camera. Several cameras may have frames of one time.
    ///
    /// # Errors
    /// If the frame is invalid, is older than the latest one, or repeats a time of its camera. The state is unchanged
    /// in that case.
    pub fn handle(&mut self, frame: &Frame) -> Result<Outcome, FrameError> {
        self.handle_among(frame, &Surroundings { unseen: &|_| 1.0, is_hidden: &|_| false })
    }

    /// Like [`Tracker::handle`], with knowledge of earlier frames and of walls.
    ///
    /// # Errors
    /// As [`Tracker::handle`].
    pub fn handle_among(
        &mut self,
        frame: &Frame,
        surroundings: &Surroundings<'_>,
    ) -> Result<Outcome, FrameError> {
        frame.check()?;
        self.check_order(frame)?;
        let tracks = self.predicted(frame.time_ns);
        let assignment = self.assigned(&tracks, frame)?;

        let mut outcome = Outcome::default();
        self.tracks = tracks;
        self.judge(frame, surroundings, &assignment, &mut outcome);
        self.max_range_meters = self.max_range_meters.max(frame.reach().max_range_meters);
        self.give_birth(frame, surroundings, &assignment.observed_alone, &mut outcome);
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

    /// The tracks as predicted for a time that is not before the latest.
    fn predicted(&self, time_ns: u64) -> Vec<Track> {
        let elapsed_seconds = seconds_between(self.latest_ns().unwrap_or(time_ns), time_ns);
        let mut tracks = self.tracks.clone();
        for track in &mut tracks {
            track.mixture.predict(elapsed_seconds, self.settings.acceleration_density);
        }
        tracks
    }

    /// The most certain tracks choose first: an uncertain one takes no bearing from a certain one.
    fn assigned(&self, tracks: &[Track], frame: &Frame) -> Result<Assignment, AssignmentError> {
        let mut left: Vec<usize> = (0..frame.bearings_radians.len()).collect();
        let mut assignment = Assignment::default();
        let (gate_radians, view) =
            (self.settings.gate_radians, frame.widest_view(self.settings.gate_radians));
        for rank in [Rank::Established, Rank::Confirmed, Rank::Tentative] {
            let chosen: Vec<usize> =
                (0..tracks.len()).filter(|&track| tracks[track].rank() == rank).collect();
            let surprise = |track: usize, bearing: usize| {
                let measurement = frame.measurement(left[bearing]);
                let mixture = tracks[chosen[track]].mixture();
                mixture.surprise_nats(&measurement, &frame.pose_error, gate_radians, &view)
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

    /// Updates each track as detected or missed, and removes the lost ones.
    fn judge(
        &mut self,
        frame: &Frame,
        surroundings: &Surroundings<'_>,
        assignment: &Assignment,
        outcome: &mut Outcome,
    ) {
        let mut bearing_of = vec![None; self.tracks.len()];
        assignment.pairs.iter().for_each(|&(track, bearing)| bearing_of[track] = Some(bearing));
        let settings = &self.settings;
        let mut bearing_of = bearing_of.into_iter();
        self.tracks.retain_mut(|track| {
            let fate = match bearing_of.next().flatten() {
                Some(bearing) => {
                    outcome.seen.push((track.id(), bearing));
                    track.seen(&frame.measurement(bearing), frame, surroundings, settings)
                }
                None => track.not_seen(frame, surroundings, settings),
            };
            match fate {
                FrameResult::Confirmed => outcome.confirmed.push(track.id()),
                FrameResult::Lost => outcome.lost.push(track.id()),
                FrameResult::AsBefore => {}
            }
            fate != FrameResult::Lost
        });
    }

    fn give_birth(
        &mut self,
        frame: &Frame,
        surroundings: &Surroundings<'_>,
        bearings: &[usize],
        outcome: &mut Outcome,
    ) {
        let room = Self::MAX_TRACKS - self.tracks.len();
        outcome.refused_births = bearings.len().saturating_sub(room);
        for &bearing in bearings.iter().take(room) {
            let id = TrackId(self.next_id);
            self.next_id += 1;
            let (track, fate) = Track::born(
                id,
                &frame.measurement(bearing),
                frame,
                self.max_range_meters,
                surroundings,
                &self.settings,
            );
            outcome.born.push((id, bearing));
            if fate == FrameResult::Confirmed {
                outcome.confirmed.push(id);
            }
            self.tracks.push(track);
        }
    }
}

/// Standard deviation in the most uncertain direction of a covariance, square meters: meters.
pub(crate) fn largest_std_meters(covariance: &Matrix2<f64>) -> f64 {
    covariance.symmetric_eigenvalues().max().max(0.0).sqrt()
}

pub(crate) fn seconds_between(from_ns: u64, to_ns: u64) -> f64 {
    to_ns.saturating_sub(from_ns) as f64 / 1e9
}

#[cfg(test)]
mod tests;
