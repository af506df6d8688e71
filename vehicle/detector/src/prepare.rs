//! The pixels of a letterboxed image, as the input of a network.
//!
//! Both steps, halving and scaling to the input, are bilinear between the four nearest pixels, like OpenCV's
//! `INTER_LINEAR` and so ultralytics' training and prediction. Halving is the mean of two by two pixels.

use fast_image_resize::images::{Image, ImageRef};
use fast_image_resize::pixels::{U8, U8x3};
use fast_image_resize::{
    FilterType, IntoImageView, IntoImageViewMut, PixelTrait, PixelType, ResizeAlg, ResizeOptions, Resizer,
};

use crate::letterbox::Letterbox;
use crate::picture::{Picture, PictureError, PixelFormat, Size};
use crate::settings::Resolution;

/// The padding in YOLO's training.
const PADDING: f32 = 114.0 / 255.0;

/// The input of a network, and the position of the image in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// 0 to 1, shape `[3, rows, columns]` of the input: red, green, blue.
    pub values: Vec<f32>,
    /// The position of the image in them.
    pub letterbox: Letterbox,
}

/// Why an image cannot be prepared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PrepareError {
    /// An invalid size.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The message of the scaling library.
    #[error("an image cannot be scaled: {0}")]
    Scale(String),
}

/// Prepares an image for a network with this input size.
///
/// # Errors
/// If nothing is left of it at this resolution, or `input` is invalid.
pub fn prepare(picture: &Picture<'_>, resolution: Resolution, input: Size) -> Result<Prepared, PrepareError> {
    let letterbox = Letterbox::new(picture.size(), resolution, input)?;
    let mut resizer = Resizer::new();
    let scaled = match resolution {
        Resolution::Full => scale(&mut resizer, &whole(picture)?, picture.size(), letterbox.scaled())?,
        Resolution::Half => {
            // Of an odd number of columns the last is dropped, so that two always become one.
            let Size { width_pixels, height_pixels } = letterbox.reduced();
            let even = Size { width_pixels: 2 * width_pixels, height_pixels: 2 * height_pixels };
            let half = scale(&mut resizer, &whole(picture)?, even, letterbox.reduced())?;
            scale(&mut resizer, &half, letterbox.reduced(), letterbox.scaled())?
        }
    };
    let values = padded(scaled.buffer(), picture.format(), &letterbox);
    Ok(Prepared { values, letterbox })
}

fn whole<'a>(picture: &Picture<'a>) -> Result<ImageRef<'a>, PrepareError> {
    let Size { width_pixels, height_pixels } = picture.size();
    let kind = pixel_type(picture.format());
    ImageRef::new(width_pixels, height_pixels, picture.bytes(), kind).map_err(|error| scale_error(&error))
}

/// Scales the upper left part of an image, of size `part`, to size `to`.
fn scale(
    resizer: &mut Resizer,
    from: &impl IntoImageView,
    part: Size,
    to: Size,
) -> Result<Image<'static>, PrepareError> {
    let kind = from.pixel_type().ok_or_else(|| PrepareError::Scale("pixels of no format".to_owned()))?;
    let mut scaled = Image::new(to.width_pixels, to.height_pixels, kind);
    let options = ResizeOptions::new().resize_alg(ResizeAlg::Interpolation(FilterType::Bilinear)).crop(
        0.0,
        0.0,
        f64::from(part.width_pixels),
        f64::from(part.height_pixels),
    );
    match kind {
        PixelType::U8x3 => resize::<U8x3>(resizer, from, &mut scaled, &options)?,
        _ => resize::<U8>(resizer, from, &mut scaled, &options)?,
    }
    Ok(scaled)
}

/// For pixels of one type: the function for any would bring the code for all thirteen.
fn resize<P: PixelTrait>(
    resizer: &mut Resizer,
    from: &impl IntoImageView,
    to: &mut Image<'static>,
    options: &ResizeOptions,
) -> Result<(), PrepareError> {
    let (Some(from), Some(mut to)) = (from.image_view::<P>(), to.image_view_mut::<P>()) else {
        return Err(PrepareError::Scale("pixels of another format".to_owned()));
    };
    resizer.resize_typed(&from, &mut to, options).map_err(|error| scale_error(&error))
}

/// `scaled` in shape `[rows, columns, channels]`, 0 to 255, amid the padding, in shape `[3, rows, columns]`, 0 to 1.
fn padded(scaled: &[u8], format: PixelFormat, letterbox: &Letterbox) -> Vec<f32> {
    let (input, inner) = (letterbox.input(), letterbox.scaled());
    let (input_columns, inner_columns) = (input.width_pixels as usize, inner.width_pixels as usize);
    let (left, top) = (letterbox.left_pixels() as usize, letterbox.top_pixels() as usize);
    let channel_count = format.channel_count();
    let mut values = vec![PADDING; 3 * input.pixel_count()];
    for (plane, channel) in values.chunks_exact_mut(input.pixel_count()).zip(format.rgb_channels()) {
        let inner_rows = scaled.chunks_exact(inner_columns * channel_count);
        for (row, pixels) in plane.chunks_exact_mut(input_columns).skip(top).zip(inner_rows) {
            for (value, pixel) in row[left..].iter_mut().zip(pixels.chunks_exact(channel_count)) {
                *value = f32::from(pixel[channel]) / 255.0;
            }
        }
    }
    values
}

const fn pixel_type(format: PixelFormat) -> PixelType {
    match format {
        PixelFormat::Rgb8 | PixelFormat::Bgr8 => PixelType::U8x3,
        PixelFormat::Mono8 => PixelType::U8,
    }
}

fn scale_error(error: &impl ToString) -> PrepareError {
    PrepareError::Scale(error.to_string())
}
