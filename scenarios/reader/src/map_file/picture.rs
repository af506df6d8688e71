//! Images as brightness values: PGM, PPM, PBM and PNG, with 8 or 16 bits.

use std::io::{Cursor, ErrorKind};
use std::path::Path;

use image::{DynamicImage, ImageBuffer, ImageDecoder, ImageError, ImageReader, Pixel, Primitive};

use super::{MapFileError, read_bytes};

/// The maximum number of pixels.
const MAX_PIXELS: u64 = 1 << 26;

/// A decoded image.
pub(super) struct Picture {
    pub(super) columns: u32,
    pub(super) rows: u32,
    /// Row by row from the southern edge, west to east: the last row of the file first.
    pub(super) shades: Vec<Shade>,
}

/// One pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shade {
    /// Luma of red, green and blue by ITU-R BT.709, 0 black to 1 white.
    pub(super) brightness: f32,
    /// 0 transparent to 1 opaque.
    pub(super) alpha: f32,
}

pub(super) fn load(file: &Path) -> Result<Picture, MapFileError> {
    decode(file, &read_bytes(file)?)
}

/// The columns and rows of an image, without its pixels.
pub(super) fn size(file: &Path) -> Result<(u32, u32), MapFileError> {
    let bytes = read_bytes(file)?;
    checked_size(file, &decoder(file, &bytes)?)
}

pub(super) fn decode(file: &Path, bytes: &[u8]) -> Result<Picture, MapFileError> {
    let decoder = decoder(file, bytes)?;
    let (columns, rows) = checked_size(file, &decoder)?;
    let image = DynamicImage::from_decoder(decoder).map_err(|error| no_image(file, &error))?;
    Ok(Picture { columns, rows, shades: shades_of(image) })
}

fn decoder<'a>(file: &Path, bytes: &'a [u8]) -> Result<impl ImageDecoder + use<'a>, MapFileError> {
    let reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| no_image(file, &error.into()))?;
    reader.into_decoder().map_err(|error| no_image(file, &error))
}

fn no_image(file: &Path, error: &ImageError) -> MapFileError {
    let reason = match error {
        ImageError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => {
            "no whole PGM or PNG image: it is cut off".to_owned()
        }
        error => format!("no PGM or PNG image: {error}"),
    };
    MapFileError::syntax(file, reason)
}

fn checked_size(file: &Path, decoder: &impl ImageDecoder) -> Result<(u32, u32), MapFileError> {
    let (columns, rows) = decoder.dimensions();
    let pixels = u64::from(columns) * u64::from(rows);
    if (1..=MAX_PIXELS).contains(&pixels) {
        return Ok((columns, rows));
    }
    let found = format!("{columns} x {rows} pixels");
    Err(MapFileError::value(file, "image size", found, format!("1 to {MAX_PIXELS} pixels")))
}

fn shades_of(image: DynamicImage) -> Vec<Shade> {
    match image {
        DynamicImage::ImageLuma8(pixels) => shades(&pixels),
        DynamicImage::ImageLumaA8(pixels) => shades(&pixels),
        DynamicImage::ImageRgb8(pixels) => shades(&pixels),
        DynamicImage::ImageRgba8(pixels) => shades(&pixels),
        DynamicImage::ImageLuma16(pixels) => shades(&pixels),
        DynamicImage::ImageLumaA16(pixels) => shades(&pixels),
        DynamicImage::ImageRgb16(pixels) => shades(&pixels),
        other => shades(&other.into_rgba16()),
    }
}

fn shades<P: Pixel>(image: &ImageBuffer<P, Vec<P::Subpixel>>) -> Vec<Shade>
where
    P::Subpixel: Into<f32>,
{
    let white: f32 = P::Subpixel::DEFAULT_MAX_VALUE.into();
    let shade = |pixel: &P| {
        let [red, green, blue, alpha] = pixel.to_rgba().0.map(Into::into);
        // For a gray pixel exactly that gray.
        let luma = green + 0.212_656 * (red - green) + 0.072_186 * (blue - green);
        Shade { brightness: luma / white, alpha: alpha / white }
    };
    image.rows().rev().flat_map(|row| row.map(shade)).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mentions::assert_mentions;

    fn decode(bytes: &[u8]) -> Result<Picture, String> {
        super::decode(Path::new("a.pgm"), bytes).map_err(|error| error.to_string())
    }

    #[test]
    fn the_last_row_of_the_file_is_the_southern_one() {
        let picture = decode(b"P2 2 2 4  0 1  2 4").unwrap();
        let brightness: Vec<f32> = picture.shades.iter().map(|shade| shade.brightness).collect();
        for (shade, expected) in brightness.iter().zip([0.5, 1.0, 0.0, 0.25]) {
            assert!((shade - expected).abs() < 0.003, "{brightness:?}");
        }
    }

    #[test]
    fn a_file_that_is_not_an_image_is_rejected() {
        let check = |bytes: &[u8], message: &str| {
            let error = decode(bytes).map(|_| ()).unwrap_err();
            assert_mentions(&error, message);
        };
        check(b"", "a.pgm .. PGM or PNG");
        check(b"P5 3 3 255 ab", "a.pgm .. PGM or PNG");
        check(b"P5 300000 300000 255 ab", "image size .. 300000 x 300000 .. 1 to");
        check(b"P5 0 3 255 ", "image size .. 0 x 3");
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_rejected(
            header in "P[1-7][ \n][0-9]{1,10}[ \n][0-9]{1,3}[ \n][0-9]{1,6}\n|\\x{89}PNG\r\n\x1a\n",
            rest in proptest::collection::vec(any::<u8>(), 0..80),
        ) {
            let _ = decode(&[header.as_bytes(), &rest].concat());
            let _ = decode(&rest);
        }
    }
}
