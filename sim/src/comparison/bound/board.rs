//! What the robots of a scenario can see, from where, and the moves between.

use dragnet_scenario::{Scenario, Start};
use dragnet_search::cell::{Cell, Grid, Offset};
use dragnet_search::reach::{Reach, Sight};
use dragnet_search::route::{Connectivity, ShortestPathTree};

/// A move to another position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// The position entered.
    pub to: u16,
    /// Its length, in [`Board::units_per_cell`].
    pub length: u8,
}

/// Positions and targets have numbers, by index of their cells.
pub(super) struct Board {
    grid: Grid,
    /// Radius of the sensor, cells, if glances are distinguished from other looks.
    glance_radius: Option<u32>,
    /// Cells where a robot can stand.
    pub positions: Vec<Cell>,
    /// Cells that hold an object that has to be found, if any.
    pub targets: Vec<Cell>,
    /// The moves from each position.
    pub steps: Vec<Vec<Step>>,
    /// The targets seen from each position.
    pub seen: Vec<Vec<u16>>,
    /// The positions where robots start: each robot of a team in any of its own, all equally likely.
    pub starts: Starts,
    /// Units of length in a cell. With diagonals a unit is a fifth, and a diagonal counts seven of them, which is less
    /// than its length: a bound stays one.
    pub units_per_cell: u8,
}

/// How robots start.
pub(super) enum Starts {
    /// All of them in one of these positions, equally likely.
    Together(Vec<u16>),
    /// Each in any of its positions.
    Apart(Vec<Vec<u16>>),
}

impl Board {
    /// The most positions.
    pub(super) const MAX_POSITIONS: usize = 4096;

    /// The board of a scenario, with glances or without. `None` if there are more than [`Board::MAX_POSITIONS`], or more targets than that.
    pub(super) fn new(scenario: &Scenario, has_glances: bool) -> Option<Self> {
        let (terrain, sensor, connectivity) =
            (scenario.terrain(), scenario.widest_sensor(), scenario.connectivity());
        let grid = terrain.grid();
        let areas = terrain.connected_areas();
        let starts: Vec<Vec<Cell>> = scenario
            .robots()
            .iter()
            .map(|robot| match robot.start {
                Start::Together { area } => areas[area].clone(),
                Start::Scattered => areas[0].clone(),
                Start::Cell(cell) => vec![cell],
            })
            .collect();
        let mut reach = Reach::unknown(grid);
        let mut positions = Vec::new();
        // All cells where one robot may start are connected.
        for first in starts.iter().filter_map(|starts| starts.first().copied()) {
            reach.add_robot(terrain, Sight::on_ground(sensor.radius()), first);
            positions.extend_from_slice(ShortestPathTree::from(terrain, connectivity, first).reached());
        }
        positions.sort_unstable();
        positions.dedup();
        let threshold = scenario.mission().detection_threshold;
        // What the prior alone calls found need not be seen.
        let is_target = |&cell: &Cell| reach.covers(cell) && !scenario.prior().is_found(cell, threshold);
        let targets: Vec<Cell> = terrain.searched_cells().filter(is_target).collect();
        if positions.len().max(targets.len()) > Self::MAX_POSITIONS {
            return None;
        }
        let number = |cells: &[Cell], cell: Cell| {
            cells.binary_search(&cell).ok().and_then(|place| u16::try_from(place).ok())
        };
        let (straight, diagonal) = if connectivity == Connectivity::Four { (1, 1) } else { (5, 7) };
        let steps = |&from: &Cell| {
            let to = connectivity.neighbors(terrain, from);
            to.filter_map(|cell| {
                let length = if grid.manhattan(from, cell) == 1 { straight } else { diagonal };
                Some(Step { to: number(&positions, cell)?, length })
            })
            .collect()
        };
        let seen = |&from: &Cell| {
            let cells = terrain.in_sight(sensor, from).map(|(cell, _)| cell);
            let mut seen: Vec<u16> = cells.filter_map(|cell| number(&targets, cell)).collect();
            seen.sort_unstable();
            seen
        };
        let numbers = |cells: &[Cell]| cells.iter().filter_map(|&cell| number(&positions, cell)).collect();
        let is_with_first =
            |start| matches!(start, Start::Together { .. }) && start == scenario.robots()[0].start;
        let is_together = scenario.robots().iter().all(|robot| is_with_first(robot.start));
        let starts = match starts.first() {
            Some(first) if is_together || starts.len() == 1 => Starts::Together(numbers(first)),
            _ => Starts::Apart(starts.iter().map(|starts| numbers(starts)).collect()),
        };
        Some(Self {
            steps: positions.iter().map(steps).collect(),
            seen: positions.iter().map(seen).collect(),
            starts,
            units_per_cell: straight,
            positions,
            targets,
            grid,
            glance_radius: Some(sensor.radius()).filter(|_| has_glances),
        })
    }

    /// Whether a move brings a target into sight at the sensor's radius, exactly aside: if the robot goes straight on,
    /// this look is the only one.
    pub(super) fn is_glance(&self, target: u16, from: usize, to: usize) -> bool {
        let step = self.grid.offset(self.positions[from], self.positions[to]);
        let Offset { north, east } = self.offset(to, target);
        self.is_at_radius(to, target) && north * step.north + east * step.east == 0
    }

    /// Whether a target that is in sight from only one of two positions in a row may have been glanced at from there,
    /// and nowhere else.
    pub(super) fn is_glanced(&self, target: u16, before: usize, at: usize) -> bool {
        let Offset { north, east } = self.offset(before, target);
        self.is_glance(target, before, at) || self.is_at_radius(before, target) && (north == 0 || east == 0)
    }

    /// Targets within a distance of a position, cells.
    pub(super) fn near(&self, position: usize, distance: u32) -> Vec<u16> {
        let seen = self.seen[position].iter().copied();
        seen.filter(|&target| self.offset(position, target).manhattan() <= distance).collect()
    }

    fn is_at_radius(&self, position: usize, target: u16) -> bool {
        self.glance_radius == Some(self.offset(position, target).manhattan())
    }

    fn offset(&self, position: usize, target: u16) -> Offset {
        self.grid.offset(self.positions[position], self.targets[usize::from(target)])
    }
}
