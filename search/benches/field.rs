//! A robot that searches alone, without a simulator: where the benches decide.

use dragnet_search::belief::Belief;
use dragnet_search::cell::{Cell, Grid, Position};
use dragnet_search::evidence::Reading;
use dragnet_search::intent::PlannedPrecision;
use dragnet_search::measures::Truth;
use dragnet_search::policy::{Decision, Parameters, Policy, PolicyName, build};

use dragnet_search::seed::{Purpose, Stream, stream};
use dragnet_search::sensor::Sensor;
use dragnet_search::shape::Shape;
use dragnet_search::situation::Situation;
use dragnet_search::terrain::Terrain;
use rand::RngExt;
use rand::seq::IndexedRandom;

/// On larger maps than this (cells a side) half of the map is seen by driving lanes: an episode would take too long.
const LARGEST_EPISODE_SIDE: u32 = 100;

/// Map, truth, and the state of one robot.
#[derive(Clone)]
pub(crate) struct Field {
    terrain: Terrain,
    sensor: Sensor,
    /// Where the objects are.
    pub(crate) truth: Truth,
    /// The robot's belief.
    pub(crate) belief: Belief,
    planned_precision: PlannedPrecision,
    robot: Cell,
    noise: Stream,
    decisions: Stream,
}

impl Field {
    /// A square map at the start of an episode: the robot has made one observation, from a cell drawn in the largest
    /// area.
    pub(crate) fn fresh(shape: Shape, side: u32, density: f64, seed: u64) -> Self {
        Self::on(
            shape.terrain(Grid::new(side, side).unwrap(), 30.0).unwrap(),
            Sensor::default(),
            density,
            seed,
        )
    }

    /// The same of any map and sensor.
    pub(crate) fn on(terrain: Terrain, sensor: Sensor, density: f64, seed: u64) -> Self {
        let mut draw = stream(seed, Purpose::Truth, 0);
        let searched: Vec<Cell> = terrain.searched_cells().collect();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of cells")]
        let count = (searched.len() as f64 * density).round() as usize;
        let objects = searched.sample(&mut draw, count).copied().collect();
        let area = terrain.largest_area();
        let robot = area[stream(seed, Purpose::Start, 1).random_range(0..area.len())];
        let mut field = Self {
            sensor,
            truth: Truth::new(&terrain, objects),
            belief: Belief::uniform(&terrain, density).unwrap(),
            planned_precision: PlannedPrecision::nothing(&terrain),
            robot,
            noise: stream(seed, Purpose::Noise, 1),
            decisions: stream(seed, Purpose::Decision, 1),
            terrain,
        };
        field.enter(robot);
        field
    }

    /// A map without obstacles midway in an episode: half of it is seen. Up to [`LARGEST_EPISODE_SIDE`] `path` drove
    /// there; beyond, the robot has driven lanes a sensor's width apart over the southern half.
    pub(crate) fn midway(side: u32, density: f64, seed: u64) -> Self {
        let mut field = Self::fresh(Shape::AllTraversable, side, density, seed);
        if side > LARGEST_EPISODE_SIDE {
            field.drive_lanes(side / 2);
            return field;
        }
        let mut policy = build(PolicyName::Path, Parameters::default());
        while field.seen_share() < 0.5 {
            for cell in field.decide(policy.as_mut()).path {
                field.enter(cell);
            }
        }
        field
    }

    /// The robot's situation.
    pub(crate) fn situation(&self) -> Situation<'_> {
        Situation::alone(&self.terrain, &self.sensor, &self.belief, &self.planned_precision, self.robot)
    }

    /// Decides in the current situation, with the robot's own random stream.
    pub(crate) fn decide(&mut self, policy: &mut (dyn Policy + Send)) -> Decision {
        let mut random = self.decisions.clone();
        let decision = policy.decide(&self.situation(), &mut random);
        self.decisions = random;
        decision
    }

    /// Moves to a cell and observes.
    pub(crate) fn enter(&mut self, cell: Cell) {
        self.robot = cell;
        for reading in self.observe() {
            self.belief.add(&reading);
        }
    }

    /// The readings of one observation.
    pub(crate) fn observe(&mut self) -> Vec<Reading> {
        let mut readings = Vec::with_capacity(self.sensor.footprint().len());
        for (cell, observation) in self.terrain.in_sight(&self.sensor, self.robot) {
            let value = self.sensor.draw(self.truth.is_object(cell), observation, &mut self.noise);
            readings.push(Reading { cell, value, variance: observation.variance });
        }
        readings
    }

    fn seen_share(&self) -> f64 {
        let cells = self.belief.evidence().cells();
        cells.iter().filter(|cell| cell.precision > 0).count() as f64 / cells.len() as f64
    }

    fn drive_lanes(&mut self, rows: u32) {
        let grid = self.terrain.grid();
        let radius = self.sensor.radius();
        let lanes = (radius..rows).step_by(2 * radius as usize + 1);
        for (lane, row) in lanes.enumerate() {
            for along in 0..grid.columns() {
                let column = if lane % 2 == 0 { along } else { grid.columns() - 1 - along };
                self.enter(grid.cell(Position { row, column }).unwrap());
            }
        }
    }
}
