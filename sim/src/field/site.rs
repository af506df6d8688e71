//! The site: positions of objects, start poses of vehicles, and the ground between the trees.

use std::f64::consts::{PI, TAU};

use dragnet_lattice::costmap::{CostMap, CostMapError, LETHAL};
use dragnet_lattice::plane::Pose;
use dragnet_scenario::{Robot, Scenario};
use dragnet_search::cell::{Cell, Position};
use dragnet_search::measures::Truth;
use dragnet_search::seed::{Purpose, stream};
use dragnet_search::terrain::Terrain;
use dragnet_vehicle::settings::{CameraTable, FootprintTable, MotionTable, Settings, TrackerTable};
use nalgebra::Vector2;
use rand::RngExt;

use super::cameras::HEAD_RADIANS_PER_SECOND;
use crate::world;

/// The turning radius of the vehicle.
pub(super) const TURNING_RADIUS_METERS: f64 = 3.0;
/// Maximum distance of sight between the trees.
const SIGHT_METERS: f64 = 100.0;
/// Squares of the lattice along the side of a cell.
const PARTS: u32 = 15;
/// Share of these squares with a tree.
const TREES: f64 = 0.02;
/// Distance from a start without trees, squares.
const CLEARING: u32 = 4;
/// Distance of objects from the edge of their cell: an object on a border would be in both cells.
const MARGIN_METERS: f64 = 1.0;
/// Distance between vehicles that start in one cell.
const APART_METERS: f64 = 2.0;

/// An invalid site.
#[derive(Debug, thiserror::Error)]
pub enum SiteError {
    /// Error of the ground.
    #[error(transparent)]
    Ground(#[from] CostMapError),
    /// Cells that are too small for the margin.
    #[error("cells of {0} m: needed are more than 4 m, so that an object can lie inside one")]
    Cells(f64),
}

/// The vehicle of the field test: the paper's two cameras on a head that turns all the time. Objects do not move, so
/// tracks hardly do; between two turns of the head the bearing to a near object changes by many degrees, and its range
/// is unknown: the gate is wide.
#[must_use]
pub fn settings(speed_meters_per_second: f64) -> Settings {
    Settings {
        cameras: vec![
            CameraTable { max_range_meters: SIGHT_METERS, ..CameraTable::wide() },
            CameraTable { max_range_meters: SIGHT_METERS, ..CameraTable::narrow() },
        ],
        tracker: TrackerTable {
            velocity_std_meters_per_second: 0.01,
            acceleration_std_meters_per_second: 1e-4,
            gate_degrees: 8.0,
            ..TrackerTable::default()
        },
        motion: MotionTable::Lattice {
            primitives: None,
            turning_radius_meters: Some(TURNING_RADIUS_METERS),
            headings: Some(16),
            reverse_cost: Some(5),
            turn_in_place_cost: None,
            max_expansions: 200_000,
            replan_beyond_meters: 3.0,
        },
        footprint: FootprintTable::Rectangle { length_meters: 1.5, width_meters: 1.0 },
        speed_meters_per_second,
        initial_scan_seconds: TAU / HEAD_RADIANS_PER_SECOND,
        ..Settings::default()
    }
}

/// The objects, the start poses and the ground.
#[derive(Clone, Debug)]
pub(super) struct Site {
    truth: Truth,
    objects_meters: Vec<Vector2<f64>>,
    starts: Vec<Pose>,
    ground: CostMap,
}

impl Site {
    /// The site of a seed, independent of the policies.
    pub(super) fn new(scenario: &Scenario, seed: u64) -> Result<Self, SiteError> {
        let terrain = scenario.terrain();
        if terrain.cell_meters() <= 4.0 * MARGIN_METERS {
            return Err(SiteError::Cells(terrain.cell_meters()));
        }
        let (truth, objects_meters) = things(scenario, seed);
        let starts = starts(scenario, seed);
        let ground = ground(terrain, &starts, seed)?;
        Ok(Self { truth, objects_meters, starts, ground })
    }

    pub(super) const fn truth(&self) -> &Truth {
        &self.truth
    }

    /// Meters east and north, one for each object.
    pub(super) fn objects_meters(&self) -> &[Vector2<f64>] {
        &self.objects_meters
    }

    /// The start pose of each robot.
    pub(super) fn starts(&self) -> &[Pose] {
        &self.starts
    }

    pub(super) const fn ground(&self) -> &CostMap {
        &self.ground
    }
}

fn things(scenario: &Scenario, seed: u64) -> (Truth, Vec<Vector2<f64>>) {
    let terrain = scenario.terrain();
    let mut random = stream(seed, Purpose::Truth, 0);
    let truth = world::draw_truth(scenario, &mut random);
    let reach = terrain.cell_meters() / 2.0 - MARGIN_METERS;
    let mut place = |&cell: &Cell| {
        let (east, north) = terrain.center_meters(cell);
        Vector2::new(east + random.random_range(-reach..reach), north + random.random_range(-reach..reach))
    };
    let places = truth.objects().iter().map(&mut place).collect();
    (truth, places)
}

fn starts(scenario: &Scenario, seed: u64) -> Vec<Pose> {
    let terrain = scenario.terrain();
    let cells = world::draw_starts(scenario, seed);
    let count = cells.len() as f64;
    let pose = |(index, (cell, robot)): (usize, (Cell, &Robot))| {
        let (east, north) = terrain.center_meters(cell);
        let beside = (index as f64 - (count - 1.0) / 2.0) * APART_METERS;
        // The stream of robot 0 is for the trees.
        let heading = stream(seed, Purpose::Map, robot.id.number()).random_range(-PI..PI);
        Pose::new(east + beside, north, heading)
    };
    cells.into_iter().zip(scenario.robots()).enumerate().map(pose).collect()
}

/// Free where the terrain is traversable and there is no tree.
fn ground(terrain: &Terrain, starts: &[Pose], seed: u64) -> Result<CostMap, CostMapError> {
    let mut map = CostMap::from_terrain(terrain, PARTS)?;
    let mut random = stream(seed, Purpose::Map, 0);
    let grid = map.grid();
    let starts: Vec<Position> = starts
        .iter()
        .filter_map(|pose| map.cell_at(pose.x_meters, pose.y_meters))
        .map(|cell| grid.position(cell))
        .collect();
    for cell in grid.cells() {
        let at = grid.position(cell);
        let is_near =
            |start: &Position| at.row.abs_diff(start.row).max(at.column.abs_diff(start.column)) <= CLEARING;
        let has_tree = random.random_bool(TREES);
        if has_tree && !starts.iter().any(is_near) {
            map.set(cell, LETHAL)?;
        }
    }
    Ok(map)
}
