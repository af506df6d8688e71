//! Observations on small maps, as drawings.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{FRAC_PI_2, PI};

use dragnet_search::sensor::Noise;
use nalgebra::Vector2;

use super::finds::Vantage;
use super::*;
use crate::camera::{Camera, CameraSettings, View};
use crate::mentions::assert_mentions;
use crate::tracker::Tracker;
use crate::tracker::frame::Frame;
use crate::tracker::pose_error::PoseError;
use crate::tracker::settings::Settings;
use crate::tracker::track::Track;
use dragnet_lattice::costmap::{CostMap, LETHAL};
use dragnet_lattice::plane::bearing_radians;
use dragnet_search::cell::Grid;

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
        z_meters: 0.0,
        pitch_radians: 0.0,
        min_range_meters: 2.0,
        max_range_meters: 60.0,
    })
    .unwrap()
}

/// Three wide cameras that together see in all directions.
fn all_around() -> Vec<Camera> {
    [0.0, 2.1, -2.1].map(|yaw| camera(125.0, yaw)).to_vec()
}

fn terrain(drawing: &str) -> Terrain {
    Terrain::from_ascii(drawing, 10.0).unwrap()
}

fn sensor() -> Sensor {
    Sensor::new(8, 0.005, Noise::Gaussian).unwrap()
}

/// The readings as a drawing: `0`, `1`, `?` if undecided, and `-` without one; its first line is the northern edge.
fn drawn(terrain: &Terrain, seen: &Seen) -> String {
    let grid = terrain.grid();
    let mark = |row, column| {
        let cell = grid.cell(Position { row, column }).unwrap();
        let reading = seen.readings.iter().find(|reading| reading.cell == cell);
        reading.map_or('-', |reading| match reading.value {
            _ if reading.is_undecided() => '?',
            value if value > 0.5 => '1',
            _ => '0',
        })
    };
    let line = |row| (0..grid.columns()).map(|column| mark(row, column)).collect::<String>();
    (0..grid.rows()).rev().map(line).collect::<Vec<_>>().join("\n")
}

/// Tracks an object for some frames, from a camera that sees in all directions and drives half a circle.
fn tracks(object: Vector2<f64>, frames: u64) -> Vec<Track> {
    tracks_of(&[object], frames)
}

fn tracks_of(things: &[Vector2<f64>], frames: u64) -> Vec<Track> {
    let settings = Settings { velocity_std: 0.01, acceleration_density: 1e-8, ..Settings::default() };
    let mut tracker = Tracker::new(settings).unwrap();
    for number in 0..frames {
        let angle = number as f64 * 0.02;
        let vehicle = Pose::new(45.0 + 10.0 * angle.cos(), 45.0 + 10.0 * angle.sin(), 0.0);
        let frame = Frame {
            time_ns: number * SECOND / 5,
            camera: 0,
            view: View::new(vehicle, PI, 2.0, 60.0).unwrap(),
            bearings_radians: things
                .iter()
                .map(|&it| bearing_radians(vehicle.position_meters(), it))
                .collect(),
            bearing_deviation_radians: 0.005,
            pose_error: PoseError::default(),
        };
        tracker.handle(&frame).unwrap();
    }
    tracker.tracks().to_vec()
}

const VEHICLE: Pose = Pose::new(45.0, 45.0, FRAC_PI_2);
/// From here it reads nothing of the northeast.
const FAR: Pose = Pose::new(5.0, 5.0, FRAC_PI_2);

/// The cameras' frames from a position.
fn seen_from(terrain: &Terrain, cameras: &[Camera], vehicle: &Pose, frames: u32) -> Accounts {
    let mut accounts = Accounts::default();
    for camera in cameras {
        for _ in 0..frames {
            accounts.add(terrain, None, &sensor(), &camera.view(vehicle).unwrap(), 0.2);
        }
    }
    accounts
}

fn finds(terrain: &Terrain, tracks: &[Track]) -> Finds {
    let mut finds = Finds::default();
    update(&mut finds, tracks, terrain, &VEHICLE);
    finds
}

/// From a vehicle, at the time of the last detection.
fn update(finds: &mut Finds, tracks: &[Track], terrain: &Terrain, vehicle: &Pose) {
    let now_ns = tracks.iter().map(Track::seen_ns).max().unwrap_or(0);
    let from = standing_cell(terrain, vehicle).unwrap();
    finds.update(tracks, &Vantage { now_ns, terrain, sensor: &sensor(), from });
}

