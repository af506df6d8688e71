//! One frame of a tracker: 50 tracks, and 50 bearings.
//!
//! `cargo bench -p dragnet-vehicle --bench tracker`
#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

use std::f64::consts::PI;
use std::hint::black_box;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use dragnet_lattice::costmap::{CostMap, LETHAL};
use dragnet_lattice::plane::{Pose, bearing_radians};
use dragnet_search::cell::Grid;
use dragnet_search::seed::{Purpose, stream};
use dragnet_vehicle::camera::View;
use dragnet_vehicle::evidence::vista::Vista;
use dragnet_vehicle::tracker::frame::Frame;
use dragnet_vehicle::tracker::pose_error::PoseError;
use dragnet_vehicle::tracker::settings::Settings;
use dragnet_vehicle::tracker::{Surroundings, Tracker};
use nalgebra::Vector2;
use rand::RngExt;

const THINGS: usize = 50;

fn frame(number: u64, objects: &[Vector2<f64>]) -> Frame {
    let seconds = number as f64 / 5.0;
    let camera = Pose::new(seconds, 5.0 * (seconds / 5.0).sin(), 0.0);
    Frame {
        time_ns: number * 200_000_000,
        camera: 0,
        view: View::new(camera, PI, 5.0, 200.0).unwrap(),
        bearings_radians: objects
            .iter()
            .map(|&object| bearing_radians(camera.position_meters(), object))
            .collect(),
        bearing_deviation_radians: 0.005,
        pose_error: PoseError::default(),
    }
}

/// 400 m x 400 m in squares of 0.25 m, nothing in between but a wall 10 m behind each object.
fn ground(objects: &[Vector2<f64>]) -> CostMap {
    const SIDE: u32 = 1600;
    let grid = Grid::new(SIDE, SIDE).unwrap();
    let mut map = CostMap::new(grid, 0.25, (-200.0, -200.0), vec![0; grid.cell_count()]).unwrap();
    for object in objects {
        let across = Vector2::new(-object.y, object.x).normalize();
        for step in -20..=20 {
            let place = object + object.normalize() * 10.0 + across * (f64::from(step) * 0.1);
            map.set(map.cell_at(place.x, place.y).unwrap(), LETHAL).unwrap();
        }
    }
    map
}

/// With all range hypotheses of new tracks, and later, when bearings have weighted those; and on a map with walls.
fn frames(criterion: &mut Criterion) {
    let mut random = stream(1, Purpose::Truth, 0);
    let mut place = |index: usize| {
        let (sin, cos) = (index as f64 / THINGS as f64 * 2.0 * PI - PI).sin_cos();
        Vector2::new(cos, sin) * random.random_range(20.0..150.0)
    };
    let objects: Vec<_> = (0..THINGS).map(&mut place).collect();
    let mut group = criterion.benchmark_group("frame");
    for (name, count) in [("second", 1), ("hundredth", 99)] {
        let mut tracker = Tracker::new(Settings::default()).unwrap();
        (0..count).for_each(|number| drop(tracker.handle(&frame(number, &objects)).unwrap()));
        let next = frame(count, &objects);
        group.bench_function(name, |bencher| {
            let handle = |mut tracker: Tracker| {
                let outcome = tracker.handle(black_box(&next)).unwrap();
                (tracker, outcome)
            };
            bencher.iter_batched(|| tracker.clone(), handle, BatchSize::SmallInput);
        });
    }
    let (map, next) = (ground(&objects), frame(1, &objects));
    let mut tracker = Tracker::new(Settings::default()).unwrap();
    let among = |tracker: &mut Tracker, frame: &Frame| {
        let vista = Vista::new(Some(&map), frame.view.camera().position_meters(), 400.0);
        let surroundings = Surroundings { unseen: &|_| 1.0, is_hidden: &|place| vista.hides(place) };
        tracker.handle_among(frame, &surroundings).unwrap()
    };
    drop(among(&mut tracker, &frame(0, &objects)));
    group.bench_function("second, on a map", |bencher| {
        let handle = |mut tracker: Tracker| {
            let outcome = among(&mut tracker, black_box(&next));
            (tracker, outcome)
        };
        bencher.iter_batched(|| tracker.clone(), handle, BatchSize::SmallInput);
    });
    group.finish();
}

criterion_group!(benches, frames);
criterion_main!(benches);
