//! Boxes on an image.

use std::io::Cursor;

use dragnet_detector::{Detection, Found};
use image::{ImageError, ImageFormat, Rgb, RgbImage};

/// By class, repeating; the colors of Okabe and Ito that can be told apart with color blindness.
const COLORS: [[u8; 3]; 6] =
    [[230, 159, 0], [86, 180, 233], [240, 228, 66], [213, 94, 0], [204, 121, 167], [0, 158, 115]];

/// The image with a frame around each detection, the most confident on top.
pub(super) fn png(mut image: RgbImage, found: &Found) -> Result<Vec<u8>, ImageError> {
    for detection in found.detections.iter().rev() {
        frame(&mut image, detection);
    }
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

fn frame(image: &mut RgbImage, detection: &Detection) {
    let thickness = (image.width().max(image.height()) / 400).max(1);
    let color = Rgb(COLORS[detection.class as usize % COLORS.len()]);
    let bounds = &detection.bounds;
    let (left, right) = pixels(bounds.left, bounds.right, image.width());
    let (top, bottom) = pixels(bounds.top, bounds.bottom, image.height());
    for row in top..bottom {
        for column in left..right {
            let from_edge = (column - left).min(right - 1 - column).min((row - top).min(bottom - 1 - row));
            if from_edge < thickness {
                image.put_pixel(column, row, color);
            }
        }
    }
}

/// The first pixel that a box covers, and the one after its last.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "boxes lie within their image")]
fn pixels(low: f64, high: f64, side: u32) -> (u32, u32) {
    (low.floor() as u32, (high.ceil() as u32).min(side))
}