/// An observation without earlier ones.
fn observation(terrain: &Terrain, accounts: &mut Accounts, tracks: &[Track]) -> Seen {
    readings(terrain, &sensor(), &VEHICLE, &mut finds(terrain, tracks), accounts).unwrap()
}

fn nats(reading: &Reading) -> f64 {
    reading.evidence().log_likelihood_ratio_nats()
}

#[test]
fn a_camera_reads_the_cells_before_it_as_far_as_it_saw_them() {
    let terrain = terrain(OPEN);
    let camera = camera(63.0, 0.0);
    let mut accounts = seen_from(&terrain, std::slice::from_ref(&camera), &VEHICLE, 40);
    let seen = observation(&terrain, &mut accounts, &[]);
    let expected = "\
        -0000000-\n--00000--\n---000---\n---000---\n----0----\n---------\n---------\n---------\n---------";
    assert_eq!(drawn(&terrain, &seen), expected);
    for reading in &seen.readings {
        let distance = terrain.grid().manhattan(seen.from, reading.cell);
        assert!(reading.variance >= sensor().variance(distance));
        assert!(-nats(reading) <= 1000.0_f64.ln() + 1e-3, "{reading:?}");
    }
    let of = |row: u32, column: u32| {
        let cell = terrain.grid().cell(Position { row, column }).unwrap();
        -nats(seen.readings.iter().find(|reading| reading.cell == cell).unwrap())
    };
    assert!(of(6, 4) > 5.0 && of(6, 3) < 2.0, "of the one beside only a part: {} {}", of(6, 4), of(6, 3));
    assert!(of(4, 4) < 1.0, "the vehicle's own is mostly behind it: {}", of(4, 4));
}

#[test]
fn published_evidence_is_not_published_again() {
    let terrain = terrain(OPEN);
    let mut accounts = seen_from(&terrain, &all_around(), &VEHICLE, 2);
    let first = observation(&terrain, &mut accounts, &[]);
    assert!(first.readings.len() > 60, "{}", drawn(&terrain, &first));
    assert_eq!(observation(&terrain, &mut accounts, &[]).readings, [], "nothing was seen meanwhile");
}

/// An object in the part of a cell that was never in view is not ruled out by any number of observations.
#[test]
fn parts_out_of_view_stay_possible_however_often_the_rest_was_in_view() {
    let terrain = terrain(OPEN);
    let near = Camera::new(CameraSettings { z_meters: 2.0, ..camera(63.0, 0.0).settings().clone() }).unwrap();
    let mut reported = BTreeMap::new();
    let mut accounts = Accounts::default();
    for _ in 0..200 {
        for _ in 0..10 {
            accounts.add(&terrain, None, &sensor(), &near.view(&VEHICLE).unwrap(), 0.2);
        }
        for reading in observation(&terrain, &mut accounts, &[]).readings {
            *reported.entry(reading.cell).or_insert(0.0) -= nats(&reading);
        }
    }
    let own = terrain.grid().cell(Position { row: 4, column: 4 }).unwrap();
    let ahead = terrain.grid().cell(Position { row: 7, column: 4 }).unwrap();
    assert!(reported.get(&own).is_none_or(|&nats| nats < 1.0), "{reported:?}");
    assert!(reported[&ahead] > 10.0, "seen whole: {}", reported[&ahead]);
}

