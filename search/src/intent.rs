//! Observations that teammates plan to make: along their planned paths, and in their shares of the rest of the map.

use std::cmp::Ordering;
use std::ops::{Deref, Range};
use std::sync::Arc;

use crate::cell::{Cell, Grid, Offset, Position};
use crate::line_of_sight::LineOfSight;
use crate::sensor::Sensor;
use crate::terrain::Terrain;

/// Precision that teammates' plans are expected to add, shape `[cells]`, units of evidence; and the plans, for policies
/// that ask when it will be added.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedPrecision {
    precision: Vec<i64>,
    plans: Vec<TeammatePlan>,
}

/// The rest of a path that a robot has planned: cells to enter, in order. Copies share the path, whatever is left of it.
#[derive(Clone, Debug, Default)]
pub struct PlannedPath {
    cells: Arc<[Cell]>,
    /// Number of cells entered.
    entered: usize,
}

impl PlannedPath {
    /// Removes the first cells: they have been entered.
    pub fn enter(&mut self, count: usize) {
        self.entered = (self.entered + count).min(self.cells.len());
    }
}

impl From<Vec<Cell>> for PlannedPath {
    fn from(cells: Vec<Cell>) -> Self {
        Self { cells: cells.into(), entered: 0 }
    }
}

impl FromIterator<Cell> for PlannedPath {
    fn from_iter<I: IntoIterator<Item = Cell>>(cells: I) -> Self {
        cells.into_iter().collect::<Vec<Cell>>().into()
    }
}

impl Deref for PlannedPath {
    type Target = [Cell];

    fn deref(&self) -> &[Cell] {
        &self.cells[self.entered..]
    }
}

impl PartialEq for PlannedPath {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl Eq for PlannedPath {}

/// What is known of a teammate's plan.
#[derive(Clone, Debug, PartialEq)]
pub struct TeammatePlan {
    /// Its index in the team, if it is one of the team.
    pub member: Option<u16>,
    /// Where it was last, if known.
    pub cell: Option<Cell>,
    /// The cells that it was still to enter when it was last heard of, in order.
    pub path: PlannedPath,
    /// How far it has come since, if it went on at its usual speed, cells.
    pub driven_cells: f64,
    /// Its sensor.
    pub sensor: Arc<Sensor>,
    /// What walls hide from it.
    pub line_of_sight: LineOfSight,
    /// Cells that it crosses while this robot crosses one, above 0.
    pub pace: f64,
}

impl TeammatePlan {
    /// Whether it sees and goes as this robot does.
    fn is_alike(&self, sensor: &Sensor) -> bool {
        self.pace.to_bits() == 1.0_f64.to_bits() && *self.sensor == *sensor
    }
}

impl PlannedPrecision {
    /// No planned precision.
    #[must_use]
    pub fn nothing(terrain: &Terrain) -> Self {
        Self { precision: vec![0; terrain.grid().cell_count()], plans: Vec::new() }
    }

    /// Planned precision from stored values, units of evidence, shape `[cells]`; `None` if one is below 0.
    #[must_use]
    pub fn from_precision(precision: Vec<i64>) -> Option<Self> {
        let plans = Vec::new();
        precision.iter().all(|&precision| precision >= 0).then_some(Self { precision, plans })
    }

    /// Whether any precision is planned.
    #[must_use]
    pub fn is_anything(&self) -> bool {
        self.precision.iter().any(|&precision| precision > 0)
    }

    /// Adds an observation from every cell of a path.
    pub fn add_path(&mut self, terrain: &Terrain, sensor: &Sensor, path: &[Cell]) {
        self.add_seen(terrain.grid(), terrain.line_of_sight(), sensor, path);
    }

    #[expect(clippy::cast_possible_wrap, reason = "a map has fewer than 2^31 cells")]
    fn add_seen(&mut self, grid: Grid, line_of_sight: &LineOfSight, sensor: &Sensor, path: &[Cell]) {
        let radius = sensor.radius();
        let step = |Offset { north, east }| north as isize * grid.columns() as isize + east as isize;
        let steps: Vec<(isize, i64)> =
            sensor.footprint().iter().map(|it| (step(it.offset), it.precision)).collect();
        let is_inside = |at: u32, count: u32| at >= radius && at + radius < count;
        for &from in path {
            let Position { row, column } = grid.position(from);
            let is_far_from_edges = is_inside(row, grid.rows()) && is_inside(column, grid.columns());
            // No cell of the footprint needs to be looked for.
            if is_far_from_edges && line_of_sight.shadows(from).is_none() {
                for &(step, precision) in &steps {
                    self.precision[from.index().wrapping_add_signed(step)] += precision;
                }
                continue;
            }
            for (cell, observation) in line_of_sight.seen(grid, sensor, from) {
                self.precision[cell.index()] += observation.precision;
            }
        }
    }

    /// Adds the observations of a teammate's plan, and keeps the plan for policies that ask when they happen.
    pub fn add_plan(&mut self, terrain: &Terrain, plan: TeammatePlan) {
        self.add_seen(terrain.grid(), &plan.line_of_sight, &plan.sensor, &plan.path);
        self.plans.push(plan);
    }

