//! What the numbers of a network say, as YOLO from version 8 on has them.

use crate::settings::Settings;
use dragnet_vehicle::camera::DetectionBox;

/// The numbers of one image, shape `[4 + classes, anchors]`: middle column, middle row, width and height of an anchor's
/// box in pixels of the input, then how probable each class is, 0 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Output<'a> {
    values: &'a [f32],
    anchors: usize,
}

/// An object as an anchor sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Where, in pixels of the input.
    pub bounds: DetectionBox,
    /// Its most probable class, the first of equals.
    pub class: u32,
    /// How probable that is.
    pub confidence: f32,
}

/// An output that is not understood.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OutputError {
    /// Numbers for something else.
    #[error(
        "an output of shape {0:?}: understood is [1, 4 + classes, anchors] of YOLO from version 8 on, without suppression, \
         with up to {max_classes} classes and {max_anchors} anchors",
        max_classes = Output::MAX_CLASSES,
        max_anchors = Output::MAX_ANCHORS
    )]
    Shape(Vec<i64>),
    /// A caller's mistake.
    #[error("an output of shape {shape:?} with {given} numbers")]
    Count {
        /// As given.
        shape: Vec<i64>,
        /// As many numbers as there are.
        given: usize,
    },
    /// Every anchor is refused.
    #[error(
        "none of {anchors} anchors is a box with probabilities: the first has {value} where {wanted} belongs"
    )]
    NoAnchor {
        /// As many as there are.
        anchors: usize,
        /// The first number that cannot be, of the first of them.
        value: f32,
        /// What could be.
        wanted: &'static str,
    },
}

const A_PLACE: &str = "a number of pixels";
const A_SIDE: &str = "a positive number of pixels";
const A_PROBABILITY: &str = "a probability from 0 to 1";

/// How probable the most probable class of an anchor is.
#[derive(Clone, Copy)]
struct Best {
    class: u32,
    confidence: f32,
    /// Of all classes.
    are_probabilities: bool,
}

impl<'a> Output<'a> {
    /// So many classes may a network tell apart.
    pub const MAX_CLASSES: usize = 10_000;
    /// So many anchors may it have: those of an input of 7000 x 7000 pixels.
    pub const MAX_ANCHORS: usize = 1 << 20;

    /// How many classes and anchors an output of shape `[1, 4 + classes, anchors]` has.
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

    /// Numbers in the order of this shape, `[1, 4 + classes, anchors]`.
    ///
    /// # Errors
    /// If it is another shape, or not as many numbers.
    pub fn new(values: &'a [f32], shape: &[i64]) -> Result<Self, OutputError> {
        let (classes, anchors) = Self::classes_and_anchors(shape)?;
        if values.len() != (4 + classes) * anchors {
            return Err(OutputError::Count { shape: shape.to_vec(), given: values.len() });
        }
        Ok(Self { values, anchors })
    }

    /// What counts by the settings, in the order of anchors; and how many anchors were left out since what they say cannot
    /// be.
    ///
    /// # Errors
    /// If that are all of them.
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

    /// Of each anchor. Class by class, for so the numbers lie.
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

    /// Of the first anchor, all being refused.
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
        debug_assert!(wrong.is_some(), "it was refused");
        let (value, wanted) = wrong.unwrap_or((f32::NAN, A_PLACE));
        OutputError::NoAnchor { anchors: self.anchors, value, wanted }
    }
}
