//! Letterboxes, outputs and suppression, without a network.

use std::collections::BTreeSet;

use nalgebra::Vector2;
use proptest::prelude::*;

use super::output::{Candidate, Output, OutputError};
use super::picture::{Picture, PictureError, PixelFormat, Size};
use super::settings::{Classes, Resolution, Suppression};
use super::suppression::suppress;
use super::*;
use crate::mentions::assert_mentions;

const INPUT: Size = size(640, 640);

const fn size(width_pixels: u32, height_pixels: u32) -> Size {
    Size { width_pixels, height_pixels }
}

fn bounds(left: f64, top: f64, right: f64, bottom: f64) -> DetectionBox {
    DetectionBox { left, top, right, bottom }
}

fn letterbox(image: Size, resolution: Resolution) -> Letterbox {
    Letterbox::new(image, resolution, INPUT).unwrap()
}

#[test]
fn the_paper_s_image_lies_in_the_middle_of_the_input() {
    let letterbox = letterbox(size(5320, 3032), Resolution::Half);
    assert_eq!(letterbox.reduced(), size(2660, 1516));
    // 1516 * 640 / 2660 = 364.75
    assert_eq!(letterbox.scaled(), size(640, 365));
    assert_eq!((letterbox.left_pixels(), letterbox.top_pixels()), (0, 137));
    let corners =
        [((0.0, 0.0), (0.0, 137.0)), ((5320.0, 3032.0), (640.0, 502.0)), ((0.0, 1516.0), (0.0, 319.5))];
    for ((column, row), wanted) in corners {
        let in_input = letterbox.in_input(Vector2::new(column, row));
        assert!((in_input - Vector2::new(wanted.0, wanted.1)).norm() < 1e-9, "{in_input}");
    }
}

#[test]
fn a_box_is_cut_at_the_edges_of_the_image_and_none_of_the_padding_is_left() {
    // Twice as large, with 80 rows above.
    let letterbox = letterbox(size(320, 240), Resolution::Full);
    let in_image = |in_input: DetectionBox| letterbox.bounds_in_image(&in_input);
    assert_eq!(in_image(bounds(20.0, 100.0, 60.0, 180.0)), Some(bounds(10.0, 10.0, 30.0, 50.0)));
    assert_eq!(in_image(bounds(-20.0, 0.0, 60.0, 180.0)), Some(bounds(0.0, 0.0, 30.0, 50.0)));
    assert_eq!(in_image(bounds(600.0, 540.0, 660.0, 640.0)), Some(bounds(300.0, 230.0, 320.0, 240.0)));
    assert_eq!(in_image(bounds(20.0, 10.0, 60.0, 80.0)), None);
    assert_eq!(in_image(bounds(f64::NAN, 100.0, 60.0, 180.0)), None);
}

#[test]
fn invalid_images_are_rejected() {
    let bytes = [0; 12];
    let picture = |size, format| Picture::new(size, format, &bytes).map(|picture| picture.size());
    assert_eq!(picture(size(2, 2), PixelFormat::Rgb8), Ok(size(2, 2)));
    assert_eq!(picture(size(4, 3), PixelFormat::Mono8), Ok(size(4, 3)));
    let refused =
        |size, format, parts| assert_mentions(&picture(size, format).unwrap_err().to_string(), parts);
    refused(size(2, 3), PixelFormat::Bgr8, "2 x 3 .. bgr8 .. 18 bytes .. 12");
    let none = "0 x 2 .. 1 to 32768";
    refused(size(0, 2), PixelFormat::Rgb8, none);
    let endless = "4294967295 x 4294967295 .. 1 to 32768";
    refused(size(u32::MAX, u32::MAX), PixelFormat::Rgb8, endless);
    let format = "yuv422".parse::<PixelFormat>().unwrap_err();
    assert_mentions(&format.to_string(), "yuv422 .. rgb8, bgr8 and mono8");
    for format in [PixelFormat::Rgb8, PixelFormat::Bgr8, PixelFormat::Mono8] {
        assert_eq!(format.to_string().parse(), Ok(format));
    }
    let half_of_one = Letterbox::new(size(1, 9), Resolution::Half, INPUT);
    assert_eq!(half_of_one, Err(PictureError::Size(size(0, 4))));
}

