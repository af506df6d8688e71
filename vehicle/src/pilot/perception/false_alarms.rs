//! How many false alarms a camera's detector makes, compared with its settings.
//!
//! Each detection that no track explains begins one, and a false alarm's track is never confirmed. Too many of them are
//! confirmed all the same if the settings promise few: then wrong cells are declared.

use super::window::{KEPT, Window};
use crate::pilot::diagnostic::Fault;

/// Factor by which there may be more false alarms than the settings say,
const TOLERANCE: f64 = 2.0;
/// and standard deviations of their number beyond it. The fault lasts until there are no more than they say: tracks of
/// false alarms explain others.
const DEVIATIONS: f64 = 4.0;

/// The counts of one camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct FalseAlarms {
    expected_per_frame: f64,
    window: Window,
    alarms: f64,
    are_many: bool,
}

impl FalseAlarms {
    /// No frames yet of a camera with so many false alarms in each, by its settings.
    pub(super) fn new(expected_per_frame: f64) -> Self {
        Self { expected_per_frame, window: Window::default(), alarms: 0.0, are_many: false }
    }

    /// Adds a frame, with the numbers of tracks that it begins and that it confirms.
    pub(super) fn add(&mut self, born: usize, confirmed: usize) {
        self.window.add();
        self.alarms = (self.alarms * KEPT + born as f64 - confirmed as f64).max(0.0);
        let expected = self.expected_per_frame * self.window.frames();
        let most = TOLERANCE * expected;
        self.are_many = self.window.is_enough()
            && self.alarms > if self.are_many { expected } else { most + DEVIATIONS * most.sqrt() };
    }

    /// What is wrong if more false alarms are seen than the settings say.
    pub(super) fn fault(&self) -> Option<Fault> {
        if !self.are_many {
            return None;
        }
        let (per_frame, expected) = (self.alarms / self.window.frames(), self.expected_per_frame);
        let message = format!(
            "{per_frame:.2} false alarms a frame, and tracker.false_alarms_per_frame is {expected}: objects may be declared \
             where none are; set it, or raise the detector's threshold"
        );
        Some(Fault::new("more", &message, &[("false_alarms_per_frame", per_frame)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of which each `period`th begins a track, and each `real`th confirms one.
    fn fault(frames: usize, period: usize, real: usize) -> Option<Fault> {
        let mut alarms = FalseAlarms::new(0.05);
        for frame in 1..=frames {
            alarms.add(usize::from(frame % period == 0), usize::from(frame % real == 0));
        }
        alarms.fault()
    }

    #[test]
    fn more_false_alarms_than_the_settings_say_are_a_fault() {
        assert!(fault(1000, 20, usize::MAX).is_none(), "as many as they say");
        assert!(fault(90, 1, usize::MAX).is_none(), "too few frames to say");
        assert!(fault(1000, 2, usize::MAX).unwrap().to_string().starts_with("0.50 false alarms a frame"));
        assert!(fault(1000, 2, 2).is_none(), "each is of an object");
    }
}
