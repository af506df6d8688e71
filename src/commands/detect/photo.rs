//! Images from files, upright.

use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageError, ImageReader, RgbImage};

use crate::commands::Failure;

/// Larger than any photograph's file.
const MOST_BYTES: u64 = 1 << 30;

/// An image as red, green and blue of 8 bits, rotated by the orientation in its file.
pub(super) fn read(path: &Path) -> Result<RgbImage, Failure> {
    decode(path)
        .map_err(|error| Failure::Input(format!("{}: no image that can be read: {error}", path.display())))
}

fn decode(path: &Path) -> Result<RgbImage, ImageError> {
    let mut decoder = ImageReader::new(Cursor::new(dragnet_files::read_at_most(path, MOST_BYTES)?))
        .with_guessed_format()?
        .into_decoder()?;
    let orientation = decoder.orientation()?;
    let mut image = DynamicImage::from_decoder(decoder)?;
    image.apply_orientation(orientation);
    Ok(image.into_rgb8())
}
