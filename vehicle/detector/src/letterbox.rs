//! How an image lies in the one that a network takes: scaled alike in both directions, in the middle, the rest padded.
//!
//! Sizes and edges are those of ultralytics' `LetterBox`, for a network finds best what looks as in its training: halves
//! are rounded to even, and of an odd number of padded rows the lower side has one more.

use nalgebra::Vector2;

use crate::picture::{PictureError, Size};
use crate::settings::Resolution;
use dragnet_vehicle::camera::DetectionBox;

/// How an image lies in another. Points are `[column, row]` in pixels from the left and upper edge, so that whole numbers
/// are edges of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Letterbox {
    image: Size,
    resolution: Resolution,
    reduced: Size,
    scaled: Size,
    input: Size,
    left_pixels: u32,
    top_pixels: u32,
}

impl Letterbox {
    /// Of an image of this size in an input of that.
    ///
    /// # Errors
    /// If one of them is no size, or nothing is left of the image once it is taken down.
    pub fn new(image: Size, resolution: Resolution, input: Size) -> Result<Self, PictureError> {
        if let Some(size) = [image, input].into_iter().find(|size| !size.is_valid()) {
            return Err(PictureError::Size(size));
        }
        let reduced = Size {
            width_pixels: image.width_pixels / resolution.factor(),
            height_pixels: image.height_pixels / resolution.factor(),
        };
        if !reduced.is_valid() {
            return Err(PictureError::Size(reduced));
        }
        let scale = |side: fn(Size) -> u32| f64::from(side(input)) / f64::from(side(reduced));
        let scale = scale(|size| size.width_pixels).min(scale(|size| size.height_pixels));
        let scaled = Size {
            width_pixels: scaled_pixels(reduced.width_pixels, scale),
            height_pixels: scaled_pixels(reduced.height_pixels, scale),
        };
        Ok(Self {
            image,
            resolution,
            reduced,
            scaled,
            input,
            left_pixels: (input.width_pixels - scaled.width_pixels) / 2,
            top_pixels: (input.height_pixels - scaled.height_pixels) / 2,
        })
    }

    /// Of the camera's image.
    #[must_use]
    pub const fn image(&self) -> Size {
        self.image
    }

    /// How the image is taken down first.
    #[must_use]
    pub const fn resolution(&self) -> Resolution {
        self.resolution
    }

    /// Of the image once it is taken down. The last column of an odd number of them is lost to a half, and so is the
    /// last row.
    #[must_use]
    pub const fn reduced(&self) -> Size {
        self.reduced
    }

    /// Of the part of the input that is no padding.
    #[must_use]
    pub const fn scaled(&self) -> Size {
        self.scaled
    }

    /// Of what the network takes.
    #[must_use]
    pub const fn input(&self) -> Size {
        self.input
    }

    /// Padding to the left, columns.
    #[must_use]
    pub const fn left_pixels(&self) -> u32 {
        self.left_pixels
    }

    /// Padding above, rows.
    #[must_use]
    pub const fn top_pixels(&self) -> u32 {
        self.top_pixels
    }

    /// Where a point of the image lies in the input.
    #[must_use]
    pub fn in_input(&self, in_image: Vector2<f64>) -> Vector2<f64> {
        in_image.component_mul(&self.scale()) + self.corner()
    }

    /// Where a point of the input lies in the image; outside it, if it is one of the padding.
    #[must_use]
    pub fn in_image(&self, in_input: Vector2<f64>) -> Vector2<f64> {
        (in_input - self.corner()).component_div(&self.scale())
    }

    /// A box of the input as one of the image, cut at its edges; none if nothing of it lies in the image.
    #[must_use]
    pub fn bounds_in_image(&self, in_input: &DetectionBox) -> Option<DetectionBox> {
        let upper_left = self.in_image(Vector2::new(in_input.left, in_input.top));
        let lower_right = self.in_image(Vector2::new(in_input.right, in_input.bottom));
        let (width, height) = (f64::from(self.image.width_pixels), f64::from(self.image.height_pixels));
        let bounds = DetectionBox {
            left: upper_left.x.clamp(0.0, width),
            top: upper_left.y.clamp(0.0, height),
            right: lower_right.x.clamp(0.0, width),
            bottom: lower_right.y.clamp(0.0, height),
        };
        // NaN compares as false.
        (bounds.left < bounds.right && bounds.top < bounds.bottom).then_some(bounds)
    }

    /// Pixels of the input a pixel of the image. Sides are whole pixels, so that the two directions differ a little.
    fn scale(&self) -> Vector2<f64> {
        let factor = f64::from(self.resolution.factor());
        let scale = |scaled: u32, reduced: u32| f64::from(scaled) / f64::from(reduced) / factor;
        Vector2::new(
            scale(self.scaled.width_pixels, self.reduced.width_pixels),
            scale(self.scaled.height_pixels, self.reduced.height_pixels),
        )
    }

    fn corner(&self) -> Vector2<f64> {
        Vector2::new(f64::from(self.left_pixels), f64::from(self.top_pixels))
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most a side of the input")]
fn scaled_pixels(side_pixels: u32, scale: f64) -> u32 {
    (f64::from(side_pixels) * scale).round_ties_even().max(1.0) as u32
}