    /// The plans added by [`PlannedPrecision::add_plan`], at most one of each teammate.
    #[must_use]
    pub fn plans(&self) -> &[TeammatePlan] {
        &self.plans
    }

    /// Adds the share of each teammate with a plan: one observation, from its own cell, of every cell that the teammate
    /// reaches sooner from its waypoint than this robot does, with this sensor, from its cell, both in a straight line.
    ///
    /// A planned path ends long before the search does. The rest of the map is left to the nearest robot, as in a
    /// Voronoi partition that moves with the robots, and is weighted by their speeds. A share only lowers the gain: a
    /// cell that is worth a second observation, or is all that is left, can still be visited by any robot.
    pub fn add_shares(&mut self, terrain: &Terrain, sensor: &Sensor, robot: Cell) {
        let grid = terrain.grid();
        let (alike, unlike): (Vec<_>, Vec<_>) = self.plans.iter().partition(|plan| plan.is_alike(sensor));
        let waypoints: Vec<Cell> = alike.iter().filter_map(|plan| plan.path.last().copied()).collect();
        let unlike: Vec<Unlike> = unlike.into_iter().filter_map(|plan| Unlike::new(grid, plan)).collect();
        let observation = best_precision(sensor);
        let others = Others::new(grid, robot, &waypoints);
        let robot = grid.position(robot);
        for (row, precision) in (0..).zip(self.precision.chunks_mut(grid.columns() as usize)) {
            let own = others.leave(row, grid.columns());
            let (west, rest) = precision.split_at_mut(own.start);
            let east = &mut rest[own.len()..];
            west.iter_mut().chain(east).for_each(|precision| *precision += observation);
            if unlike.is_empty() {
                continue;
            }
            for (column, precision) in (0..).zip(precision).skip(own.start).take(own.len()) {
                let cell = Position { row, column };
                let sooner = unlike.iter().find(|other| other.is_sooner(cell, robot));
                *precision += sooner.map_or(0, |other| other.precision);
            }
        }
    }

    /// Precision planned for a cell, units of evidence.
    #[must_use]
    pub fn precision(&self, cell: Cell) -> i64 {
        self.precision[cell.index()]
    }
}

/// Precision of a sensor's best reading.
fn best_precision(sensor: &Sensor) -> i64 {
    sensor.footprint().iter().map(|observation| observation.precision).max().unwrap_or_default()
}

/// A teammate of another speed, or with another sensor. What it reaches sooner has no straight border.
struct Unlike {
    waypoint: Position,
    /// The square of its pace.
    pace_squared: f64,
    precision: i64,
}

impl Unlike {
    fn new(grid: Grid, plan: &TeammatePlan) -> Option<Self> {
        let waypoint = grid.position(*plan.path.last()?);
        Some(Self { waypoint, pace_squared: plan.pace * plan.pace, precision: best_precision(&plan.sensor) })
    }

    fn is_sooner(&self, cell: Position, robot: Position) -> bool {
        let squared = |from: Position| {
            let (north, east) = (cell.row.abs_diff(from.row), cell.column.abs_diff(from.column));
            f64::from(north).powi(2) + f64::from(east).powi(2)
        };
        squared(self.waypoint) < squared(robot) * self.pace_squared
    }
}

/// Teammates' waypoints that are not in the robot's cell. Each leaves to the robot the half plane that is not nearer to the
/// waypoint, so all of them together leave an interval of each row, computed in integers.
struct Others {
    robot: Position,
    /// Offsets from the robot, the nearest first: a few of them decide most rows.
    offsets: Vec<Offset>,
}

impl Others {
    fn new(grid: Grid, robot: Cell, waypoints: &[Cell]) -> Self {
        let mut offsets: Vec<Offset> =
            waypoints.iter().map(|&waypoint| grid.offset(robot, waypoint)).collect();
        offsets.retain(|offset| offset.manhattan() > 0);
        offsets.sort_unstable_by_key(|offset| offset.manhattan());
        Self { robot: grid.position(robot), offsets }
    }

