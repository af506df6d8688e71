//! Looks over small maps, as drawings.

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI};

use dragnet_search::sensor::Noise;
use nalgebra::Vector2;

use super::*;
use crate::camera::{Camera, CameraSettings, View};
use crate::plane::bearing_radians;
use crate::tracker::Tracker;
use crate::tracker::frame::Frame;
use crate::tracker::settings::Settings;

const SECOND: u64 = 1_000_000_000;
const OPEN: &str =
    ".........\n.........\n.........\n.........\n.........\n.........\n.........\n.........\n.........";

fn camera(degrees: f64, yaw: f64) -> Camera {
    Camera::new(CameraSettings {
        name: "front".to_owned(),
        width_pixels: 2660,
        height_pixels: 1516,
        field_of_view_radians: degrees.to_radians(),
        mounting: Pose::new(0.0, 0.0, yaw),
        nearest_meters: 2.0,
        farthest_meters: 60.0,
    })
    .unwrap()
}

/// Three wide cameras that together see all around.
fn all_around() -> Vec<Camera> {
    [0.0, 2.1, -2.1].map(|yaw| camera(125.0, yaw)).to_vec()
}

fn terrain(drawing: &str) -> Terrain {
    Terrain::from_ascii(drawing, 10.0).unwrap()
}

fn sensor() -> Sensor {
    Sensor::new(8, 0.005, Noise::Gaussian).unwrap()
}

/// The readings as a drawing: `0`, `1`, and `-` without one; its first line is the northern edge.
fn drawn(terrain: &Terrain, seen: &Seen) -> String {
    let grid = terrain.grid();
    let mark = |row, column| {
        let cell = grid.cell(Position { row, column }).unwrap();
        let reading = seen.readings.iter().find(|reading| reading.cell == cell);
        reading.map_or('-', |reading| if reading.value > 0.5 { '1' } else { '0' })
    };
    let line = |row| (0..grid.columns()).map(|column| mark(row, column)).collect::<String>();
    (0..grid.rows()).rev().map(line).collect::<Vec<_>>().join("\n")
}

/// Follows a thing from a camera that looks around itself and drives half a circle, for some frames.
fn tracks(thing: Vector2<f64>, frames: u64) -> Vec<Track> {
    let settings = Settings { velocity_deviation: 0.01, acceleration_density: 1e-8, ..Settings::default() };
    let mut tracker = Tracker::new(settings).unwrap();
    for number in 0..frames {
        let angle = number as f64 * 0.02;
        let vehicle = Pose::new(45.0 + 10.0 * angle.cos(), 45.0 + 10.0 * angle.sin(), 0.0);
        let frame = Frame {
            time_ns: number * SECOND / 5,
            camera: 0,
            view: View::new(vehicle, PI, 2.0, 60.0).unwrap(),
            bearings_radians: vec![bearing_radians(vehicle.position_meters(), thing)],
            bearing_deviation_radians: 0.005,
        };
        tracker.handle(&frame).unwrap();
    }
    tracker.tracks().to_vec()
}

const VEHICLE: Pose = Pose::new(45.0, 45.0, FRAC_PI_2);

/// What cameras show from where the vehicle stands.
fn coverage(terrain: &Terrain, cameras: &[Camera]) -> Coverage {
    let mut coverage = Coverage::default();
    for camera in cameras {
        coverage.add(terrain, &sensor(), &camera.view(&VEHICLE).unwrap());
    }
    coverage
}

fn look<'a>(coverage: &'a Coverage, tracks: &'a [Track]) -> Look<'a> {
    Look { vehicle: VEHICLE, coverage, fewest_sights: 1, tracks, since_ns: 0 }
}

#[test]
fn a_camera_reads_the_cells_before_it() {
    let terrain = terrain(OPEN);
    let seen = readings(&terrain, &sensor(), &look(&coverage(&terrain, &[camera(63.0, 0.0)]), &[])).unwrap();
    let expected = "\
        --00000--\n---000---\n---000---\n----0----\n---------\n---------\n---------\n---------\n---------";
    assert_eq!(drawn(&terrain, &seen), expected);
    for reading in &seen.readings {
        let distance = terrain.grid().manhattan(seen.from, reading.cell);
        assert_eq!(reading.variance.to_bits(), sensor().variance(distance).to_bits());
    }
}

#[test]
fn what_was_seen_on_the_way_counts_by_the_farther_distance() {
    let terrain = terrain(OPEN);
    let mut coverage = Coverage::default();
    let behind = camera(63.0, PI);
    // Three frames from the next cell to the north, and from there one of a camera that looks back.
    let north = Pose::new(45.0, 55.0, FRAC_PI_2);
    for _ in 0..3 {
        coverage.add(&terrain, &sensor(), &camera(63.0, 0.0).view(&north).unwrap());
    }
    coverage.add(&terrain, &sensor(), &behind.view(&north).unwrap());
    let seen = readings(&terrain, &sensor(), &Look { fewest_sights: 3, ..look(&coverage, &[]) }).unwrap();
    assert_eq!(drawn(&terrain, &seen).lines().skip(3).filter(|line| line.contains('0')).count(), 0);
    for reading in &seen.readings {
        let distance = terrain.grid().manhattan(seen.from, reading.cell);
        assert_eq!(reading.variance.to_bits(), sensor().variance(distance).to_bits());
    }
    let seen = readings(&terrain, &sensor(), &look(&coverage, &[])).unwrap();
    let own = seen.readings.iter().find(|reading| reading.cell == seen.from).unwrap();
    assert_eq!(own.variance.to_bits(), sensor().variance(1).to_bits(), "seen from the next cell");
}

