//! A detector of objects in a camera's images: from pixels to boxes.
//!
//! A network of the YOLO family (of version 11 in the paper's Section IV) looks at a whole image once, and says of
//! thousands of places in it, its anchors, how probable an object of each class is there, and in which box it lies.
//!
//! 1. [`picture`]: an image as a camera gives it;
//! 2. [`letterbox`]: how it lies in the square, or other, image that the network takes;
//! 3. [`prepare`]: the pixels of that;
//! 4. [`network`]: the network, a TorchScript module, and what its file says of itself;
//! 5. [`output`]: from its numbers to candidates;
//! 6. [`suppression`]: of candidates that are one object, the most confident.
//!
//! Part 4 needs libtorch; the others know numbers alone.

pub mod letterbox;
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

/// An object, as the detector sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Where it is, pixels of the camera's image, within it.
    pub bounds: DetectionBox,
    /// Which class, in the network's order from 0.
    pub class: u32,
    /// How probable, above [`Settings::confidence`], at most 1.
    pub confidence: f32,
}

/// What was found in an image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// At most [`Camera::MAX_BOXES`], most confident first, and of equals the one of the first anchor.
    pub detections: Vec<Detection>,
    /// Anchors of which the network said what cannot be; they were left out.
    pub refused_anchors: usize,
}

/// Why an output says nothing of its image.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FindError {
    /// Settings out of their ranges.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Not the numbers of a detector.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// More than an image can hold objects.
    #[error(
        "more than {max} boxes in one image: a higher confidence leaves fewer, or the detector is at fault",
        max = Camera::MAX_BOXES
    )]
    TooManyBoxes,
}

/// What a network's output says of the image that was letterboxed for it.
///
/// # Errors
/// If the settings cannot be, none of its anchors is a box with probabilities, or there are more boxes than an image can
/// hold objects.
pub fn find(output: &Output<'_>, letterbox: &Letterbox, settings: &Settings) -> Result<Found, FindError> {
    settings.check()?;
    let (candidates, refused_anchors) = output.candidates(settings)?;
    let kept =
        suppression::suppress(candidates, settings, Camera::MAX_BOXES).ok_or(FindError::TooManyBoxes)?;
    let detections = kept.iter().filter_map(|candidate| {
        // What lies in the padding alone is none of the image.
        let bounds = letterbox.bounds_in_image(&candidate.bounds)?;
        Some(Detection { bounds, class: candidate.class, confidence: candidate.confidence })
    });
    Ok(Found { detections: detections.collect(), refused_anchors })
}

#[cfg(test)]
mod tests;
