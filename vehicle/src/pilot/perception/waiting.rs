//! Frames of several cameras, put into the order of their stamps.
//!
//! Cameras tell of a time at different times: one has its detector on board, another one sends images far. What
//! is followed needs one order. So a frame waits until all other cameras have told of its time or a later one;
//! a camera that says nothing for long is not waited for, and no frame waits longer than the window. A frame
//! of a time before what was taken in already comes too late. The same stamp of two cameras is one time, and
//! of one camera one image.

use std::collections::VecDeque;

use super::super::CameraFrame;
use crate::camera::Detections;

/// Frames that wait.
#[derive(Clone, Debug)]
pub(super) struct Waiting {
    window_ns: u64,
    /// A camera that said nothing for longer is not waited for.
    silence_ns: u64,
    cameras: Vec<Source>,
    /// By stamp, and as they came.
    frames: VecDeque<Frame>,
    /// The stamp of the latest frame that was taken.
    taken_ns: Option<u64>,
}

/// A camera.
#[derive(Clone, Copy, Debug, Default)]
#[expect(clippy::struct_field_names, reason = "each ends with its unit")]
struct Source {
    /// When it last gave a frame; before the first, when it was expected to.
    heard_ns: Option<u64>,
    /// The latest stamp.
    latest_ns: Option<u64>,
    /// The stamp of its frame that was taken last.
    taken_ns: Option<u64>,
}

#[derive(Clone, Debug)]
struct Frame {
    came_ns: u64,
    camera: usize,
    content: CameraFrame,
    detections: Detections,
}

/// What becomes of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Arrival {
    /// It waits for its turn.
    Waits,
    /// It is there already.
    Again,
    /// Later ones were taken in.
    Late {
        /// By how much.
        by_ns: u64,
    },
    /// The oldest one was dropped for it.
    TooMany,
}

impl Waiting {
    /// So many frames may wait.
    pub(super) const MOST: usize = 1024;

    pub(super) fn new(cameras: usize, window_ns: u64, silence_ns: u64) -> Self {
        let cameras = vec![Source::default(); cameras];
        Self { window_ns, silence_ns, cameras, frames: VecDeque::new(), taken_ns: None }
    }

    /// From the first event on, frames are expected.
    pub(super) fn begin(&mut self, now_ns: u64) {
        for camera in &mut self.cameras {
            camera.heard_ns.get_or_insert(now_ns);
        }
    }

    /// No stamp from before means anything.
    pub(super) fn restart(&mut self, now_ns: u64) {
        self.frames.clear();
        self.taken_ns = None;
        self.cameras.fill(Source { heard_ns: Some(now_ns), ..Source::default() });
    }

    /// Takes in a frame of a camera, by its number.
    pub(super) fn put(
        &mut self,
        now_ns: u64,
        camera: usize,
        frame: CameraFrame,
        detections: Detections,
    ) -> Arrival {
        let time_ns = frame.time_ns;
        let source = &mut self.cameras[camera];
        source.heard_ns = Some(now_ns);
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
            let silence_ns = now_ns.saturating_sub(source.heard_ns.unwrap_or(now_ns));
            source.latest_ns < Some(time_ns) && silence_ns <= self.silence_ns
        };
        (has_waited || !self.cameras.iter().any(is_behind)).then_some(time_ns)
    }

    /// Takes that frame: its camera's number, and what is in it.
    pub(super) fn take(&mut self) -> Option<(usize, CameraFrame, Detections)> {
        let Frame { camera, content: frame, detections, .. } = self.frames.pop_front()?;
        self.taken_ns = Some(frame.time_ns);
        self.cameras[camera].taken_ns = Some(frame.time_ns);
        Some((camera, frame, detections))
    }
}
