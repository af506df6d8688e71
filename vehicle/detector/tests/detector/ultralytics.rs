//! Images are prepared, and outputs read, as by ultralytics.

use dragnet_detector::letterbox::Letterbox;
use dragnet_detector::output::Output;
use dragnet_detector::picture::{Picture, PixelFormat, Size};
use dragnet_detector::prepare::prepare;
use dragnet_detector::settings::{Classes, Resolution, Settings, Suppression};
use dragnet_detector::{Detection, Found, find};
use dragnet_vehicle::camera::DetectionBox;
use image::RgbImage;
use serde_json::Value;

use super::Written;

/// Rows and columns differ, so that swapping them is detected.
const RANDOM_INPUT: Size = Size { width_pixels: 320, height_pixels: 256 };

/// Shades of 256 by which a pixel may differ at most, and on average: here each of the two scalings is rounded after
/// each direction, there once.
const MOST_SHADES: [(Resolution, f32, f32); 2] =
    [(Resolution::Full, 1.0, 0.2), (Resolution::Half, 2.0, 0.45)];
/// Tolerance of a box's edge that both read from the same output.
const READ_PIXELS: f64 = 1e-3;
/// Tolerance of a box's edge in an image of 5320 x 3032 pixels, 33 of which are one of the input.
const FOUND_PIXELS: f64 = 2.0;
/// Tolerance of a box's edge, and of its confidence, from the same weights by two runtimes, in 32-bit floats.
const FORMAT_PIXELS: f64 = 0.2;
const FORMAT_CONFIDENCE: f32 = 2e-4;

fn picture(image: &RgbImage) -> Picture<'_> {
    let size = Size { width_pixels: image.width(), height_pixels: image.height() };
    Picture::new(size, PixelFormat::Rgb8, image).unwrap()
}

fn edges(bounds: &DetectionBox) -> [f64; 4] {
    [bounds.left, bounds.top, bounds.right, bounds.bottom]
}

/// The largest distance between the edges of two boxes.
fn apart(detection: &Detection, theirs: &Value) -> f64 {
    let apart =
        edges(&detection.bounds).into_iter().zip(0..).map(|(edge, part)| (edge - number(theirs, part)).abs());
    apart.fold(0.0, f64::max)
}

fn number(list: &Value, index: usize) -> f64 {
    list[index].as_f64().unwrap()
}

/// Shades of 256 by which the input differs: at most, and on average.
fn check_prepared(written: &Written, image: &RgbImage, resolution: Resolution, name: &str) {
    let ours = prepare(&picture(image), resolution, RANDOM_INPUT).unwrap();
    let theirs = written.bytes(&format!("{name}.pixels"));
    assert_eq!(theirs.len(), ours.values.len());
    let pixels = theirs.len() / 3;
    let (mut most, mut sum, mut differ) = (0.0_f32, 0.0, 0_usize);
    for (place, &theirs) in theirs.iter().enumerate() {
        let shades = (ours.values[place % 3 * pixels + place / 3] * 255.0 - f32::from(theirs)).abs();
        most = most.max(shades);
        sum += shades;
        differ += usize::from(shades > 0.5);
    }
    let mean = sum / theirs.len() as f32;
    println!(
        "{name}: at most {most:.3} shades apart, {mean:.3} in the mean, {differ} of {} at all",
        theirs.len()
    );
    let (_, may_most, may_mean) = MOST_SHADES.into_iter().find(|(of, ..)| *of == resolution).unwrap();
    assert!(most < may_most + 0.01 && mean < may_mean, "{name}: {most} {mean}");
}

fn has_area(bounds: &Value) -> bool {
    number(bounds, 0) < number(bounds, 2) && number(bounds, 1) < number(bounds, 3)
}