/// A wall of half a meter across the middle of the cell ahead, as the vehicle's own map has it: what is before it is seen, and
/// what is behind it is not.
#[test]
fn a_wall_thinner_than_a_cell_hides_what_is_behind_it() {
    let terrain = terrain(OPEN);
    let cameras = [camera(63.0, 0.0)];
    let seen = |walls: Option<&CostMap>| {
        let mut accounts = Accounts::default();
        for _ in 0..40 {
            accounts.add(&terrain, walls, &sensor(), &cameras[0].view(&VEHICLE).unwrap(), 0.2);
        }
        let seen = observation(&terrain, &mut accounts, &[]);
        let evidence =
            seen.readings.iter().map(|reading| (terrain.grid().position(reading.cell), -nats(reading)));
        evidence.collect::<BTreeMap<Position, f64>>()
    };
    let (grid, half) = (Grid::new(180, 180).unwrap(), 0.5);
    let row_of_wall = |number: usize| number / 180 == 131;
    let costs = (0..180 * 180).map(|number| if row_of_wall(number) { LETHAL } else { 0 }).collect();
    let walls = CostMap::new(grid, half, (0.0, 0.0), costs).unwrap();
    let (open, walled) = (seen(None), seen(Some(&walls)));
    let at = |row| Position { row, column: 4 };
    assert!(open[&at(6)] > 3.0 && open[&at(7)] > 3.0, "{open:?}");
    // The wall stands at 65.5 m: half of row 6 is before it.
    let half_seen = walled[&at(6)];
    assert!((half_seen - 2.0_f64.ln()).abs() < 0.01, "{half_seen}");
    assert!(!walled.contains_key(&at(7)) && !walled.contains_key(&at(8)), "{walled:?}");
    assert_eq!(walled.get(&at(5)), open.get(&at(5)));
}

#[test]
fn a_cell_with_a_wall_in_it_is_looked_at_from_both_sides_and_again_once_it_may_hold_an_object() {
    let terrain = terrain(OPEN);
    // Squares of 2.5 m: the wall fills the third quarter of column 6.
    let grid = Grid::new(36, 36).unwrap();
    let cost = |square| if grid.position(square).column == 26 { LETHAL } else { 0 };
    let walls = CostMap::new(grid, 2.5, (0.0, 0.0), grid.cells().map(cost).collect()).unwrap();
    let mut sight = sight::Sight::new(&terrain, 8);
    sight.set_walls(&terrain, walls);
    let [west, split, east] =
        [4, 6, 8].map(|column| terrain.grid().cell(Position { row: 4, column }).unwrap());
    let hidden = |sight: &sight::Sight| {
        let is_hidden = |from| sight.line_of_sight().hides(from, terrain.grid().offset(from, split));
        [west, east].map(is_hidden)
    };
    assert_eq!(hidden(&sight), [false; 2]);
    let mut accounts = Accounts::default();
    let cameras = all_around();
    for _ in 0..10 {
        for camera in &cameras {
            for _ in 0..10 {
                let view = camera.view(&VEHICLE).unwrap();
                accounts.add(&terrain, sight.walls(), &sensor(), &view, 0.2);
            }
        }
        observation(&terrain, &mut accounts, &[]);
        sight.note(terrain.grid(), &accounts);
    }
    assert_eq!(hidden(&sight), [true, false], "the western half was observed");
    observation(&terrain, &mut accounts, &tracks(Vector2::new(62.0, 45.0), 60));
    sight.note(terrain.grid(), &accounts);
    assert_eq!(hidden(&sight), [false; 2]);
}

#[test]
fn walls_hide_and_unsearched_cells_are_not_read() {
    let terrain =
        terrain(&OPEN.replacen(".........\n.........\n.........", ".........\n.........\n....#..,.", 1));
    let mut accounts = seen_from(&terrain, &[camera(63.0, 0.0)], &VEHICLE, 40);
    let drawing = drawn(&terrain, &observation(&terrain, &mut accounts, &[]));
    let columns: Vec<char> = drawing.lines().map(|line| line.chars().nth(4).unwrap()).collect();
    assert_eq!(columns, ['-', '-', '-', '0', '0', '-', '-', '-', '-'], "{drawing}");
}

#[test]
fn a_track_that_fits_into_a_cell_is_an_object_there_and_is_reported_once() {
    let terrain = terrain(OPEN);
    let tracks = tracks(Vector2::new(65.0, 65.0), 150);
    let mut finds = finds(&terrain, &tracks);
    let mut accounts = seen_from(&terrain, &all_around(), &VEHICLE, 5);
    let (mut object_nats, mut observations) = (0.0, 0);
    for _ in 0..20 {
        let seen = readings(&terrain, &sensor(), &VEHICLE, &mut finds, &mut accounts).unwrap();
        for reading in seen.readings.iter().filter(|reading| reading.value > 0.5) {
            assert_eq!(terrain.center_meters(reading.cell), (65.0, 65.0));
            object_nats += nats(reading);
            observations += 1;
        }
    }
    assert!(
        (object_nats - OBJECT_NATS).abs() < 0.1 && observations > 1,
        "{object_nats} nats in {observations} looks"
    );
    let find = finds.iter().next().unwrap();
    assert!((find.position_meters - Vector2::new(65.0, 65.0)).norm() < 1.0);
    assert!(find.position_covariance.cholesky().is_some());
}

