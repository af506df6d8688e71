//! A pilot: one frame of its cameras, and one observation, with 20 objects around.
//!
//! `cargo bench -p dragnet-vehicle --bench pilot`
#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use dragnet_lattice::costmap::CostMap;
use dragnet_lattice::plane::{Pose, bearing_radians, wrapped_radians};
use dragnet_search::cell::{Grid, Position};
use dragnet_search::sensor::Sensor;
use dragnet_search::terrain::{Ground, Terrain};
use dragnet_vehicle::pilot::{Action, CameraDetections, CameraFrame, Event, Pilot, PoseEstimate};
use dragnet_vehicle::settings::{CameraTable, MotionTable, Settings};
use nalgebra::Vector2;

const THINGS: u32 = 20;
const STEP_NS: u64 = 200_000_000;
const CELL_METERS: f64 = 15.0;

struct Ride {
    pilot: Pilot,
    settings: Settings,
    objects: Vec<Vector2<f64>>,
    step: u64,
}

impl Ride {
    fn new() -> Self {
        let grid = Grid::new(30, 30).unwrap();
        let terrain = Terrain::new(grid, CELL_METERS, vec![Ground::OPEN; grid.cell_count()]).unwrap();
        let camera = |name: &str, yaw_degrees| CameraTable {
            name: name.to_owned(),
            field_of_view_degrees: Some(125.0),
            yaw_degrees: Some(yaw_degrees),
            ..CameraTable::wide()
        };
        let settings = Settings {
            cameras: vec![camera("front", 0.0), camera("left", 120.0), camera("right", -120.0)],
            motion: MotionTable::Goal {},
            ..Settings::default()
        };
        let map = CostMap::from_terrain(&terrain, 1).unwrap();
        let pilot = Pilot::new(settings.check(None).unwrap(), terrain, Sensor::default(), &map).unwrap();
        let object = |index: u32| {
            let angle = f64::from(index) / f64::from(THINGS) * TAU;
            let range = 20.0 + f64::from(index * 7 % 50);
            Vector2::new(225.0 + range * angle.cos(), 225.0 + range * angle.sin())
        };
        Self { pilot, settings, objects: (0..THINGS).map(object).collect(), step: 0 }
    }

    fn pose(&self) -> Pose {
        Pose::new(200.0 + 0.4 * self.step as f64, 225.0, 0.0)
    }

    fn now_ns(&self) -> u64 {
        self.step * STEP_NS
    }

    fn fix(&self) -> Event {
        Event::Pose(PoseEstimate {
            time_ns: self.now_ns(),
            pose: self.pose(),
            deviation_meters: 0.1,
            heading_deviation_radians: 0.005,
        })
    }

    fn frame(&self, camera: &CameraTable) -> Event {
        let pose = self.pose();
        let bearing = |object: &Vector2<f64>| {
            let bearing = wrapped_radians(bearing_radians(pose.position_meters(), *object));
            let beside = wrapped_radians(bearing - camera.yaw_degrees.unwrap_or(0.0).to_radians()).abs();
            (beside < camera.field_of_view_degrees.unwrap_or(0.0).to_radians() / 2.0).then_some(bearing)
        };
        Event::Frame(CameraFrame {
            time_ns: self.now_ns(),
            camera: camera.name.clone(),
            head_radians: 0.0,
            detections: CameraDetections::Bearings(self.objects.iter().filter_map(bearing).collect()),
        })
    }

    fn drive(&mut self, steps: u64) {
        for _ in 0..steps {
            self.step += 1;
            self.pilot.handle(self.now_ns(), self.fix());
            for camera in self.settings.cameras.clone() {
                self.pilot.handle(self.now_ns(), self.frame(&camera));
            }
        }
    }
}

fn pilot(criterion: &mut Criterion) {
    let mut ride = Ride::new();
    ride.drive(60);
    ride.step += 1;
    ride.pilot.handle(ride.now_ns(), ride.fix());
    let frame = ride.frame(&ride.settings.cameras[0].clone());
    let mut group = criterion.benchmark_group("pilot");
    group.bench_function("frame", |bencher| {
        let handle = |(mut pilot, frame): (Pilot, Event)| {
            let actions = pilot.handle(ride.now_ns(), black_box(frame));
            (pilot, actions)
        };
        bencher.iter_batched(|| (ride.pilot.clone(), frame.clone()), handle, BatchSize::SmallInput);
    });
    // The next cell of a route: the pose that enters it ends the observation.
    let next = Grid::new(30, 30).unwrap().cell(Position { row: 15, column: 15 }).unwrap();
    ride.pilot.handle(ride.now_ns(), Event::Route(vec![next]));
    ride.drive(1);
    ride.step += 1;
    group.bench_function("observation", |bencher| {
        let handle = |mut pilot: Pilot| {
            let actions = pilot.handle(ride.now_ns(), black_box(ride.fix()));
            assert!(actions.iter().any(|action| matches!(action, Action::Sensed { .. })), "{actions:?}");
            (pilot, actions)
        };
        bencher.iter_batched(|| ride.pilot.clone(), handle, BatchSize::SmallInput);
    });
    group.finish();
}

criterion_group!(benches, pilot);
criterion_main!(benches);