fn sizes() -> impl Strategy<Value = Size> {
    (2_u32..6000, 2_u32..6000).prop_map(|(width, height)| size(width, height))
}

fn resolutions() -> impl Strategy<Value = Resolution> {
    prop_oneof![Just(Resolution::Full), Just(Resolution::Half)]
}

proptest! {
    /// Through whole pixels of the input, as a network with pixel resolution.
    #[test]
    fn a_point_comes_back_within_a_pixel(
        image in sizes(),
        resolution in resolutions(),
        input in (32_u32..1300, 32_u32..1300).prop_map(|(width, height)| size(width, height)),
        part in (0.0..=1.0, 0.0..=1.0),
    ) {
        let letterbox = Letterbox::new(image, resolution, input).unwrap();
        let (width, height) = (f64::from(image.width_pixels), f64::from(image.height_pixels));
        let point = Vector2::new(part.0 * width, part.1 * height);
        let in_input = letterbox.in_input(point);
        prop_assert!((letterbox.in_image(in_input) - point).norm() < 1e-6);
        let back = letterbox.in_image(in_input.map(f64::round)) - point;
        // The size of an input pixel in the image; half of it, with a tolerance for rounding.
        let side = letterbox.in_image(Vector2::new(1.0, 1.0)) - letterbox.in_image(Vector2::zeros());
        prop_assert!(back.x.abs() <= 0.501 * side.x && back.y.abs() <= 0.501 * side.y, "{back} {side}");
    }

    /// It fills the input in one direction, is centered in the other, and keeps its proportions up to rounding.
    #[test]
    fn an_image_lies_in_its_input(image in sizes(), resolution in resolutions()) {
        let letterbox = letterbox(image, resolution);
        let (scaled, reduced) = (letterbox.scaled(), letterbox.reduced());
        prop_assert!(scaled.width_pixels == 640 || scaled.height_pixels == 640);
        let right = 640 - scaled.width_pixels - letterbox.left_pixels();
        let below = 640 - scaled.height_pixels - letterbox.top_pixels();
        prop_assert!(right == letterbox.left_pixels() || right == letterbox.left_pixels() + 1);
        prop_assert!(below == letterbox.top_pixels() || below == letterbox.top_pixels() + 1);
        let across = f64::from(scaled.width_pixels) * f64::from(reduced.height_pixels);
        let down = f64::from(scaled.height_pixels) * f64::from(reduced.width_pixels);
        let rounding = 0.5 * f64::from(reduced.width_pixels.max(reduced.height_pixels));
        prop_assert!((across - down).abs() <= rounding || scaled.width_pixels == 1 || scaled.height_pixels == 1);
    }

    /// Any output is read or rejected.
    #[test]
    fn any_numbers_are_read_or_rejected(
        values in prop::collection::vec(prop_oneof![
            4 => -1.0_f32..2.0, 2 => 0.0_f32..700.0, 1 => any::<f32>(), 1 => Just(f32::NAN), 1 => Just(f32::INFINITY)
        ], 6 * 12),
        confidence in 0.0_f32..1.0,
    ) {
        let output = Output::new(&values, &[1, 6, 12]).unwrap();
        let settings = Settings { confidence, ..Settings::default() };
        if let Ok(found) = find(&output, &letterbox(size(1000, 700), Resolution::Half), &settings) {
            prop_assert!(found.detections.len() + found.refused_anchors <= 12);
            for Detection { bounds, class, confidence: probability } in found.detections {
                prop_assert!(probability > confidence && probability <= 1.0 && class < 2);
                prop_assert!(0.0 <= bounds.left && bounds.left < bounds.right && bounds.right <= 1000.0);
                prop_assert!(0.0 <= bounds.top && bounds.top < bounds.bottom && bounds.bottom <= 700.0);
            }
        }
    }
}

/// An output of three classes, from its anchors: center column, center row, width, height, three probabilities.
fn values(anchors: &[[f32; 7]]) -> (Vec<f32>, [i64; 3]) {
    let values = (0..7).flat_map(|row| anchors.iter().map(move |anchor| anchor[row])).collect();
    (values, [1, 7, i64::try_from(anchors.len()).unwrap()])
}

