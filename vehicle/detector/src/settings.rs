//! Settings of a detector.

use std::collections::BTreeSet;

/// Settings for reading outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Probability above which a candidate counts, 0 to 1.
    pub confidence: f32,
    /// Intersection over union above which two boxes count as one object, 0 to 1.
    pub iou: f32,
    /// Classes that count.
    pub classes: Classes,
    /// Which boxes are compared with each other.
    pub suppression: Suppression,
    /// The reduction of images before they are letterboxed.
    pub resolution: Resolution,
}

/// Classes that count.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Classes {
    /// Any.
    All,
    /// These, in the network's order from 0. An anchor with a more probable other class does not count.
    Only(BTreeSet<u32>),
}

/// Which boxes are compared with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suppression {
    /// Those of the same class.
    ByClass,
    /// All, whatever their class.
    Agnostic,
}

/// The reduction of images before they are letterboxed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resolution {
    /// None.
    Full,
    /// To half as many columns and rows, as in the paper's Section IV: 5320 x 3032 pixels to 2660 x 1516.
    Half,
}

/// What a network runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Processor {
    /// Number of threads on the CPU, at least 1.
    pub threads: u16,
    /// Whether to use a GPU if there is one that the runtime of the network's format can use: libtorch's alone.
    pub may_use_gpu: bool,
}

/// A setting out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// The confidence is not a probability.
    #[error("a confidence of {0}: allowed is 0 to 1")]
    Confidence(f32),
    /// The `IoU` is not within 0 to 1.
    #[error("an IoU of {0}: allowed is 0 to 1")]
    Iou(f32),
    /// No class is selected.
    #[error("no class counts: needed is at least one, or all")]
    NoClass,
}

impl Default for Settings {
    /// The usual confidence and `IoU` of YOLO, and the paper's resolution.
    fn default() -> Self {
        Self {
            confidence: 0.25,
            iou: 0.7,
            classes: Classes::All,
            suppression: Suppression::ByClass,
            resolution: Resolution::Half,
        }
    }
}

impl Default for Processor {
    /// One core.
    fn default() -> Self {
        Self { threads: 1, may_use_gpu: false }
    }
}

impl Settings {
    pub(super) fn check(&self) -> Result<(), SettingsError> {
        // NaN is in no range.
        if !(0.0..=1.0).contains(&self.confidence) {
            return Err(SettingsError::Confidence(self.confidence));
        }
        if !(0.0..=1.0).contains(&self.iou) {
            return Err(SettingsError::Iou(self.iou));
        }
        if self.classes == Classes::Only(BTreeSet::new()) {
            return Err(SettingsError::NoClass);
        }
        Ok(())
    }
}

impl Classes {
    /// Whether a class is selected.
    #[must_use]
    pub fn contains(&self, class: u32) -> bool {
        match self {
            Self::All => true,
            Self::Only(classes) => classes.contains(&class),
        }
    }
}

impl Resolution {
    /// Columns of an image per column after the reduction, and rows per row.
    #[must_use]
    pub const fn factor(self) -> u32 {
        match self {
            Self::Full => 1,
            Self::Half => 2,
        }
    }
}
