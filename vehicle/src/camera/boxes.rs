//! Conversion of a detector's boxes to bearings; invalid boxes are ignored and counted.

use std::collections::BTreeSet;

use super::Camera;

/// A box of a detector. Pixels count from the left and upper edge; edges lie within `0..=width` and `0..=height`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectionBox {
    /// Left edge, pixels.
    pub left: f64,
    /// Upper edge, pixels.
    pub top: f64,
    /// Right edge, pixels, beyond the left one.
    pub right: f64,
    /// Lower edge, pixels, below the upper one.
    pub bottom: f64,
}

/// Why a box does not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BoxRefusal {
    /// An edge is not a number.
    #[error("an edge is not a number")]
    NotANumber,
    /// It has no area.
    #[error("it has no area")]
    Empty,
    /// An edge lies outside the image. Detectors clip their boxes, so this one is of another image size.
    #[error("an edge lies outside of the image: boxes are in its pixels, and clipped to it")]
    OutsideImage,
    /// An earlier box has its center in exactly the same column: a repeated bearing adds nothing.
    #[error("an earlier box has its center in the same column")]
    SameColumn,
}

/// The bearings of the boxes of one image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Detections {
    /// Bearings of the boxes' centers: radians in the vehicle's frame, from the camera's position, in the boxes' order.
    pub bearings_radians: Vec<f64>,
    /// The index of each bearing's box in the image.
    pub boxes: Vec<usize>,
    /// Ignored boxes: their index in the image, and the reason.
    pub refused: Vec<(usize, BoxRefusal)>,
}

/// An image has too many boxes: the detector is faulty, and all boxes are ignored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0} boxes in one image: at most {max} can be objects", max = Camera::MAX_BOXES)]
pub struct TooManyBoxes(pub usize);

impl Camera {
    /// The maximum number of boxes in one image.
    pub const MAX_BOXES: usize = 256;

    /// The bearings of the centers of boxes.
    ///
    /// # Errors
    /// If there are more than [`Camera::MAX_BOXES`]. Single invalid boxes are ignored and counted.
    pub fn detections(&self, boxes: &[DetectionBox]) -> Result<Detections, TooManyBoxes> {
        if boxes.len() > Self::MAX_BOXES {
            return Err(TooManyBoxes(boxes.len()));
        }
        let mut detections = Detections::default();
        let mut columns = BTreeSet::new();
        for (number, detection_box) in boxes.iter().enumerate() {
            match self.column_of(detection_box) {
                Ok(column) if !columns.insert(column.to_bits()) => {
                    detections.refused.push((number, BoxRefusal::SameColumn));
                }
                Ok(column) => detections.add(number, self.bearing_radians(column)),
                Err(refusal) => detections.refused.push((number, refusal)),
            }
        }
        Ok(detections)
    }

    fn column_of(&self, detection_box: &DetectionBox) -> Result<f64, BoxRefusal> {
        let size = [self.settings.width_pixels, self.settings.height_pixels];
        detection_box.center(size).map(|[column, _]| column)
    }
}

impl Detections {
    /// Detections that have no boxes.
    pub(crate) fn of_bearings(bearings_radians: Vec<f64>) -> Self {
        Self { boxes: (0..bearings_radians.len()).collect(), bearings_radians, refused: Vec::new() }
    }

    pub(super) fn add(&mut self, detection_box: usize, bearing_radians: f64) {
        self.bearings_radians.push(bearing_radians);
        self.boxes.push(detection_box);
    }
}

impl DetectionBox {
    /// Column and row of its center, if it is a box of an image of this size, columns and rows.
    pub(super) fn center(&self, size: [u32; 2]) -> Result<[f64; 2], BoxRefusal> {
        let &Self { left, top, right, bottom } = self;
        if ![left, top, right, bottom].into_iter().all(f64::is_finite) {
            return Err(BoxRefusal::NotANumber);
        }
        if right <= left || bottom <= top {
            return Err(BoxRefusal::Empty);
        }
        let [width, height] = size.map(f64::from);
        if left < 0.0 || top < 0.0 || right > width || bottom > height {
            return Err(BoxRefusal::OutsideImage);
        }
        Ok([f64::midpoint(left, right), f64::midpoint(top, bottom)])
    }
}
