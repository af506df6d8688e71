//! The position of an image in a network's input: scaled by one factor, centered, and padded.
//!
//! Sizes and edges are those of ultralytics' `LetterBox`, since a network works best on images as in its training:
//! halves are rounded to even, and of an odd number of padded rows the lower side has one more.

use nalgebra::Vector2;

use crate::picture::{PictureError, Size};
use crate::settings::Resolution;
use dragnet_vehicle::camera::DetectionBox;

/// The position of an image in another. Points are `[column, row]` in pixels from the left and upper edge, so that
/// whole numbers are edges of pixels.
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
    /// The letterbox for an image and an input of these sizes.
    ///
    /// # Errors
    /// If a size is invalid, or nothing is left of the image after reduction.
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

    /// Size of the camera's image.
    #[must_use]
    pub const fn image(&self) -> Size {
        self.image
    }

    /// The reduction before scaling.
    #[must_use]
    pub const fn resolution(&self) -> Resolution {
        self.resolution
    }

    /// Size of the reduced image. With an odd number of columns or rows the last one is lost when halved.
    #[must_use]
    pub const fn reduced(&self) -> Size {
        self.reduced
    }

    /// Size of the part of the input without padding.
    #[must_use]
    pub const fn scaled(&self) -> Size {
        self.scaled
    }

    /// Size of the network's input.
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

    /// The point of the input for a point of the image.
    #[must_use]
    pub fn in_input(&self, in_image: Vector2<f64>) -> Vector2<f64> {
        in_image.component_mul(&self.scale()) + self.corner()
    }

    /// The point of the image for a point of the input; outside it, if it is in the padding.
    #[must_use]
    pub fn in_image(&self, in_input: Vector2<f64>) -> Vector2<f64> {
        (in_input - self.corner()).component_div(&self.scale())
    }

    /// A box of the input in the image, clipped to it; `None` if no part of it lies in the image.
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

    /// Pixels of the input per pixel of the image. Sides are whole pixels, so that the two directions differ slightly.
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
