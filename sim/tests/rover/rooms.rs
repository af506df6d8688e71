//! Rooms with walls that are much thinner than the cells, and objects that lie against them.

use std::collections::VecDeque;
use std::path::Path;

use dragnet_lattice::costmap::{CostMap, LETHAL};
use dragnet_scenario::Scenario;
use dragnet_search::cell::{Cell, Grid, Position};
use dragnet_search::seed::{Purpose, stream};
use dragnet_vehicle::settings::{CameraTable, FootprintTable, MotionTable, Settings};
use nalgebra::Vector2;
use rand::{Rng, RngExt};

use crate::search::{Body, Ground, Search, number};

/// Edge of a pixel of the map, and thickness of the walls.
const PIXEL_METERS: f64 = 0.05;
const COLUMNS: u32 = 240;
const ROWS: u32 = 160;
const EAST_METERS: f64 = COLUMNS as f64 * PIXEL_METERS;
const NORTH_METERS: f64 = ROWS as f64 * PIXEL_METERS;
/// Where the walls are.
const ACROSS: f64 = 6.32;
const DIVIDING: f64 = 4.57;
/// The robot keeps this far from walls; pixels.
const CLEARANCE: i64 = 6;
/// A goal may be this far off, as for Nav2's `NavFn`.
const GOAL_METERS: f64 = 0.5;

/// A robot of half a meter with one camera, behind an indoor localization that reports more error than it has.
const BODY: Body = Body {
    speed: 0.5,
    turn: 1.0,
    lost: 0.0,
    early_ns: 0,
    position_std_meters: 0.05,
    position_error_meters: 0.03,
    heading_error_radians: 0.01,
    missed: 0.1,
    bearing_error_radians: 0.005,
};

/// An outline, a wall across the whole floor and one that divides its eastern half, each with a door.
fn is_wall(place: Vector2<f64>) -> bool {
    let pixel = |meters: f64| (meters / PIXEL_METERS).floor();
    let is_in_outline = pixel(place.x) < 1.0
        || pixel(place.y) < 1.0
        || place.x > EAST_METERS - PIXEL_METERS
        || place.y > NORTH_METERS - PIXEL_METERS;
    let is_same = |a: f64, b: f64| (pixel(a) - pixel(b)).abs() < 0.5;
    let is_across = is_same(place.x, ACROSS) && !(2.0..3.4).contains(&place.y);
    let divides = is_same(place.y, DIVIDING) && place.x > ACROSS && !(9.0..10.4).contains(&place.x);
    is_in_outline || is_across || divides
}

/// The floor, and where the robot has room.
struct Rooms {
    map: CostMap,
    has_room: Vec<bool>,
}

impl Rooms {
    fn new() -> Self {
        let grid = Grid::new(ROWS, COLUMNS).unwrap();
        let cost = |cell| if is_wall(middle(grid, cell)) { LETHAL } else { 0 };
        let map = CostMap::new(grid, PIXEL_METERS, (0.0, 0.0), grid.cells().map(cost).collect()).unwrap();
        let is_near_wall = |cell| {
            let Position { row, column } = grid.position(cell);
            let around = (-CLEARANCE..=CLEARANCE)
                .flat_map(|up| (-CLEARANCE..=CLEARANCE).map(move |right| (up, right)));
            around.filter(|(up, right)| up * up + right * right <= CLEARANCE * CLEARANCE).any(
                |(up, right)| {
                    let other = grid.cell_at(
                        (i64::from(column) + right) as f64 + 0.5,
                        (i64::from(row) + up) as f64 + 0.5,
                    );
                    other.is_some_and(|other| map.is_lethal(other))
                },
            )
        };
        let has_room = grid.cells().map(|cell| !is_near_wall(cell)).collect();
        Self { map, has_room }
    }
}

fn middle(grid: Grid, cell: Cell) -> Vector2<f64> {
    let Position { row, column } = grid.position(cell);
    Vector2::new(f64::from(column) + 0.5, f64::from(row) + 0.5) * PIXEL_METERS
}

impl Ground for Rooms {
    fn map(&self) -> Option<&CostMap> {
        Some(&self.map)
    }

    fn way(&self, from: Vector2<f64>, goal: Vector2<f64>) -> Option<Vec<Vector2<f64>>> {
        let grid = self.map.grid();
        let away = |cell: Cell| (middle(grid, cell) - goal).norm();
        let roomy = grid.cells().filter(|cell| self.has_room[cell.index()] && away(*cell) < GOAL_METERS);
        let end = roomy.min_by(|a, b| away(*a).total_cmp(&away(*b)))?;
        let start = self.map.cell_at(from.x, from.y)?;
        let mut next = vec![None; grid.cell_count()];
        next[end.index()] = Some(end);
        let mut reached = VecDeque::from([end]);
        while let Some(cell) = reached.pop_front() {
            let here = middle(grid, cell);
            for step in [Vector2::x(), -Vector2::x(), Vector2::y(), -Vector2::y()] {
                let there = here + step * PIXEL_METERS;
                let Some(other) = self.map.cell_at(there.x, there.y) else { continue };
                if next[other.index()].is_none() && (self.has_room[other.index()] || other == start) {
                    next[other.index()] = Some(cell);
                    reached.push_back(other);
                }
            }
        }
        next[start.index()]?;
        let steps = std::iter::successors(Some(start), |cell| next[cell.index()].filter(|next| next != cell));
        let sparse = steps.skip(4).step_by(4).map(|cell| middle(grid, cell));
        Some(sparse.chain([middle(grid, end)]).collect())
    }