/// Class and left edge of the detections in an image of the input's size, and the number of invalid anchors.
fn check(anchors: &[[f32; 7]], settings: &Settings) -> Result<(Vec<(u32, f64)>, usize), FindError> {
    let (values, shape) = values(anchors);
    let output = Output::new(&values, &shape).unwrap();
    let found = find(&output, &letterbox(INPUT, Resolution::Full), settings)?;
    let reported =
        found.detections.iter().map(|detection| (detection.class, detection.bounds.left)).collect();
    Ok((reported, found.refused_anchors))
}

const NEAR: [[f32; 7]; 4] = [
    [100.0, 100.0, 40.0, 80.0, 0.1, 0.7, 0.2],
    // Overlaps the first by 0.9.
    [102.0, 100.0, 40.0, 80.0, 0.1, 0.9, 0.2],
    // And so does this one, of another class.
    [104.0, 100.0, 40.0, 80.0, 0.8, 0.0, 0.0],
    [300.0, 100.0, 40.0, 80.0, 0.0, 0.0, 0.25],
];

#[test]
fn of_boxes_that_overlap_the_most_confident_of_each_class_stays() {
    let settings = Settings::default();
    // The last one is not above 0.25.
    assert_eq!(check(&NEAR, &settings).unwrap(), (vec![(1, 82.0), (0, 84.0)], 0));
    let agnostic = Settings { suppression: Suppression::Agnostic, ..Settings::default() };
    assert_eq!(check(&NEAR, &agnostic).unwrap(), (vec![(1, 82.0)], 0));
    let apart = Settings { iou: 0.95, confidence: 0.24, ..Settings::default() };
    assert_eq!(check(&NEAR, &apart).unwrap(), (vec![(1, 82.0), (0, 84.0), (1, 80.0), (2, 280.0)], 0));
}

#[test]
fn only_classes_that_count_are_found_and_hide_nothing_else() {
    let only = |classes: &[u32]| Settings {
        classes: Classes::Only(classes.iter().copied().collect()),
        suppression: Suppression::Agnostic,
        ..Settings::default()
    };
    assert_eq!(check(&NEAR, &only(&[0])).unwrap(), (vec![(0, 84.0)], 0));
    assert_eq!(check(&NEAR, &only(&[2])).unwrap(), (vec![], 0));
    let none = check(&NEAR, &only(&[])).unwrap_err();
    assert_eq!(none.to_string(), "no class counts: needed is at least one, or all");
}

#[test]
fn of_equals_the_first_anchor_and_the_first_class_win() {
    let equal = [
        [100.0, 100.0, 40.0, 80.0, 0.5, 0.5, 0.5],
        [102.0, 100.0, 40.0, 80.0, 0.5, 0.5, 0.5],
        [98.0, 100.0, 40.0, 80.0, 0.5, 0.5, 0.5],
    ];
    assert_eq!(check(&equal, &Settings::default()).unwrap(), (vec![(0, 80.0)], 0));
}

#[test]
fn anchors_that_cannot_be_are_left_out_and_counted() {
    let good = [100.0, 100.0, 40.0, 80.0, 0.1, 0.7, 0.2];
    let spoiled = |part: usize, value: f32| {
        let mut anchor = good;
        anchor[part] = value;
        anchor
    };
    let wrong = [
        spoiled(0, f32::NAN),
        spoiled(1, f32::INFINITY),
        spoiled(2, 0.0),
        spoiled(3, -80.0),
        spoiled(4, f32::NAN),
        spoiled(5, 1.01),
        spoiled(6, -0.01),
    ];
    for anchor in wrong {
        assert_eq!(check(&[anchor, good], &Settings::default()).unwrap(), (vec![(1, 80.0)], 1), "{anchor:?}");
    }
    // They count also without detections.
    assert_eq!(check(&[wrong[0], spoiled(5, 0.2)], &Settings::default()).unwrap(), (vec![], 1));
    let all = |anchor| check(&[anchor], &Settings::default()).unwrap_err().to_string();
    assert_mentions(&all(wrong[0]), "none of 1 anchors .. NaN .. a number of pixels");
    assert_mentions(&all(wrong[3]), "none of 1 anchors .. -80 .. a positive number");
    assert_mentions(&all(wrong[5]), "none of 1 anchors .. 1.01 .. from 0 to 1");
}

