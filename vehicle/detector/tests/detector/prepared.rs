//! Positions of an image's pixels, and the order of their colors, after preparation.

use dragnet_detector::letterbox::Letterbox;
use dragnet_detector::picture::{Picture, PixelFormat, Size};
use dragnet_detector::prepare::{Prepared, prepare};
use dragnet_detector::settings::Resolution;
use nalgebra::Vector2;
use proptest::prelude::*;

const fn size(width_pixels: u32, height_pixels: u32) -> Size {
    Size { width_pixels, height_pixels }
}

fn prepared(image: Size, format: PixelFormat, bytes: &[u8], resolution: Resolution, input: Size) -> Prepared {
    prepare(&Picture::new(image, format, bytes).unwrap(), resolution, input).unwrap()
}

#[test]
fn colors_of_any_order_are_converted_to_that_of_the_network() {
    // Two pixels, one above the other, in the middle of an input of 4 x 2.
    let bytes = [10, 20, 30, 40, 50, 60];
    let planes = |format, bytes: &[u8]| -> Vec<u32> {
        let values = prepared(size(1, 2), format, bytes, Resolution::Full, size(4, 2)).values;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
        values.iter().map(|value| (value * 255.0).round() as u32).collect()
    };
    let pad = 114;
    let plane = |upper, lower| [pad, upper, pad, pad, pad, lower, pad, pad];
    assert_eq!(planes(PixelFormat::Rgb8, &bytes), [plane(10, 40), plane(20, 50), plane(30, 60)].concat());
    assert_eq!(planes(PixelFormat::Bgr8, &bytes), [plane(30, 60), plane(20, 50), plane(10, 40)].concat());
    assert_eq!(planes(PixelFormat::Mono8, &[7, 9]), plane(7, 9).repeat(3));
}

#[test]
fn half_the_resolution_is_the_mean_of_two_by_two() {
    // The last column and the last row of an odd number are lost.
    #[rustfmt::skip]
    let bytes = [
        0, 100, 10, 30, 255,
        100, 200, 20, 40, 255,
        255, 255, 255, 255, 255,
    ];
    let values = prepared(size(5, 3), PixelFormat::Mono8, &bytes, Resolution::Half, size(2, 1)).values;
    assert_eq!(values, [100.0_f32 / 255.0, 25.0 / 255.0].repeat(3));
}

proptest! {
    /// A bright square in the dark is where the letterbox puts it.
    #[test]
    fn a_letterbox_gives_the_positions_of_pixels(
        width in 60_u32..400,
        height in 60_u32..400,
        part in (0.1_f64..0.9, 0.1_f64..0.9),
        resolution in prop_oneof![Just(Resolution::Full), Just(Resolution::Half)],
    ) {
        const HALF_SIDE: f64 = 10.0;
        let middle = Vector2::new((part.0 * f64::from(width)).round(), (part.1 * f64::from(height)).round());
        // Of the image that is left once an odd column and row are lost.
        let left = Letterbox::new(size(width, height), resolution, size(128, 96)).unwrap().reduced();
        let scale = if resolution == Resolution::Half { 2 } else { 1 };
        let sides = Vector2::new(left.width_pixels, left.height_pixels) * scale;
        let middle = middle.zip_map(&sides, |at, side| at.clamp(HALF_SIDE, f64::from(side) - HALF_SIDE));
        let bytes: Vec<u8> = (0..height)
            .flat_map(|row| (0..width).map(move |column| Vector2::new(f64::from(column) + 0.5, f64::from(row) + 0.5)))
            .map(|pixel| if (pixel - middle).amax() < HALF_SIDE { 255 } else { 0 })
            .collect();
        let input = size(128, 96);
        let Prepared { values, letterbox } =
            prepared(size(width, height), PixelFormat::Mono8, &bytes, resolution, input);
        let (left, top, inner) = (letterbox.left_pixels(), letterbox.top_pixels(), letterbox.scaled());
        let (mut weight, mut sum) = (0.0, Vector2::zeros());
        // The padding around them is gray.
        for row in top..top + inner.height_pixels {
            for column in left..left + inner.width_pixels {
                let value = f64::from(values[(row * 128 + column) as usize]);
                weight += value;
                sum += value * Vector2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
            }
        }
        prop_assert!(weight > 1.0);
        let off = letterbox.in_image(sum / weight) - middle;
        let side = letterbox.in_image(Vector2::new(1.0, 1.0)) - letterbox.in_image(Vector2::zeros());
        // Half a pixel of the input, if one is several of the image and is computed from the four in its center.
        prop_assert!(off.x.abs() < 0.5 * side.x.max(1.0) && off.y.abs() < 0.5 * side.y.max(1.0), "{off} {side}");
    }
}