    fn hides(&self, from: Vector2<f64>, to: Vector2<f64>) -> bool {
        // No line of sight is longer than ten meters.
        const STEPS: u32 = 1000;
        (0..STEPS).any(|step| is_wall(from + (to - from) * (f64::from(step) / f64::from(STEPS))))
    }
}

/// Cells of one meter; the walls lead through them.
fn scenario(folder: &Path, rooms: &Rooms) -> Scenario {
    let grid = rooms.map.grid();
    let mut image = format!("P5\n{} {}\n255\n", grid.columns(), grid.rows()).into_bytes();
    for row in (0..grid.rows()).rev() {
        let cells = (0..grid.columns()).filter_map(|column| grid.cell(Position { row, column }));
        image.extend(cells.map(|cell| if rooms.map.is_lethal(cell) { 0 } else { 254 }));
    }
    std::fs::write(folder.join("rooms.pgm"), image).unwrap();
    let yaml = "image: rooms.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n\
                occupied_thresh: 0.65\nfree_thresh: 0.25\n";
    std::fs::write(folder.join("rooms.yaml"), yaml).unwrap();
    let text = "name = 'rooms'\nmap = { file = 'rooms.yaml', cell_meters = 1.0 }\nobjects.count = 1\n\
                sensor.radius = 5\n[robots]\ncount = 1\npolicy = 'path'\n[mission]\nbudget_seconds = 3600.0\n\
                speed_meters_per_second = 0.5\nstop_when_expected_remaining = 0.001\n";
    Scenario::from_text(&folder.join("rooms.toml"), text.to_owned()).unwrap()
}

fn settings() -> Settings {
    let camera = CameraTable {
        name: "front".to_owned(),
        field_of_view_degrees: Some(90.0),
        min_range_meters: 0.3,
        max_range_meters: 5.0,
        ..CameraTable::wide()
    };
    Settings {
        cameras: vec![camera],
        motion: MotionTable::Goal {},
        footprint: FootprintTable::Rectangle { length_meters: 0.5, width_meters: 0.4 },
        speed_meters_per_second: BODY.speed,
        ..Settings::default()
    }
}

/// A place at this distance from a wall that stands there, on either side of it.
fn against_a_wall(gap_meters: f64, random: &mut impl Rng) -> Vector2<f64> {
    loop {
        let is_across = random.random_bool(0.5);
        let side = if random.random_bool(0.5) { -gap_meters } else { gap_meters + PIXEL_METERS };
        let edge = |wall: f64| (wall / PIXEL_METERS).floor() * PIXEL_METERS + side;
        let (place, wall) = if is_across {
            let north = random.random_range(0.5..NORTH_METERS - 0.5);
            (Vector2::new(edge(ACROSS), north), Vector2::new(ACROSS, north))
        } else {
            let east = random.random_range(ACROSS + 0.5..EAST_METERS - 0.5);
            (Vector2::new(east, edge(DIVIDING)), Vector2::new(east, DIVIDING))
        };
        if is_wall(wall) {
            return place;
        }
    }
}

/// However little room is between an object and a wall, which hides it from the other side.
#[test]
fn an_object_against_a_thin_wall_is_found_on_its_side_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let rooms = Rooms::new();
    let scenario = scenario(folder.path(), &rooms);
    let (first, searches) = (number("DRAGNET_SEED", 0), number("DRAGNET_SEARCHES", 10));
    let (mut right, mut wrong) = (0, 0);
    for gap_meters in [0.05, 0.2, 0.7] {
        let before = (right, wrong);
        for seed in first..first + searches {
            let object = against_a_wall(gap_meters, &mut stream(seed, Purpose::Truth, 0));
            let mut search = Search::new(&scenario, &settings(), BODY, &rooms, object, seed);
            search.complete(seed);
            let declared = search.declared(&scenario);
            right += u32::from(declared.0 > 0);
            wrong += u32::from(declared.1 > 0);
        }
        println!(
            "{gap_meters} m from a wall: of {searches} searches {} find the object, {} declare something else",
            right - before.0,
            wrong - before.1
        );
    }
    let share = |count: u32| f64::from(count) / (3 * searches) as f64;
    assert!(share(right) >= 0.85 && share(wrong) <= 0.05, "{right} {wrong}");
}