    /// The columns of a row that they leave to the robot.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "held within the row")]
    fn leave(&self, row: u32, columns: u32) -> Range<usize> {
        let north = i64::from(row) - i64::from(self.robot.row);
        // Columns relative to the robot, as a half-open interval.
        let mut start = -i64::from(self.robot.column);
        let mut end = start + i64::from(columns);
        for offset in &self.offsets {
            let (away_north, away_east) = (i64::from(offset.north), i64::from(offset.east));
            // x^2 + y^2 <= (x - east)^2 + (y - north)^2, twice x times `away_east` alone on the left.
            let most = away_north * away_north + away_east * away_east - 2 * north * away_north;
            match away_east.cmp(&0) {
                Ordering::Greater => end = end.min(most.div_euclid(2 * away_east) + 1),
                Ordering::Less => start = start.max(-most.div_euclid(-2 * away_east)),
                Ordering::Equal if most < 0 => end = start,
                Ordering::Equal => {}
            }
            if start >= end {
                return 0..0;
            }
        }
        let column = i64::from(self.robot.column);
        (start + column) as usize..(end + column) as usize
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::terrain::Ground;

    #[test]
    fn every_cell_of_a_path_plans_its_observation() {
        let terrain = Terrain::from_ascii("...", 1.0).unwrap();
        let sensor = Sensor::new(1, 0.005, crate::sensor::Noise::Gaussian).unwrap();
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        let mut planned_precision = PlannedPrecision::nothing(&terrain);
        planned_precision.add_path(&terrain, &sensor, &cells[..2]);
        let at = |distance| crate::evidence::precision_units(sensor.variance(distance));
        assert_eq!(planned_precision.precision(cells[0]), at(0) + at(1));
        assert_eq!(planned_precision.precision(cells[1]), at(1) + at(0));
        assert_eq!(planned_precision.precision(cells[2]), at(1));
    }

    /// A teammate that has planned to enter this cell.
    fn at(waypoint: Cell, sensor: &Sensor, pace: f64) -> TeammatePlan {
        let path = vec![waypoint].into();
        TeammatePlan {
            member: None,
            cell: None,
            path,
            driven_cells: 0.0,
            sensor: Arc::new(sensor.clone()),
            line_of_sight: LineOfSight::everywhere(),
            pace,
        }
    }

    #[test]
    fn a_fast_teammate_has_the_larger_share_and_a_slow_one_what_lies_around_it() {
        let terrain = Terrain::from_ascii("...........", 1.0).unwrap();
        let (own, theirs) =
            (Sensor::default(), Sensor::new(2, 0.05, crate::sensor::Noise::Gaussian).unwrap());
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        let check = |pace: f64, expected: &str| {
            let mut planned = PlannedPrecision::nothing(&terrain);
            planned.plans.push(at(cells[8], &theirs, pace));
            planned.add_shares(&terrain, &own, cells[2]);
            let look = crate::evidence::precision_units(theirs.variance(0));
            let shares: Vec<i64> = cells.iter().map(|&cell| planned.precision(cell)).collect();
            let drawn = shares.iter().map(|&share| if share == look { 'x' } else { '.' });
            assert_eq!(drawn.collect::<String>(), expected);
            assert!(shares.iter().all(|&share| share == 0 || share == look));
        };
        check(1.0, "......xxxxx");
        check(3.0, "....xxxxxxx");
        check(0.25, ".......xxx.");
    }

    #[test]
    fn cells_nearer_to_a_teammate_are_its_share() {
        let terrain = Terrain::from_ascii(".......", 1.0).unwrap();
        let sensor = Sensor::new(1, 0.005, crate::sensor::Noise::Gaussian).unwrap();
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        let check = |robot: usize, waypoints: &[usize], expected: &str| {
            let mut planned_precision = PlannedPrecision::nothing(&terrain);
            for &waypoint in waypoints {
                planned_precision.plans.push(at(cells[waypoint], &sensor, 1.0));
            }
            planned_precision.add_shares(&terrain, &sensor, cells[robot]);
            let observation = crate::evidence::precision_units(sensor.variance(0));
            let shared = cells.iter().map(|&cell| match planned_precision.precision(cell) {
                0 => '.',
                precision => {
                    if precision == observation {
                        'x'
                    } else {
                        '?'
                    }
                }
            });
            assert_eq!(shared.collect::<String>(), expected);
        };
        check(2, &[], ".......");
        check(0, &[6], "....xxx");
        check(3, &[1, 5], "xx...xx");
        check(3, &[6, 6], ".....xx");
        check(3, &[3], ".......");
    }

    proptest! {
        #[test]
        fn shares_are_those_of_every_cell_weighed_alone(
            rows in 1_u32..30, columns in 1_u32..30, robot in any::<prop::sample::Index>(),
            waypoints in prop::collection::vec(any::<prop::sample::Index>(), 0..12),
        ) {
            let grid = Grid::new(rows, columns).unwrap();
            let terrain = Terrain::new(grid, 1.0, vec![Ground::OPEN; grid.cell_count()]).unwrap();
            let sensor = Sensor::new(1, 0.005, crate::sensor::Noise::Gaussian).unwrap();
            let look = crate::evidence::precision_units(sensor.variance(0));
            let cells: Vec<Cell> = grid.cells().collect();
            let (robot, waypoints): (Cell, Vec<Cell>) =
                (*robot.get(&cells), waypoints.iter().map(|waypoint| *waypoint.get(&cells)).collect());
            let mut promised = PlannedPrecision::nothing(&terrain);
            promised.plans.extend(waypoints.iter().map(|&waypoint| at(waypoint, &sensor, 1.0)));
            promised.add_shares(&terrain, &sensor, robot);
            for &cell in &cells {
                let distance = |from| grid.offset(from, cell).euclidean();
                let is_shared = waypoints.iter().any(|&waypoint| distance(waypoint) < distance(robot));
                prop_assert_eq!(promised.precision(cell), if is_shared { look } else { 0 });
            }
        }
    }
}
