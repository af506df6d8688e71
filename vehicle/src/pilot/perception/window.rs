//! The last frames of a camera, of which older ones count less and less.

/// Number of frames that count.
const FRAMES: f64 = 300.0;
/// Frames before which nothing is said of them.
const LEAST_FRAMES: f64 = 100.0;
/// The share of a count that a frame leaves of it.
pub(super) const KEPT: f64 = 1.0 - 1.0 / FRAMES;

/// The number of these frames.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Window {
    frames: f64,
}

impl Window {
    pub(super) fn add(&mut self) {
        self.frames = self.frames * KEPT + 1.0;
    }

    pub(super) const fn frames(self) -> f64 {
        self.frames
    }

    /// Whether there are enough of them to judge a camera by.
    pub(super) fn is_enough(self) -> bool {
        self.frames >= LEAST_FRAMES
    }
}
