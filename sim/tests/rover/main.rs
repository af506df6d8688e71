//! Searches by a rover behind a radio that loses positions: is the object found where it is, wherever that is?
//!
//! `DRAGNET_SEARCHES=100 cargo test --release -p dragnet-sim --test rover -- --nocapture` is the whole measurement;
//! `DRAGNET_SEED` is the first seed of others.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod rooms;
mod search;

use std::path::Path;

use dragnet_scenario::Scenario;
use dragnet_search::seed::{Purpose, stream};
use dragnet_vehicle::settings::{CameraTable, MotionTable, Settings};
use nalgebra::Vector2;
use rand::RngExt;
use search::{Body, LONGEST_NS, Open, Search, number};

const SIDE: f64 = 8.0;

/// Edges of cells; directions of the cameras, and their range.
#[derive(Clone, Copy, Debug)]
struct Conditions {
    cell_meters: f64,
    yaws_degrees: &'static [f64],
    range_meters: f64,
    body: Body,
}

/// Three cameras that see in all directions, not as far as across two cells.
const FAST: Conditions = Conditions {
    cell_meters: 20.0,
    yaws_degrees: &[0.0, 120.0, -120.0],
    range_meters: 35.0,
    body: FAST_BODY,
};
const FAST_BODY: Body = Body {
    speed: 18.0,
    turn: 50.0,
    lost: 0.0,
    early_ns: 0,
    position_std_meters: 0.5,
    position_error_meters: 0.0,
    heading_error_radians: 0.0,
    missed: 0.0,
    bearing_error_radians: 0.0,
};

/// 8 x 8 cells with one object somewhere; a search ends when at most this many objects are expected to remain.
fn scenario(remaining: f64, cell_meters: f64) -> Scenario {
    scenario_on("shape = 'all_traversable', rows = 8, columns = 8", remaining, cell_meters)
}

fn scenario_on(map: &str, remaining: f64, cell_meters: f64) -> Scenario {
    let text = format!(
        "name = 'rover'\nmap = {{ {map}, cell_meters = {cell_meters:?} }}\n\
         objects.count = 1\nsensor.radius = 2\n[robots]\ncount = 1\npolicy = 'path'\n[mission]\nbudget_seconds = 3600.0\n\
         speed_meters_per_second = 20.0\nstop_when_expected_remaining = {remaining:?}\n"
    );
    Scenario::from_text(Path::new("rover.toml"), text).unwrap()
}

fn settings(conditions: Conditions) -> Settings {
    let camera = |&yaw_degrees| CameraTable {
        name: format!("at {yaw_degrees}"),
        field_of_view_degrees: Some(125.0),
        yaw_degrees: Some(yaw_degrees),
        min_range_meters: 1.0,
        max_range_meters: conditions.range_meters,
        ..CameraTable::wide()
    };
    Settings {
        cameras: conditions.yaws_degrees.iter().map(camera).collect(),
        motion: MotionTable::Goal {},
        speed_meters_per_second: 20.0,
        ..Settings::default()
    }
}

/// Searches for an object anywhere on the map: how many find it, and how many declare something else; prints them.
fn shares(remaining: f64, conditions: Conditions) -> (f64, f64) {
    let (first, searches) = (number("DRAGNET_SEED", 0), number("DRAGNET_SEARCHES", 20));
    let scenario = scenario(remaining, conditions.cell_meters);
    let (mut right, mut wrong, mut seconds) = (0.0, 0.0, 0.0);
    for seed in first..first + searches {
        let mut random = stream(seed, Purpose::Truth, 0);
        let mut place = || random.random_range(0.0..SIDE) * conditions.cell_meters;
        let object = Vector2::new(place(), place());
        let mut search = Search::new(&scenario, &settings(conditions), conditions.body, &Open, object, seed);
        search.complete(seed);
        let declared = search.declared(&scenario);
        right += f64::from(declared.0 > 0);
        wrong += f64::from(declared.1 > 0);
        seconds += search.rests_since.unwrap_or(LONGEST_NS) as f64 / 1e9;
    }
    let count = searches as f64;
    println!(
        "at most {remaining} objects remain, {conditions:?}: of {searches} searches {right} find the object, \
         {wrong} declare something else, {:.0} s",
        seconds / count
    );
    (right / count, wrong / count)
}

/// Objects lie anywhere, also in corners and on the edge of the map.
#[test]
fn objects_are_found_as_often_as_the_end_of_the_search_promises() {
    let slow = Conditions { body: Body { speed: 5.0, turn: 1.0, ..FAST_BODY }, ..FAST };
    let late = Conditions { body: Body { lost: 0.3, early_ns: 60_000_000, ..FAST_BODY }, ..FAST };
    for conditions in [FAST, slow, late] {
        let (right, wrong) = shares(0.05, conditions);
        // 0.95 are promised: of 20 searches fewer than 16 find it once in 10^4 times.
        assert!(right >= 0.8 && wrong <= 0.05, "{right} {wrong}");
        let (right, wrong) = shares(0.005, conditions);
        assert!(right >= 0.9 && wrong <= 0.05, "{right} {wrong}");
    }
}

/// An object is placed in the likeliest cell then, and reported with its error.
#[test]
fn cells_that_are_smaller_than_the_error_of_positions_keep_no_robot_for_ever() {
    let vague = Conditions {
        cell_meters: 5.0,
        range_meters: 20.0,
        body: Body { speed: 2.0, turn: 1.0, position_std_meters: 3.0, ..FAST_BODY },
        ..FAST
    };
    let (right, wrong) = shares(0.005, vague);
    assert!(right >= 0.9 && wrong <= 0.1, "{right} {wrong}");
}

/// A search of a map without objects, which must end.
fn ends(scenario: &Scenario, conditions: Conditions) {
    for seed in 0..2 {
        let mut search = Search::new(
            scenario,
            &settings(conditions),
            conditions.body,
            &Open,
            Vector2::new(-1e6, 0.0),
            seed,
        );
        search.complete(seed);
        assert!(
            search.rests_since.is_some(),
            "{conditions:?}: after {} s it still drives",
            search.now_ns / 1_000_000_000
        );
    }
}

/// One camera that faces forward never sees the corners of large cells.
#[test]
fn a_search_ends_though_parts_of_cells_are_never_in_view() {
    let narrow = Conditions {
        cell_meters: 50.0,
        yaws_degrees: &[0.0],
        range_meters: 30.0,
        body: Body { speed: 14.0, ..FAST_BODY },
    };
    ends(&scenario(0.005, narrow.cell_meters), narrow);
}

/// The sensor's model sees over walls; cameras do not.
#[test]
fn a_search_ends_though_a_yard_is_behind_walls() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("yard.map");
    let yard = "type octile\nheight 6\nwidth 6\nmap\n......\n..@@@.\n..@.@.\n..@@@.\n......\n......\n";
    std::fs::write(&file, yard).unwrap();
    ends(&scenario_on(&format!("file = '{}'", file.display()), 0.005, FAST.cell_meters), FAST);
}