/// After one bearing an object can be anywhere along it: those cells have no readings, and once it is confirmed they
/// are undecided.
#[test]
fn where_a_track_may_be_nothing_is_empty() {
    let terrain = terrain(OPEN);
    for (frames, expected) in [(1, '-'), (4, '?')] {
        let tracks = tracks(Vector2::new(85.0, 45.0), frames);
        let mut accounts = seen_from(&terrain, &all_around(), &VEHICLE, 5);
        let drawing = drawn(&terrain, &observation(&terrain, &mut accounts, &tracks));
        let row = drawing.lines().nth(4).unwrap();
        assert!(row.starts_with("000") && row.chars().nth(8) == Some(expected), "{frames} frames\n{drawing}");
        assert!(!row[6..].contains('0'), "{frames} frames\n{drawing}");
        assert_eq!(drawing.matches('1').count(), 0);
    }
}

/// Evidence of a cell's being empty is withdrawn when an object may be there after all, while that is undecided no frame
/// counts, and if nothing is there the evidence is published again.
#[test]
fn emptiness_is_taken_back_when_something_may_be_there() {
    let terrain = terrain(OPEN);
    let mut accounts = seen_from(&terrain, &all_around(), &VEHICLE, 5);
    let mut reported: BTreeMap<Cell, f64> = BTreeMap::new();
    let mut add = |seen: &Seen| {
        seen.readings.iter().for_each(|reading| *reported.entry(reading.cell).or_default() += nats(reading));
        reported.clone()
    };
    let first = add(&observation(&terrain, &mut accounts, &[]));
    let tracks = tracks(Vector2::new(85.0, 45.0), 4);
    let open = finds(&terrain, &tracks).open;
    assert!(open.len() > 1);
    let mut last = first.clone();
    for _ in 0..30 {
        for camera in all_around() {
            accounts.add(&terrain, None, &sensor(), &camera.view(&VEHICLE).unwrap(), 0.2);
        }
        let seen = observation(&terrain, &mut accounts, &tracks);
        assert!(seen.readings.iter().any(Reading::is_undecided), "the robot has something left to do");
        last = add(&seen);
    }
    let seen = observation(&terrain, &mut accounts, &[]);
    let again = add(&seen);
    for (cell, probability) in open.into_iter().filter(|&(_, probability)| probability > 0.1) {
        let [first, last, again] = [&first, &last, &again].map(|reported| reported[&cell]);
        assert!(first < -0.5 && last.abs() < 0.05, "{probability} {first} {last}");
        assert!((again - first).abs() < 0.05, "it was empty after all: {first} {again}");
    }
}

/// An object that comes to light once its cell, which was told to be empty, is out of sight.
#[test]
fn a_robot_has_to_come_back_to_what_it_took_to_be_empty() {
    let terrain = terrain(OPEN);
    let mut accounts = seen_from(&terrain, &all_around(), &VEHICLE, 5);
    observation(&terrain, &mut accounts, &[]);
    let finds = finds(&terrain, &tracks(Vector2::new(85.0, 45.0), 4));
    let doubted_from = |vehicle: &Pose, accounts: &Accounts| {
        doubted(&terrain, &sensor(), standing_cell(&terrain, vehicle).unwrap(), &finds, accounts)
    };
    let likeliest = finds.open.iter().max_by(|a, b| a.1.total_cmp(b.1)).unwrap().0;
    assert!(doubted_from(&FAR, &accounts).contains(likeliest));
    assert!(doubted_from(&VEHICLE, &accounts).is_empty(), "it reads them itself");
    assert!(doubted_from(&FAR, &Accounts::default()).is_empty(), "nobody took them to be empty");
}