#[test]
fn walls_hide_and_what_is_not_searched_is_not_read() {
    let terrain =
        terrain(&OPEN.replacen(".........\n.........\n.........", ".........\n.........\n....#..,.", 1));
    let seen = readings(&terrain, &sensor(), &look(&coverage(&terrain, &[camera(63.0, 0.0)]), &[])).unwrap();
    let expected = "\
        --00-00--\n---0-0---\n---0-0---\n----0----\n---------\n---------\n---------\n---------\n---------";
    assert_eq!(drawn(&terrain, &seen), expected);
}

#[test]
fn a_track_that_fits_into_a_cell_is_an_object_there() {
    let terrain = terrain(OPEN);
    let tracks = tracks(Vector2::new(65.0, 65.0), 150);
    let seen = readings(&terrain, &sensor(), &look(&coverage(&terrain, &all_around()), &tracks)).unwrap();
    let ones: Vec<_> = seen.readings.iter().filter(|reading| reading.value > 0.5).collect();
    assert_eq!(ones.len(), 1, "{}", drawn(&terrain, &seen));
    assert_eq!(terrain.center_meters(ones[0].cell), (65.0, 65.0));
    assert_eq!(
        seen.readings.len(),
        80,
        "all others are empty, but the vehicle's own\n{}",
        drawn(&terrain, &seen)
    );
}

/// Of one bearing a thing can be all along it; four, from places that are 0.6 m apart, show that it is not
/// near.
#[test]
fn a_track_of_few_bearings_withholds_readings_along_them() {
    let terrain = terrain(OPEN);
    for (frames, line) in [(1, "0000-----"), (4, "0000-00--")] {
        let tracks = tracks(Vector2::new(85.0, 45.0), frames);
        let seen = readings(&terrain, &sensor(), &look(&coverage(&terrain, &all_around()), &tracks)).unwrap();
        let mut expected = ["000000000"; 9];
        expected[4] = line;
        assert_eq!(drawn(&terrain, &seen), expected.join("\n"), "{frames} frames");
    }
}

#[test]
fn a_track_that_was_not_seen_in_this_look_is_neither_there_nor_not() {
    let terrain = terrain(OPEN);
    let tracks = tracks(Vector2::new(65.0, 65.0), 150);
    let coverage = coverage(&terrain, &all_around());
    let later = Look { since_ns: 30 * SECOND, ..look(&coverage, &tracks) };
    let seen = readings(&terrain, &sensor(), &later).unwrap();
    assert_eq!(seen.readings.len(), 79);
    assert!(seen.readings.iter().all(|reading| reading.value < 0.5));
}

/// What the team holds against each observation: a cell once, in the sensor's radius, not more precise than
/// the sensor, its value within 8 standard deviations of what can be.
#[test]
fn readings_are_what_the_team_believes() {
    let terrain = terrain(OPEN);
    let mut ones = 0;
    for number in 0..40_u8 {
        let thing = Vector2::new(5.0 + 2.0 * f64::from(number), 62.0 + f64::from(number) / 2.0);
        let tracks = tracks(thing, u64::from(number) * 5);
        let seen = readings(&terrain, &sensor(), &look(&coverage(&terrain, &all_around()), &tracks)).unwrap();
        let cells: BTreeSet<Cell> = seen.readings.iter().map(|reading| reading.cell).collect();
        assert_eq!(cells.len(), seen.readings.len());
        for reading in &seen.readings {
            let distance = terrain.grid().manhattan(seen.from, reading.cell);
            assert!(distance <= sensor().radius() && reading.is_valid());
            assert!(reading.variance >= sensor().variance(distance));
            assert!((0.0..=1.0).contains(&reading.value));
            ones += u32::from(reading.value > 0.5);
        }
    }
    assert!(ones > 5, "{ones}");
}

#[test]
fn a_vehicle_that_is_nowhere_sees_nothing_and_says_why() {
    let terrain = terrain(&format!("{OPEN}\n#........"));
    let coverage = coverage(&terrain, &all_around());
    let message = |east, north, heading| {
        let look = Look { vehicle: Pose::new(east, north, heading), ..look(&coverage, &[]) };
        readings(&terrain, &sensor(), &look).unwrap_err().to_string()
    };
    assert!(message(f64::NAN, 1.0, 0.0).contains("not a number"));
    assert!(message(1.0, 1.0, f64::INFINITY).contains("not a number"));
    assert!(message(-0.1, 1.0, 0.0).contains("-0.1 m east"));
    assert!(message(1.0, 100.0, 0.0).contains("100 m north of the map's corner: the map has 90 m, 100 m"));
    assert!(message(1e300, -1e300, 0.0).contains("of the map's corner"));
    assert_eq!(
        message(5.0, 5.0, 0.0),
        "the vehicle stands in row 0, column 0, where the map lets none stand"
    );
}