#[test]
fn outputs_of_another_shape_are_rejected() {
    let shapes: [&[i64]; 7] =
        [&[], &[7, 4], &[2, 7, 4], &[1, 4, 10], &[1, 84, 0], &[1, 84, 1 << 40], &[1, -3, 5]];
    for shape in shapes {
        let error = Output::new(&[], shape).unwrap_err();
        assert_eq!(error, OutputError::Shape(shape.to_vec()));
        assert!(error.to_string().contains("understood is [1, 4 + classes, anchors]"), "{error}");
    }
    let error = Output::new(&[0.0; 13], &[1, 7, 2]).unwrap_err();
    assert_mentions(&error.to_string(), "[1, 7, 2] .. 13");
}

#[test]
fn more_boxes_than_there_can_be_objects_are_rejected() {
    let row = |count: u16| -> Vec<[f32; 7]> {
        (0..count).map(|number| [2.0 * f32::from(number), 100.0, 1.0, 80.0, 0.9, 0.0, 0.0]).collect()
    };
    assert_eq!(check(&row(256), &Settings::default()).unwrap().0.len(), 256);
    let error = check(&row(257), &Settings::default()).unwrap_err();
    assert_eq!(error, FindError::TooManyBoxes);
    assert_mentions(&error.to_string(), "256 boxes");
}

#[test]
fn settings_out_of_their_ranges_are_rejected() {
    let refused = |settings: &Settings| check(&NEAR, settings).unwrap_err().to_string();
    let usual = Settings::default;
    assert_mentions(&refused(&Settings { confidence: f32::NAN, ..usual() }), "confidence .. NaN .. 0 to 1");
    assert_mentions(&refused(&Settings { confidence: 1.5, ..usual() }), "confidence .. 1.5 .. 0 to 1");
    assert_mentions(&refused(&Settings { iou: -0.1, ..usual() }), "IoU .. -0.1 .. 0 to 1");
}

proptest! {
    /// The remaining boxes do not overlap, and each removed one overlaps a more confident remaining one. Pixels are
    /// counted.
    #[test]
    fn suppression_leaves_a_greedy_cover(
        boxes in prop::collection::vec((0..12, 0..12, 1..12, 1..12, 0.0_f32..1.0, 0_u32..2), 0..40),
    ) {
        let candidate = |&(left, top, width, height, confidence, class): &(i32, i32, i32, i32, f32, u32)| {
            let [left, top, right, bottom] = [left, top, left + width, top + height].map(f64::from);
            Candidate { bounds: bounds(left, top, right, bottom), class, confidence }
        };
        let candidates: Vec<Candidate> = boxes.iter().map(candidate).collect();
        let settings = Settings { iou: 0.4, ..Settings::default() };
        let kept = suppress(candidates.clone(), &settings, 256).unwrap();
        let same = |a: &Candidate, b: &Candidate| {
            let (a_pixels, b_pixels) = (pixels(&a.bounds), pixels(&b.bounds));
            let common = a_pixels.intersection(&b_pixels).count() as f64;
            a.class == b.class && common / a_pixels.union(&b_pixels).count() as f64 > f64::from(0.4_f32)
        };
        for (number, one) in kept.iter().enumerate() {
            let fits = |before: &Candidate| before.confidence >= one.confidence && !same(before, one);
            prop_assert!(kept[..number].iter().all(fits));
        }
        for one in candidates.iter().filter(|one| !kept.contains(one)) {
            prop_assert!(kept.iter().any(|stays| stays.confidence >= one.confidence && same(stays, one)));
        }
    }
}

/// Columns and rows that a box with whole edges covers.
fn pixels(bounds: &DetectionBox) -> BTreeSet<(u32, u32)> {
    let within =
        |low: f64, high: f64| (0..24).filter(move |&at| low <= f64::from(at) && f64::from(at) < high);
    let rows = |column| within(bounds.top, bounds.bottom).map(move |row| (column, row));
    within(bounds.left, bounds.right).flat_map(rows).collect()
}
