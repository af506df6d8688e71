//! An image of a camera: bytes and their format.

use std::fmt;
use std::str::FromStr;

/// Columns and rows of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Columns.
    pub width_pixels: u32,
    /// Rows.
    pub height_pixels: u32,
}

/// The channels of a pixel, one byte each. Names are those of ROS's `sensor_msgs/Image`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelFormat {
    /// Red, green, blue.
    Rgb8,
    /// Blue, green, red.
    Bgr8,
    /// One shade of gray.
    Mono8,
}

/// A valid image.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    size: Size,
    format: PixelFormat,
    bytes: &'a [u8],
}

/// Why an image is invalid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PictureError {
    /// An unsupported format.
    #[error("pixels of format {0}: understood are rgb8, bgr8 and mono8")]
    Format(String),
    /// It is too small or too large.
    #[error("an image of {0} pixels: allowed are 1 to {max} columns and rows", max = Size::MAX_SIDE_PIXELS)]
    Size(Size),
    /// The number of bytes does not match the size.
    #[error("an image of {size} pixels of format {format} has {wanted} bytes, and this one {given}")]
    Bytes {
        /// Columns and rows.
        size: Size,
        /// The format of its pixels.
        format: PixelFormat,
        /// The right number of bytes.
        wanted: usize,
        /// The given number of bytes.
        given: usize,
    },
}

impl Size {
    /// The maximum number of columns or rows of an image.
    pub const MAX_SIDE_PIXELS: u32 = 1 << 15;

    /// Whether an image can have this size.
    #[must_use]
    pub fn is_valid(self) -> bool {
        [self.width_pixels, self.height_pixels].iter().all(|side| (1..=Self::MAX_SIDE_PIXELS).contains(side))
    }

    /// Columns times rows; each is at most [`Self::MAX_SIDE_PIXELS`].
    pub(super) const fn pixel_count(self) -> usize {
        self.width_pixels as usize * self.height_pixels as usize
    }
}

impl fmt::Display for Size {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} x {}", self.width_pixels, self.height_pixels)
    }
}

impl PixelFormat {
    /// Bytes per pixel.
    #[must_use]
    pub const fn channel_count(self) -> usize {
        match self {
            Self::Rgb8 | Self::Bgr8 => 3,
            Self::Mono8 => 1,
        }
    }

    /// The indices of red, green and blue among a pixel's bytes.
    pub(super) const fn rgb_channels(self) -> [usize; 3] {
        match self {
            Self::Rgb8 => [0, 1, 2],
            Self::Bgr8 => [2, 1, 0],
            Self::Mono8 => [0, 0, 0],
        }
    }
}

impl fmt::Display for PixelFormat {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Rgb8 => "rgb8",
            Self::Bgr8 => "bgr8",
            Self::Mono8 => "mono8",
        })
    }
}

impl FromStr for PixelFormat {
    type Err = PictureError;

    fn from_str(name: &str) -> Result<Self, PictureError> {
        match name {
            "rgb8" => Ok(Self::Rgb8),
            "bgr8" => Ok(Self::Bgr8),
            "mono8" => Ok(Self::Mono8),
            _ => Err(PictureError::Format(name.to_owned())),
        }
    }
}

impl<'a> Picture<'a> {
    /// An image of this size: `bytes` in shape `[rows, columns, channels]`, the upper row first, no padding between
    /// rows.
    ///
    /// # Errors
    /// If the size is invalid, or does not match the number of bytes.
    pub fn new(size: Size, format: PixelFormat, bytes: &'a [u8]) -> Result<Self, PictureError> {
        if !size.is_valid() {
            return Err(PictureError::Size(size));
        }
        let (wanted, given) = (size.pixel_count() * format.channel_count(), bytes.len());
        if wanted != given {
            return Err(PictureError::Bytes { size, format, wanted, given });
        }
        Ok(Self { size, format, bytes })
    }

    /// Columns and rows.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// The pixel format.
    #[must_use]
    pub const fn format(&self) -> PixelFormat {
        self.format
    }

    /// Shape `[rows, columns, channels]`.
    #[must_use]
    pub const fn bytes(&self) -> &'a [u8] {
        self.bytes
    }
}
