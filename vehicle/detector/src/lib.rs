//! A detector of objects in a camera's images: from pixels to boxes.
//!
//! A network of the YOLO family (of version 11 in the paper's Section IV) processes a whole image at once, and returns
//! for thousands of positions in it, its anchors, the probability of each class and a box.
//!
//! 1. [`picture`]: an image of a camera;
//! 2. [`letterbox`]: its position in the network's input;
//! 3. [`prepare`]: the pixels of the input;
//! 4. [`network`]: the network, a TorchScript module or an ONNX file, and the metadata in its file;
//! 5. [`output`]: from its output to candidates;
//! 6. [`suppression`]: removal of candidates of the same object.
//!
//! Part 4 reads TorchScript modules with the feature `torch`, which needs libtorch, and ONNX files with the feature `onnx`,
//! which needs nothing else.

pub mod letterbox;
#[cfg(test)]
#[path = "../../../tests/mentions/mod.rs"]
mod mentions;
mod metadata;
pub mod network;
pub mod output;
pub mod picture;
pub mod prepare;
pub mod settings;
pub mod suppression;

use dragnet_vehicle::camera::{Camera, DetectionBox};
use letterbox::Letterbox;
use output::{Output, OutputError};
use settings::{Settings, SettingsError};

/// A detected object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Its box, pixels of the camera's image, within it.
    pub bounds: DetectionBox,
    /// Its class, in the network's order from 0.
    pub class: u32,
    /// Its probability, above [`Settings::confidence`], at most 1.
    pub confidence: f32,
}

/// The detections of an image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// At most [`Camera::MAX_BOXES`], most confident first, and of equals the one of the first anchor.
    pub detections: Vec<Detection>,
    /// Number of anchors with invalid output, which were ignored.
    pub refused_anchors: usize,
}

/// Why an output has no detections.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FindError {
    /// Invalid settings.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Not the output of a detector.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Too many boxes.
    #[error(
        "more than {max} boxes in one image: a higher confidence leaves fewer, or the detector is at fault",
        max = Camera::MAX_BOXES
    )]
    TooManyBoxes,
}

/// The detections in a network's output, for an image with this letterbox.
///
/// # Errors
/// If the settings are invalid, all anchors are invalid, or there are more boxes than an image can have.
pub fn find(output: &Output<'_>, letterbox: &Letterbox, settings: &Settings) -> Result<Found, FindError> {
    settings.check()?;
    let (candidates, refused_anchors) = output.candidates(settings)?;
    let kept =
        suppression::suppress(candidates, settings, Camera::MAX_BOXES).ok_or(FindError::TooManyBoxes)?;
    let detections = kept.iter().filter_map(|candidate| {
        // A box in the padding alone is not in the image.
        let bounds = letterbox.bounds_in_image(&candidate.bounds)?;
        Some(Detection { bounds, class: candidate.class, confidence: candidate.confidence })
    });
    Ok(Found { detections: detections.collect(), refused_anchors })
}

#[cfg(test)]
mod tests;
