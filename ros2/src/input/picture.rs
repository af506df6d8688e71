//! A camera's image, converted from any supported encoding to red, green and blue, one byte each.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use super::InputError;
use super::check::Check;
use crate::schema::RosMessage;
use crate::wire::robot;

/// The maximum number of pixels of an image: 16 million, those of the paper's cameras, so that a short message cannot
/// ask for more memory.
const MAX_PIXELS: u64 = 1 << 24;

/// Red, green and blue.
const COLORS: usize = 3;

/// An image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// When it was taken, Unix nanoseconds.
    pub stamp_unix_ns: i64,
    /// The frame of the camera.
    pub frame: String,
    /// Columns, at least 1.
    pub width_pixels: u32,
    /// Rows, at least 1; 2^24 pixels at most.
    pub height_pixels: u32,
    /// Red, green and blue of each pixel, row by row from the top, shape `[height, width, 3]`.
    pub rgb: Vec<u8>,
}

/// The offsets of a pixel's colors in its bytes.
struct Layout {
    bytes: usize,
    red: usize,
    green: usize,
    blue: usize,
}

impl Layout {
    /// By the names of `sensor_msgs/image_encodings.hpp`; one channel is gray, three without a name are those of
    /// `OpenCV`.
    fn of(encoding: &str) -> Option<Self> {
        let (bytes, [red, green, blue]) = match encoding {
            "rgb8" => (3, [0, 1, 2]),
            "bgr8" | "8UC3" => (3, [2, 1, 0]),
            "rgba8" => (4, [0, 1, 2]),
            "bgra8" | "8UC4" => (4, [2, 1, 0]),
            "mono8" | "8UC1" => (1, [0, 0, 0]),
            _ => return None,
        };
        Some(Self { bytes, red, green, blue })
    }
}

impl Image {
    pub(super) fn check(image: &robot::Image) -> Result<Self, InputError> {
        let check = Check { message: robot::Image::NAME };
        let (stamp_unix_ns, frame) = check.header(&image.header)?;
        check.text("encoding", &image.encoding)?;
        let Some(layout) = Layout::of(&image.encoding) else {
            let allowed = "rgb8, bgr8, rgba8, bgra8, mono8, 8UC1, 8UC3 or 8UC4";
            return check.refused("encoding", format!("{:?}", image.encoding), allowed);
        };
        check.pixels(image.width, image.height)?;
        let (step, row) = (image.step as usize, image.width as usize * layout.bytes);
        if step < row {
            return check.refused("step", step, format!("at least {row}, the bytes of a row"));
        }
        let expected = step as u64 * u64::from(image.height);
        if image.data.len() as u64 != expected {
            let found = format!("{} long", image.data.len());
            return check.refused("data", found, format!("{expected}, height x step"));
        }
        let mut rgb = vec![0; image.width as usize * image.height as usize * COLORS];
        let lines = image.data.chunks_exact(step).zip(rgb.chunks_exact_mut(image.width as usize * COLORS));
        for (line, colors) in lines {
            let pixels = line[..row].chunks_exact(layout.bytes);
            for (pixel, color) in pixels.zip(colors.as_chunks_mut::<COLORS>().0) {
                *color = [pixel[layout.red], pixel[layout.green], pixel[layout.blue]];
            }
        }
        Ok(Self { stamp_unix_ns, frame, width_pixels: image.width, height_pixels: image.height, rgb })
    }

    /// A JPEG or PNG file, recognized by its first bytes, since drivers write different texts into `format`.
    pub(super) fn decompress(image: &robot::CompressedImage) -> Result<Self, InputError> {
        let check = Check { message: robot::CompressedImage::NAME };
        let (stamp_unix_ns, frame) = check.header(&image.header)?;
        let Ok(format @ (ImageFormat::Jpeg | ImageFormat::Png)) = image::guess_format(&image.data) else {
            return check.refused("data", format!("{} bytes of neither", image.data.len()), "JPEG or PNG");
        };
        let broken = |error: image::ImageError| check.refused("data", error, "a whole JPEG or PNG file");
        let decoder = match ImageReader::with_format(Cursor::new(&image.data), format).into_decoder() {
            Ok(decoder) => decoder,
            Err(error) => return broken(error),
        };
        let (width_pixels, height_pixels) = decoder.dimensions();
        check.pixels(width_pixels, height_pixels)?;
        let rgb = match DynamicImage::from_decoder(decoder) {
            Ok(picture) => picture.into_rgb8().into_raw(),
            Err(error) => return broken(error),
        };
        Ok(Self { stamp_unix_ns, frame, width_pixels, height_pixels, rgb })
    }
}

impl Check {
    fn pixels(self, width: u32, height: u32) -> Result<(), InputError> {
        if (1..=MAX_PIXELS).contains(&(u64::from(width) * u64::from(height))) {
            Ok(())
        } else {
            self.refused("size", format!("{width} x {height}"), format!("1 to {MAX_PIXELS} pixels"))
        }
    }
}
