//! A detector's boxes in one image.

use super::InputError;
use super::check::Check;
use crate::schema::RosMessage;
use crate::wire::vision::{self, BoundingBox2D, Detection2DArray};

/// The maximum number of boxes in an image.
const MAX_BOXES: usize = 256;
/// The maximum number of hypotheses of one box.
const MAX_HYPOTHESES: usize = 128;

/// All boxes of one image; an empty list means that nothing was detected.
#[derive(Clone, Debug, PartialEq)]
pub struct Detections {
    /// When the image was taken, Unix nanoseconds.
    pub stamp_unix_ns: i64,
    /// The frame of the camera.
    pub frame: String,
    /// At most 256.
    pub boxes: Vec<DetectedBox>,
}

/// A box in an image. Pixels count from the left and the upper edge; whether it lies in the image is not checked here,
/// where the image's size is unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct DetectedBox {
    /// Left edge, pixels.
    pub left: f64,
    /// Upper edge, pixels.
    pub top: f64,
    /// Right edge, pixels, beyond the left one.
    pub right: f64,
    /// Lower edge, pixels, below the upper one.
    pub bottom: f64,
    /// Its most likely class; `None` if the detector gives none.
    pub hypothesis: Option<Hypothesis>,
}

/// A class of a box, and its score.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypothesis {
    /// The detector's name of the class, at most 256 bytes.
    pub class: String,
    /// The detector's score, `0..=1`.
    pub score: f64,
}

impl Detections {
    pub(super) fn check(array: Detection2DArray) -> Result<Self, InputError> {
        let check = Check { message: Detection2DArray::NAME };
        let (stamp_unix_ns, frame) = check.header(&array.header)?;
        check.at_most("detections", array.detections.len(), MAX_BOXES)?;
        let boxes = array.detections.into_iter().enumerate();
        let boxes =
            boxes.map(|(index, detection)| check.detected(index, detection)).collect::<Result<_, _>>()?;
        Ok(Self { stamp_unix_ns, frame, boxes })
    }
}

impl Check {
    fn detected(self, index: usize, detection: vision::Detection2D) -> Result<DetectedBox, InputError> {
        let at = |field: &str| format!("detections[{index}].{field}");
        self.at_most(&at("results"), detection.results.len(), MAX_HYPOTHESES)?;
        let mut best: Option<Hypothesis> = None;
        for result in detection.results {
            let hypothesis = result.hypothesis;
            let score = self.within(&at("results.hypothesis.score"), hypothesis.score, &(0.0..=1.0))?;
            self.text(&at("results.hypothesis.class_id"), &hypothesis.class_id)?;
            if best.as_ref().is_none_or(|best| score > best.score) {
                best = Some(Hypothesis { class: hypothesis.class_id, score });
            }
        }
        let (width, height) = self.turned_size(&at("bbox"), &detection.bbox)?;
        let center = detection.bbox.center.position;
        let (x, y) = (
            self.finite(&at("bbox.center.position.x"), center.x)?,
            self.finite(&at("bbox.center.position.y"), center.y)?,
        );
        Ok(DetectedBox {
            left: x - width / 2.0,
            top: y - height / 2.0,
            right: x + width / 2.0,
            bottom: y + height / 2.0,
            hypothesis: best,
        })
    }

    /// Width and height of the axis-aligned box around a rotated one, pixels.
    fn turned_size(self, field: &str, found: &BoundingBox2D) -> Result<(f64, f64), InputError> {
        let (sine, cosine) = self.finite(&format!("{field}.center.theta"), found.center.theta)?.sin_cos();
        let positive = |name: &str, pixels: f64| {
            // Written so that NaN fails as well.
            if pixels > 0.0 && pixels.is_finite() {
                Ok(pixels)
            } else {
                self.refused(format!("{field}.{name}"), pixels, "above 0 pixels")
            }
        };
        let (x, y) = (positive("size_x", found.size_x)?, positive("size_y", found.size_y)?);
        Ok((x * cosine.abs() + y * sine.abs(), x * sine.abs() + y * cosine.abs()))
    }
}
