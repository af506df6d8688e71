//! Orders the frames of several cameras by their stamps.
//!
//! Cameras have different latencies: one has its detector on board, another sends images over a network. Tracking needs
//! one order. So a frame waits until all other cameras have reached its time; a silent camera is not waited for, and no
//! frame waits longer than the window. A frame from before the last processed time is too late. Equal stamps of two
//! cameras are one time, and of one camera one image.

use std::collections::VecDeque;

use super::super::CameraFrame;
use crate::camera::Detections;

/// Waiting frames.
#[derive(Clone, Debug)]
pub(super) struct Waiting {
    window_ns: u64,
    /// Silence after which a camera is not waited for.
    silence_ns: u64,
    cameras: Vec<Source>,
    /// By stamp, then by arrival.
    frames: VecDeque<Frame>,
    /// The stamp of the latest processed frame.
    taken_ns: Option<u64>,
}

/// A camera.
#[derive(Clone, Copy, Debug, Default)]
#[expect(clippy::struct_field_names, reason = "each ends with its unit")]
struct Source {
    /// Time of its last frame; before the first, when it was expected to begin.
    received_ns: Option<u64>,
    /// The latest stamp.
    latest_ns: Option<u64>,
    /// The stamp of its last processed frame.
    taken_ns: Option<u64>,
}

#[derive(Clone, Debug)]
struct Frame {
    came_ns: u64,
    camera: usize,
    content: CameraFrame,
    detections: Detections,
}

/// The result of adding a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Arrival {
    /// It waits for its turn.
    Waits,
    /// It is a duplicate.
    Again,
    /// Later ones have been processed.
    Late {
        /// By how much it is late.
        by_ns: u64,
    },
    /// The oldest one was dropped for it.
    TooMany,
}

impl Waiting {
    /// The maximum number of waiting frames.
    pub(super) const MOST: usize = 1024;

    pub(super) fn new(cameras: usize, window_ns: u64, silence_ns: u64) -> Self {
        let cameras = vec![Source::default(); cameras];
        Self { window_ns, silence_ns, cameras, frames: VecDeque::new(), taken_ns: None }
    }

    /// From the first event on, frames are expected.
    pub(super) fn begin(&mut self, now_ns: u64) {
        for camera in &mut self.cameras {
            camera.received_ns.get_or_insert(now_ns);
        }
    }

    /// Earlier stamps have no meaning.
    pub(super) fn restart(&mut self, now_ns: u64) {
        self.frames.clear();
        self.taken_ns = None;
        self.cameras.fill(Source { received_ns: Some(now_ns), ..Source::default() });
    }

    /// Adds a frame of a camera, by its index.
    pub(super) fn put(
        &mut self,
        now_ns: u64,
        camera: usize,
        frame: CameraFrame,
        detections: Detections,
    ) -> Arrival {
        let time_ns = frame.time_ns;
        let source = &mut self.cameras[camera];
        source.received_ns = Some(now_ns);
        source.latest_ns = source.latest_ns.max(Some(time_ns));
        let is_same = |it: &Frame| it.camera == camera && it.content.time_ns == time_ns;
        if source.taken_ns == Some(time_ns) || self.frames.iter().any(is_same) {
            return Arrival::Again;
        }
        if let Some(taken_ns) = self.taken_ns.filter(|&taken_ns| time_ns < taken_ns) {
            return Arrival::Late { by_ns: taken_ns - time_ns };
        }
        let place = self.frames.partition_point(|it| it.content.time_ns <= time_ns);
        self.frames.insert(place, Frame { came_ns: now_ns, camera, content: frame, detections });
        if self.frames.len() <= Self::MOST {
            return Arrival::Waits;
        }
        self.frames.pop_front();
        Arrival::TooMany
    }

    /// The stamp of the next frame, if its turn has come.
    pub(super) fn next_ns(&self, now_ns: u64) -> Option<u64> {
        let next = self.frames.front()?;
        let time_ns = next.content.time_ns;
        let has_waited = now_ns.saturating_sub(next.came_ns) >= self.window_ns;
        let is_behind = |source: &Source| {
            let silence_ns = now_ns.saturating_sub(source.received_ns.unwrap_or(now_ns));
            source.latest_ns < Some(time_ns) && silence_ns <= self.silence_ns
        };
        (has_waited || !self.cameras.iter().any(is_behind)).then_some(time_ns)
    }

    /// Takes that frame: its camera's index, and its content.
    pub(super) fn take(&mut self) -> Option<(usize, CameraFrame, Detections)> {
        let Frame { camera, content: frame, detections, .. } = self.frames.pop_front()?;
        self.taken_ns = Some(frame.time_ns);
        self.cameras[camera].taken_ns = Some(frame.time_ns);
        Some((camera, frame, detections))
    }
}
