//! The output of a network, in the format of YOLO from version 8 on.

use crate::settings::Settings;
use dragnet_vehicle::camera::DetectionBox;

/// The output for one image, shape `[4 + classes, anchors]`: center column, center row, width and height of an anchor's
/// box in pixels of the input, then the probability of each class, 0 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Output<'a> {
    values: &'a [f32],
    anchors: usize,
}

/// A detection of an anchor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Its box, in pixels of the input.
    pub bounds: DetectionBox,
    /// Its most probable class, the first of equals.
    pub class: u32,
    /// The probability of that class.
    pub confidence: f32,
}

/// An unsupported output.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OutputError {
    /// An unsupported shape.
    #[error(
        "an output of shape {0:?}: understood is [1, 4 + classes, anchors] of YOLO from version 8 on, without suppression, \
         with up to {max_classes} classes and {max_anchors} anchors",
        max_classes = Output::MAX_CLASSES,
        max_anchors = Output::MAX_ANCHORS
    )]
    Shape(Vec<i64>),
    /// The number of values does not match the shape.
    #[error("an output of shape {shape:?} with {given} numbers")]
    Count {
        /// The given shape.
        shape: Vec<i64>,
        /// The number of values.
        given: usize,
    },
    /// Every anchor is invalid.
    #[error(
        "none of {anchors} anchors is a box with probabilities: the first has {value} where {wanted} belongs"
    )]
    NoAnchor {
        /// Number of anchors.
        anchors: usize,
        /// The first invalid value of the first one.
        value: f32,
        /// The allowed values.
        wanted: &'static str,
    },
}

const A_PLACE: &str = "a number of pixels";
const A_SIDE: &str = "a positive number of pixels";
const A_PROBABILITY: &str = "a probability from 0 to 1";

/// The most probable class of an anchor.
#[derive(Clone, Copy)]
struct Best {
    class: u32,
    confidence: f32,
    /// Of all classes.
    are_probabilities: bool,
}

impl<'a> Output<'a> {
    /// The maximum number of classes.
    pub const MAX_CLASSES: usize = 10_000;
    /// The maximum number of anchors: those of an input of 7000 x 7000 pixels.
    pub const MAX_ANCHORS: usize = 1 << 20;

    /// Number of classes and anchors of an output of shape `[1, 4 + classes, anchors]`.
    ///
    /// # Errors
    /// If it has another shape.
    pub fn classes_and_anchors(shape: &[i64]) -> Result<(usize, usize), OutputError> {
        let sizes = || {
            let &[1, channels, anchors] = shape else { return None };
            let classes = usize::try_from(channels).ok()?.checked_sub(4)?;
            Some((classes, usize::try_from(anchors).ok()?))
        };
        sizes()
            .filter(|(classes, anchors)| {
                (1..=Self::MAX_CLASSES).contains(classes) && (1..=Self::MAX_ANCHORS).contains(anchors)
            })
            .ok_or_else(|| OutputError::Shape(shape.to_vec()))
    }

    /// An output with these values, in the order of `shape`, `[1, 4 + classes, anchors]`.
    ///
    /// # Errors
    /// If the shape is another one, or does not match the number of values.
    pub fn new(values: &'a [f32], shape: &[i64]) -> Result<Self, OutputError> {
        let (classes, anchors) = Self::classes_and_anchors(shape)?;
        if values.len() != (4 + classes) * anchors {
            return Err(OutputError::Count { shape: shape.to_vec(), given: values.len() });
        }
        Ok(Self { values, anchors })
    }

    /// The candidates that the settings select, in the order of anchors; and the number of invalid anchors.
    ///
    /// # Errors
    /// If all of them are invalid.
    pub fn candidates(&self, settings: &Settings) -> Result<(Vec<Candidate>, usize), OutputError> {
        let mut candidates = Vec::new();
        let mut refused = 0;
        for (anchor, best) in self.best().into_iter().enumerate() {
            let Some(bounds) = self.bounds(anchor).filter(|_| best.are_probabilities) else {
                refused += 1;
                continue;
            };
            if best.confidence > settings.confidence && settings.classes.contains(best.class) {
                candidates.push(Candidate { bounds, class: best.class, confidence: best.confidence });
            }
        }
        if refused == self.anchors { Err(self.refusal()) } else { Ok((candidates, refused)) }
    }

    /// For each anchor. Iterates class by class, in memory order.
    fn best(&self) -> Vec<Best> {
        let none = Best { class: 0, confidence: f32::NEG_INFINITY, are_probabilities: true };
        let mut best = vec![none; self.anchors];
        for (class, confidences) in (0..).zip(self.values[4 * self.anchors..].chunks_exact(self.anchors)) {
            for (best, &confidence) in best.iter_mut().zip(confidences) {
                // NaN lies in no range.
                best.are_probabilities &= (0.0..=1.0).contains(&confidence);
                if confidence > best.confidence {
                    (best.class, best.confidence) = (class, confidence);
                }
            }
        }
        best
    }

    fn row(&self, row: usize, anchor: usize) -> f32 {
        self.values[row * self.anchors + anchor]
    }

    fn bounds(&self, anchor: usize) -> Option<DetectionBox> {
        let [column, row, width, height] = [0, 1, 2, 3].map(|part| self.row(part, anchor));
        let is_box =
            [column, row, width, height].iter().all(|part| part.is_finite()) && width > 0.0 && height > 0.0;
        // Exact: a sum of two f32 has its place in an f64.
        let (half_width, half_height) = (f64::from(width) / 2.0, f64::from(height) / 2.0);
        is_box.then(|| DetectionBox {
            left: f64::from(column) - half_width,
            top: f64::from(row) - half_height,
            right: f64::from(column) + half_width,
            bottom: f64::from(row) + half_height,
        })
    }

    /// The error if all anchors are invalid.
    fn refusal(&self) -> OutputError {
        let rows = self.values.len() / self.anchors;
        let wrong = (0..rows).map(|row| (row, self.row(row, 0))).find_map(|(row, value)| {
            let (is_right, wanted) = match row {
                0 | 1 => (value.is_finite(), A_PLACE),
                2 | 3 => (value.is_finite() && value > 0.0, A_SIDE),
                _ => ((0.0..=1.0).contains(&value), A_PROBABILITY),
            };
            (!is_right).then_some((value, wanted))
        });
        debug_assert!(wrong.is_some(), "it was rejected");
        let (value, wanted) = wrong.unwrap_or((f32::NAN, A_PLACE));
        OutputError::NoAnchor { anchors: self.anchors, value, wanted }
    }
}
