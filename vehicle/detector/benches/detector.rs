//! A detector without its network: preparing an image of the paper's size, and boxes of its output. And networks, on one
//! thread: the files that the variable `NETWORKS` names, separated by colons.
//!
//! `NETWORKS=$PWD/yolo11n.torchscript:$PWD/yolo11n.onnx cargo bench -p dragnet-detector --features torch,onnx`
#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

use std::env;
use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use dragnet_detector::find;
use dragnet_detector::letterbox::Letterbox;
use dragnet_detector::network::{Format, Network};
use dragnet_detector::output::Output;
use dragnet_detector::picture::{Picture, PixelFormat, Size};
use dragnet_detector::prepare::prepare;
use dragnet_detector::settings::{Processor, Resolution, Settings};
use dragnet_search::seed::{Purpose, stream};
use rand::RngExt;

const IMAGE: Size = Size { width_pixels: 5320, height_pixels: 3032 };
const INPUT: Size = Size { width_pixels: 640, height_pixels: 640 };
const CLASSES: usize = 80;
const ANCHORS: usize = 8400;

fn pixels(criterion: &mut Criterion) {
    let mut random = stream(1, Purpose::Truth, 0);
    let bytes: Vec<u8> = (0..5320 * 3032 * 3).map(|_| random.random()).collect();
    let picture = Picture::new(IMAGE, PixelFormat::Rgb8, &bytes).unwrap();
    let mut group = criterion.benchmark_group("prepare");
    group.sample_size(20);
    for (name, resolution) in [("half", Resolution::Half), ("full", Resolution::Full)] {
        group.bench_function(name, |bencher| {
            bencher.iter(|| prepare(black_box(&picture), resolution, INPUT).unwrap());
        });
    }
    group.finish();
}

/// Anchors of strides 8, 16 and 32, each with its own box; some of them contain 20 objects, many none.
fn output(seeing: usize) -> Vec<f32> {
    let mut random = stream(2, Purpose::Truth, 0);
    let mut values = vec![0.0; (4 + CLASSES) * ANCHORS];
    let places: Vec<[f32; 4]> = (0..20)
        .map(|_| [random.random_range(50.0..590.0), random.random_range(150.0..490.0), 40.0, 80.0])
        .collect();
    for anchor in 0..ANCHORS {
        for (row, part) in places[anchor % places.len()].into_iter().enumerate() {
            values[row * ANCHORS + anchor] = part + random.random_range(-3.0..3.0);
        }
        for class in 0..CLASSES {
            values[(4 + class) * ANCHORS + anchor] = random.random_range(0.0..0.01);
        }
        if anchor % (ANCHORS / seeing) == 0 {
            values[(4 + anchor % places.len()) * ANCHORS + anchor] = random.random_range(0.3..0.9);
        }
    }
    values
}

fn boxes(criterion: &mut Criterion) {
    let letterbox = Letterbox::new(IMAGE, Resolution::Half, INPUT).unwrap();
    let settings = Settings::default();
    let mut group = criterion.benchmark_group("find");
    for seeing in [100, 2100] {
        let values = output(seeing);
        let output = Output::new(&values, &[1, 4 + 80, 8400]).unwrap();
        group.bench_function(format!("{seeing} of {ANCHORS} anchors see something"), |bencher| {
            bencher.iter(|| find(black_box(&output), &letterbox, &settings).unwrap());
        });
    }
    group.finish();
}

/// From an image that is twice as large as the input to boxes.
fn networks(criterion: &mut Criterion) {
    let Ok(files) = env::var("NETWORKS") else { return };
    let mut group = criterion.benchmark_group("network");
    group.sample_size(30);
    for file in files.split(':').map(Path::new) {
        let bytes = std::fs::read(file).unwrap();
        let network = Network::load(Format::of(file), &bytes, None, Processor::default()).unwrap();
        let Size { width_pixels, height_pixels } = network.input();
        let size = Size { width_pixels: 2 * width_pixels, height_pixels: 2 * height_pixels };
        let image = vec![114; 3 * (size.width_pixels * size.height_pixels) as usize];
        let picture = Picture::new(size, PixelFormat::Rgb8, &image).unwrap();
        group.bench_function(file.display().to_string(), |bencher| {
            bencher.iter(|| network.detect(black_box(&picture), &Settings::default()).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, pixels, boxes, networks);
criterion_main!(benches);