/// The team's validation of each observation: a cell once, within the sensor's radius, not more precise than the
/// sensor, its value within 8 standard deviations of the possible ones.
#[test]
fn readings_pass_validation() {
    let terrain = terrain(OPEN);
    let mut ones = 0;
    for number in 0..40_u8 {
        let object = Vector2::new(5.0 + 2.0 * f64::from(number), 62.0 + f64::from(number) / 2.0);
        let tracks = tracks(object, u64::from(number) * 5);
        let mut accounts = seen_from(&terrain, &all_around(), &VEHICLE, 3);
        let seen = observation(&terrain, &mut accounts, &tracks);
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
fn what_a_teammate_has_declared_across_the_border_is_not_declared_again() {
    let terrain = terrain(OPEN);
    // Borders are at multiples of 10 m.
    let (west, east) = (Vector2::new(59.8, 65.0), Vector2::new(60.02, 65.0));
    let declared_in = |things: &[Vector2<f64>], declared: &[Vector2<f64>]| {
        let cell = |point: &Vector2<f64>| spread::cell_at(&terrain, *point).unwrap();
        let mut finds = Finds::default();
        finds.set_declared(declared.iter().map(cell).collect());
        let tracks = tracks_of(things, 200);
        update(&mut finds, &tracks, &terrain, &FAR);
        let mut cells: Vec<Cell> = finds.iter().map(|find| find.cell).collect();
        cells.sort();
        assert_eq!(cells.len(), things.len());
        (cells, [cell(&west), cell(&east)])
    };
    let (cells, [_, right]) = declared_in(&[east], &[]);
    assert_eq!(cells, [right]);
    let (cells, [left, _]) = declared_in(&[east], &[west]);
    assert_eq!(cells, [left]);
    // Nothing is taken for what lies elsewhere.
    let (cells, [_, right]) = declared_in(&[east], &[Vector2::new(45.0, 65.0)]);
    assert_eq!(cells, [right]);
}

#[test]
fn an_object_at_a_border_is_declared_once_its_position_improves_no_more_or_the_vehicle_leaves() {
    let terrain = terrain(OPEN);
    let east = Vector2::new(60.02, 65.0);
    let cell = spread::cell_at(&terrain, east).unwrap();
    let told = |finds: &Finds| finds.iter().map(|find| find.cell).collect::<Vec<_>>();
    let tracks = |frames| tracks_of(&[east], frames);
    assert!(tracks(200)[0].std_meters() < 0.2);
    let mut finds = Finds::default();
    update(&mut finds, &tracks(200), &terrain, &VEHICLE);
    assert_eq!(told(&finds), []);
    assert!(finds.open.contains_key(&cell));
    let mut left = finds.clone();
    update(&mut left, &tracks(200), &terrain, &FAR);
    assert_eq!(told(&left), [cell]);
    // It circles the object for minutes.
    for frames in (210..600).step_by(10) {
        update(&mut finds, &tracks(frames), &terrain, &VEHICLE);
    }
    assert_eq!(told(&finds), [cell]);
}

#[test]
fn of_two_objects_at_a_border_each_is_declared_in_its_cell() {
    let terrain = terrain(OPEN);
    let things = [Vector2::new(55.0, 65.0), Vector2::new(60.02, 65.0)];
    let cells = things.map(|point| spread::cell_at(&terrain, point).unwrap());
    let tracks = tracks_of(&things, 200);
    for order in [[0, 1], [1, 0]] {
        let tracks = order.map(|index| tracks[index].clone());
        let mut finds = Finds::default();
        finds.set_declared([cells[0]].into());
        update(&mut finds, &tracks, &terrain, &FAR);
        let mut told: Vec<Cell> = finds.iter().map(|find| find.cell).collect();
        told.sort();
        assert_eq!(told, cells);
    }
}

#[test]
fn a_vehicle_that_is_nowhere_sees_nothing_and_says_why() {
    let terrain = terrain(&format!("{OPEN}\n#........"));
    let message = |east, north, heading| {
        let vehicle = Pose::new(east, north, heading);
        let (mut finds, mut accounts) = (Finds::default(), Accounts::default());
        readings(&terrain, &sensor(), &vehicle, &mut finds, &mut accounts).unwrap_err().to_string()
    };
    assert!(message(f64::NAN, 1.0, 0.0).contains("not a number"));
    assert!(message(1.0, 1.0, f64::INFINITY).contains("not a number"));
    assert!(message(-0.1, 1.0, 0.0).contains("-0.1 m east"));
    assert_mentions(&message(1.0, 100.0, 0.0), "100 m north .. 90 m, 100 m");
    assert!(message(1e300, -1e300, 0.0).contains("of the map's corner"));
    assert_mentions(&message(5.0, 5.0, 0.0), "row 0, column 0");
}
