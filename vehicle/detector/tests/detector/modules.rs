//! Invalid networks and images, in both formats: a clear error, and a detector that continues to work.

use dragnet_detector::network::Network;
use dragnet_detector::picture::{Picture, PixelFormat, Size};
use dragnet_detector::settings::{Classes, Resolution, Settings};

use super::{Written, load, says};

/// Endings of the two formats.
const BOTH: [&str; 2] = ["torchscript", "onnx"];
const INPUT: Size = Size { width_pixels: 96, height_pixels: 64 };

fn settings() -> Settings {
    Settings { resolution: Resolution::Full, ..Settings::default() }
}

/// 96 x 64 gray pixels, and 10 columns and 20 rows of red from column 30 and row 20 on.
fn with_red() -> Vec<u8> {
    let is_red = |column: u32, row: u32| (30..40).contains(&column) && (20..40).contains(&row);
    let places = (0..64).flat_map(|row| (0..96).map(move |column| (column, row)));
    places.flat_map(|(column, row)| if is_red(column, row) { [230, 10, 10] } else { [114; 3] }).collect()
}

fn gray() -> Vec<u8> {
    vec![114; 96 * 64 * 3]
}

fn picture(bytes: &[u8]) -> Picture<'_> {
    Picture::new(INPUT, PixelFormat::Rgb8, bytes).unwrap()
}

/// In one, since making the networks takes longer than all else.
#[test]
fn networks_detect_or_say_why_not() {
    let written = Written::by("modules.py");
    a_network_that_is_not_a_detector_is_rejected_when_it_is_loaded(&written);
    an_image_on_which_a_network_fails_is_lost_and_the_next_is_not(&written);
    for ending in BOTH {
        a_working_network_gives_boxes_and_classes(&written.network(&format!("red.{ending}")).unwrap());
    }
}

fn a_network_that_is_not_a_detector_is_rejected_when_it_is_loaded(written: &Written) {
    let refused = |file: &str, said: &[&str]| says(&written.network(file).unwrap_err(), said);
    for ending in BOTH {
        let refused = |name: &str, said: &[&str]| refused(&format!("{name}.{ending}"), said);
        refused("silent", &["does not say the size of its input"]);
        refused("segment", &["\"segment\"", "understood is \"detect\""]);
        refused("names", &["names 1 classes", "output has 2"]);
        refused("no_size", &["an input of 96 x 0 pixels", "allowed are 1 to 4096"]);
        refused("square", &["failed on an image of 96 x 64 pixels", "64", "96"]);
        refused("flat", &["shape [6, 40]", "understood is [1, 4 + classes, anchors]"]);

        // One without metadata works once its input size is given.
        let file = format!("silent.{ending}");
        let silent = load(&file, &written.bytes(&file), Some(INPUT)).unwrap();
        assert_eq!((silent.classes(), silent.name(0), silent.class_named("person")), (2, None, None));
        assert_eq!(silent.detect(&picture(&with_red()), &settings()).unwrap().detections.len(), 1);

        let file = format!("red.{ending}");
        let cut = written.bytes(&file);
        let kind = if ending == "onnx" { "not an ONNX network" } else { "not a TorchScript module" };
        for length in [0, 1, 100, cut.len() / 2, cut.len() - 1] {
            says(&load(&file, &cut[..length], None).unwrap_err(), &[kind]);
        }
    }
    refused("pair.torchscript", &["failed", "did not return a tensor"]);
    refused("pair.onnx", &["inputs and outputs: 1 and 2", "understood is one input", "and one output"]);
    refused("nothing.torchscript", &["failed", "did not return a tensor"]);
    refused("sparse.torchscript", &["failed"]);
    refused(
        "endless.torchscript",
        &["shape [1, 6, 1099511627776]", "up to 10000 classes and 1048576 anchors"],
    );

    // Each under the name of the other, and one whose input cannot be changed.
    let as_other = |of: &str, name: &str| load(name, &written.bytes(of), None).unwrap_err();
    says(&as_other("red.onnx", "red.pt"), &["not a TorchScript module"]);
    says(&as_other("red.torchscript", "red.onnx"), &["not an ONNX network"]);
    let wide = Size { width_pixels: 128, height_pixels: 64 };
    let fixed = load("red.onnx", &written.bytes("red.onnx"), Some(wide)).unwrap_err();
    says(&fixed, &["an input of 128 x 64 pixels", "fixed, 96 x 64"]);
}

fn an_image_on_which_a_network_fails_is_lost_and_the_next_is_not(written: &Written) {
    let check = |file: &str, said: &[&str]| {
        let network = written.network(file).unwrap();
        says(&network.detect(&picture(&with_red()), &settings()).unwrap_err(), said);
        assert_eq!(network.detect(&picture(&gray()), &settings()).unwrap().detections.len(), 1, "{file}");
    };
    check("raises.torchscript", &["failed on an image of 96 x 64 pixels", "this image is too much for me"]);
    for ending in BOTH {
        let check = |name: &str, said: &[&str]| check(&format!("{name}.{ending}"), said);
        check("lost", &["failed on an image of 96 x 64 pixels"]);
        check("not_a_number", &["none of 40 anchors", "the first has NaN"]);

        let always = |name: &str, said: &[&str]| {
            let network = written.network(&format!("{name}.{ending}")).unwrap();
            says(&network.detect(&picture(&gray()), &settings()).unwrap_err(), said);
        };
        always("many", &["more than 256 boxes in one image"]);
        always("end_to_end", &["none of 6 anchors", "250 where a probability"]);
        always("logits", &["none of 40 anchors", "-3 where"]);
    }
}

fn a_working_network_gives_boxes_and_classes(network: &Network) {
    assert_eq!((network.input(), network.classes()), (INPUT, 2));
    assert_eq!(
        (network.name(1), network.class_named("boat"), network.name(2)),
        (Some("boat"), Some(1), None)
    );
    let found = network.detect(&picture(&with_red()), &settings()).unwrap();
    let [detection] = found.detections[..] else { panic!("{found:?}") };
    let bounds = detection.bounds;
    assert_eq!((bounds.left, bounds.top, bounds.right, bounds.bottom), (30.0, 20.0, 40.0, 40.0));
    assert_eq!((detection.class, detection.confidence), (0, 0.9));

    let only = |classes: &[u32]| Settings {
        classes: Classes::Only(classes.iter().copied().collect()),
        ..settings()
    };
    let bytes = with_red();
    assert!(network.detect(&picture(&bytes), &only(&[1])).unwrap().detections.is_empty());
    says(&network.detect(&picture(&bytes), &only(&[1, 2])).unwrap_err(), &["class 2", "has 2, from 0 on"]);
    let confidence = Settings { confidence: f32::NAN, ..settings() };
    says(&network.detect(&picture(&bytes), &confidence).unwrap_err(), &["a confidence of NaN", "0 to 1"]);
    let half_of_one =
        Picture::new(Size { width_pixels: 1, height_pixels: 1 }, PixelFormat::Mono8, &[7]).unwrap();
    says(&network.detect(&half_of_one, &Settings::default()).unwrap_err(), &["an image of 0 x 0 pixels"]);
}