fn settings(case: &Value) -> Settings {
    let classes = case["classes"].as_array().map(|classes| classes.iter().map(class).collect());
    let suppression = if case["agnostic"] == true { Suppression::Agnostic } else { Suppression::ByClass };
    #[expect(clippy::cast_possible_truncation, reason = "thresholds of a few digits")]
    let part = |name: &str| case[name].as_f64().unwrap() as f32;
    Settings {
        confidence: part("conf_thres"),
        iou: part("iou_thres"),
        classes: classes.map_or(Classes::All, Classes::Only),
        suppression,
        ..Settings::default()
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a class, as Python has it")]
fn class(value: &Value) -> u32 {
    value.as_f64().unwrap() as u32
}

/// The same boxes in the same order, from the same numbers.
fn check_found(found: &Found, theirs: &[&Value], what: &str) {
    assert_eq!(found.detections.len(), theirs.len(), "{what}");
    assert_eq!(found.refused_anchors, 0);
    let mut most: f64 = 0.0;
    for (detection, theirs) in found.detections.iter().zip(theirs) {
        assert_eq!(detection.class, class(&theirs[5]), "{what}");
        assert!((f64::from(detection.confidence) - number(theirs, 4)).abs() < 1e-6, "{what}");
        most = most.max(apart(detection, theirs));
    }
    println!("{what}: {} boxes, at most {most:.1e} pixels apart", theirs.len());
    assert!(most < READ_PIXELS, "{what}: {most}");
}

fn check_read(written: &Written, image: &RgbImage, resolution: Resolution, name: &str, expected: &Value) {
    let bytes = written.bytes(&format!("{name}.output"));
    let values: Vec<f32> =
        bytes.as_chunks().0.iter().map(|&number: &[u8; 4]| f32::from_le_bytes(number)).collect();
    let shape: Vec<i64> =
        expected["shape"].as_array().unwrap().iter().map(|side| side.as_i64().unwrap()).collect();
    let output = Output::new(&values, &shape).unwrap();
    // ultralytics gets a reduced image, and its boxes are those of the reduced image.
    let factor = resolution.factor();
    let seen = Size { width_pixels: image.width() / factor, height_pixels: image.height() / factor };
    let letterbox = Letterbox::new(seen, Resolution::Full, RANDOM_INPUT).unwrap();
    let cases = expected["cases"].as_array().unwrap();
    let mut empty = 0;
    for (number, case) in cases.iter().enumerate() {
        let found = find(&output, &letterbox, &settings(case)).unwrap();
        // For a box in the padding alone ultralytics returns one without area.
        let (theirs, none): (Vec<&Value>, Vec<_>) =
            case["boxes"].as_array().unwrap().iter().partition(|bounds| has_area(bounds));
        empty += none.len();
        check_found(&found, &theirs, &format!("{name} {number}"));
    }
    // The hard cases: many boxes, some clipped at each edge of the image, some beyond it.
    assert!(empty > 0);
    let whole = find(&output, &letterbox, &settings(&cases[0])).unwrap().detections;
    let (width, height) = (f64::from(seen.width_pixels), f64::from(seen.height_pixels));
    assert!(whole.len() > 50);
    for (edge, at) in [0.0, 0.0, width, height].into_iter().enumerate() {
        assert!(
            whole.iter().any(|detection| (edges(&detection.bounds)[edge] - at).abs() < 1e-9),
            "{name}: edge {edge}"
        );
    }
}

#[test]
fn images_are_prepared_and_outputs_are_read_as_ultralytics_does() {
    let written = Written::by("yolo.py");
    let expected: Value = serde_json::from_slice(&written.bytes("expected.json")).unwrap();
    let image = image::open(written.path("random.png")).unwrap().to_rgb8();
    for (resolution, name) in [(Resolution::Full, "full"), (Resolution::Half, "half")] {
        check_prepared(&written, &image, resolution, name);
        check_read(&written, &image, resolution, name, &expected["random"][name]);
    }
    formats_agree(&written, &image);
    for file in ["figures.torchscript", "figures.onnx"] {
        painted_figures_are_found(&written, file, &expected["figures"]);
    }
}

/// The smallest network of version 11 itself: what libtorch and the runtime of ONNX files find with the same weights.
fn formats_agree(written: &Written, image: &RgbImage) {
    let settings = Settings { confidence: 0.7, ..Settings::default() };
    let found = ["random.torchscript", "random.onnx"].map(|file| {
        let network = written.network(file).unwrap();
        assert_eq!((network.input(), network.classes(), network.name(79)), (RANDOM_INPUT, 80, Some("79")));
        network.detect(&picture(image), &settings).unwrap().detections
    });
    let [torch, onnx] = &found;
    assert!(torch.len() > 50 && torch.len() == onnx.len(), "{} {}", torch.len(), onnx.len());
    let (mut most_pixels, mut most_confidence) = (0.0_f64, 0.0_f32);
    for detection in torch {
        let edges_apart = |other: &&Detection| {
            let pairs = edges(&detection.bounds).into_iter().zip(edges(&other.bounds));
            pairs.map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
        };
        let same = onnx.iter().filter(|other| other.class == detection.class);
        let same = same.min_by(|a, b| edges_apart(a).total_cmp(&edges_apart(b))).unwrap();
        most_pixels = most_pixels.max(edges_apart(&same));
        most_confidence = most_confidence.max((same.confidence - detection.confidence).abs());
    }
    println!(
        "{} boxes: at most {most_pixels:.1e} pixels and {most_confidence:.1e} of confidence apart",
        torch.len()
    );
    assert!(
        most_pixels < FORMAT_PIXELS && most_confidence < FORMAT_CONFIDENCE,
        "{most_pixels} {most_confidence}"
    );
}

/// From a camera's pixels to boxes, by a network that was trained on painted figures.
fn painted_figures_are_found(written: &Written, file: &str, expected: &Value) {
    let image = image::open(written.path("figures.ppm")).unwrap().to_rgb8();
    assert_eq!(image.dimensions(), (5320, 3032));
    let network = written.network(file).unwrap();
    assert_eq!((network.classes(), network.name(0), network.name(1)), (2, Some("person"), Some("barrel")));
    assert_eq!(network.input(), Size { width_pixels: 160, height_pixels: 128 });
    let found = network.detect(&picture(&image), &Settings::default()).unwrap();
    let theirs = expected["boxes"].as_array().unwrap();
    assert_eq!(found.detections.len(), theirs.len());
    for (detection, theirs) in found.detections.iter().zip(theirs) {
        let shares = (f64::from(detection.confidence) - number(theirs, 4)).abs();
        println!("{shares:.4} of confidence and {:.2} pixels apart", apart(detection, theirs));
        assert_eq!(detection.class, class(&theirs[5]));
        assert!(shares < 0.01 && apart(detection, theirs) < FOUND_PIXELS);
    }
    check_painted(&found, expected["painted"].as_array().unwrap());
    // The first time, the second and the third: no run-time optimization changes the result.
    for _ in 0..2 {
        assert_eq!(network.detect(&picture(&image), &Settings::default()).unwrap(), found);
    }
    let persons = Settings { classes: Classes::Only([0].into()), ..Settings::default() };
    let persons = network.detect(&picture(&image), &persons).unwrap();
    assert!(persons.detections.iter().all(|detection| detection.class == 0) && persons.detections.len() == 2);
}

/// Each painted figure has one box, whose edges are right to three pixels of the input.
fn check_painted(found: &Found, painted: &[Value]) {
    assert_eq!((found.detections.len(), painted.len()), (3, 3));
    for painted in painted {
        let is_it = |detection: &&Detection| {
            let edges = edges(&detection.bounds).into_iter().zip(1..);
            let apart = edges.map(|(edge, part)| (edge - number(painted, part)).abs()).fold(0.0, f64::max);
            detection.class == class(&painted[0]) && apart < 3.0 * 5320.0 / 160.0
        };
        assert_eq!(found.detections.iter().filter(is_it).count(), 1, "{painted} {found:?}");
    }
}
