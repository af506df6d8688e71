//! The example network, as it comes with the repository: it finds what is painted, as in training, and nothing else.

use std::path::Path;

use dragnet_detector::network::Network;
use dragnet_detector::picture::{Picture, PixelFormat, Size};
use dragnet_detector::settings::Settings;
use dragnet_detector::{Detection, Found};
use dragnet_search::seed::{Purpose, stream};
use image::{Rgb, RgbImage};
use rand::RngExt;
use serde_json::Value;

use super::{WORKSPACE, load};

/// Tolerances of edges and probabilities: another decoder reads the JPEG.
const PIXELS: f64 = 1.0;
const PROBABILITY: f64 = 0.02;
/// Tolerance of the edges of what is painted, pixels of an image twice as large as the network's input.
const PAINTED_PIXELS: f64 = 6.0;

fn network() -> Network {
    load("figures.onnx", include_bytes!("../../example/figures.onnx"), None).unwrap()
}

fn find(network: &Network, image: &RgbImage) -> Found {
    let size = Size { width_pixels: image.width(), height_pixels: image.height() };
    network.detect(&Picture::new(size, PixelFormat::Rgb8, image).unwrap(), &Settings::default()).unwrap()
}

/// The largest distance between the edges of a box and those of a row: a name, then left, top, right and bottom.
fn apart(detection: &Detection, row: &Value) -> f64 {
    let bounds = &detection.bounds;
    let edges = [bounds.left, bounds.top, bounds.right, bounds.bottom].into_iter().zip(1..);
    edges.map(|(edge, part)| (edge - row[part].as_f64().unwrap()).abs()).fold(0.0, f64::max)
}

#[test]
fn painted_figures_are_found_as_pytorch_finds_them() {
    let folder = Path::new(WORKSPACE).join("vehicle/detector/example");
    let image = image::open(folder.join("field.jpg")).unwrap().to_rgb8();
    let expected: Value = serde_json::from_slice(&std::fs::read(folder.join("field.json")).unwrap()).unwrap();
    let network = network();
    assert_eq!(
        ["person", "barrel", "post"].map(|name| network.class_named(name)),
        [Some(0), Some(1), Some(2)]
    );
    let found = find(&network, &image);
    let theirs = expected["found"].as_array().unwrap();
    assert_eq!((found.detections.len(), found.refused_anchors), (theirs.len(), 0), "{found:?}");
    for (detection, theirs) in found.detections.iter().zip(theirs) {
        let probability = (f64::from(detection.confidence) - theirs[5].as_f64().unwrap()).abs();
        println!("{:.2} pixels and {probability:.4} apart", apart(detection, theirs));
        assert_eq!(network.name(detection.class), theirs[0].as_str());
        assert!(apart(detection, theirs) < PIXELS && probability < PROBABILITY, "{detection:?} {theirs}");
    }
    let painted = expected["painted"].as_array().unwrap();
    assert_eq!((painted.len(), theirs.len()), (4, 4));
    for painted in painted {
        let is_it = |detection: &&Detection| {
            network.name(detection.class) == painted[0].as_str() && apart(detection, painted) < PAINTED_PIXELS
        };
        assert_eq!(found.detections.iter().filter(is_it).count(), 1, "{painted} {found:?}");
    }
    assert_eq!(find(&network, &image), found);
}

#[test]
fn nothing_is_found_in_empty_pictures() {
    let network = network();
    let mut random = stream(3, Purpose::Truth, 0);
    for number in 0..12_u8 {
        let color = [(); 3].map(|()| random.random_range(20..236_u8));
        let noise: u8 = random.random_range(0..20);
        // Plain, a slope, or two colors.
        let image = RgbImage::from_fn(320, 192, |column, row| {
            let shift = match number % 3 {
                0 => 0,
                1 => u8::try_from(row / 2).unwrap(),
                _ => 60 * u8::from(column > 160),
            };
            Rgb(color.map(|part| part.saturating_sub(shift).saturating_add(random.random_range(0..=noise))))
        });
        assert_eq!(find(&network, &image), Found::default(), "{number} {color:?}");
    }
}
