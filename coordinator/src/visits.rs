//! Where each robot has observed, in the order of its own clock, and how far it has driven in each cell.

use std::collections::BTreeMap;

use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::{Cell, Grid};
use dragnet_search::observation::RobotId;

/// A robot in a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visit {
    /// By the robot's clock.
    pub time: MissionTime,
    /// The cell.
    pub cell: Cell,
}

/// The visits of all robots, from observations in any order.
#[derive(Clone, Debug, Default)]
pub struct Visits {
    robots: BTreeMap<RobotId, Way>,
}

/// The visits of one robot.
#[derive(Clone, Debug, Default)]
struct Way {
    /// By time.
    visits: Vec<Visit>,
    /// Length of its track in each cell, cells: half of each step counts in the cell where it begins, half where it ends.
    cells: BTreeMap<Cell, f64>,
}

impl Visits {
    /// A robot has observed from a cell. Observations may arrive late.
    pub fn add(&mut self, grid: Grid, robot: RobotId, visit: Visit) {
        let way = self.robots.entry(robot).or_default();
        let at = way.visits.partition_point(|known| known.time <= visit.time);
        let before = at.checked_sub(1).map(|before| way.visits[before].cell);
        let after = way.visits.get(at).map(|after| after.cell);
        way.visits.insert(at, visit);
        if let (Some(before), Some(after)) = (before, after) {
            way.step(grid, before, after, -0.5);
        }
        if let Some(before) = before {
            way.step(grid, before, visit.cell, 0.5);
        }
        if let Some(after) = after {
            way.step(grid, visit.cell, after, 0.5);
        }
    }

    /// The visits of each robot, by time; repeated where it waited.
    pub fn robots(&self) -> impl Iterator<Item = (RobotId, &[Visit])> {
        self.robots.iter().map(|(&robot, way)| (robot, &way.visits[..]))
    }

    /// The length of a robot's track in each cell that it was in, cells.
    pub fn track_cells(&self, robot: RobotId) -> impl Iterator<Item = (Cell, f64)> + '_ {
        self.robots
            .get(&robot)
            .into_iter()
            .flat_map(|way| way.cells.iter().map(|(&cell, &cells)| (cell, cells)))
    }
}

impl Way {
    fn step(&mut self, grid: Grid, from: Cell, to: Cell, share: f64) {
        let length = share * grid.offset(from, to).euclidean();
        for cell in [from, to] {
            let known = self.cells.entry(cell).or_default();
            // Rounding leaves no negative length where a step was taken back.
            *known = (*known + length).max(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::cell::Position;

    use super::*;

    fn visits(order: &[usize]) -> Visits {
        let grid = Grid::new(4, 4).unwrap();
        let track = [(0, 0), (0, 1), (1, 2), (1, 2), (3, 2)];
        let mut visits = Visits::default();
        for &index in order {
            let (row, column) = track[index];
            let cell = grid.cell(Position { row, column }).unwrap();
            let time = MissionTime(index as u64);
            visits.add(grid, RobotId::first(1).next().unwrap(), Visit { time, cell });
        }
        visits
    }

    #[test]
    fn lengths_are_those_of_the_track_in_any_order_of_arrival() {
        let robot = RobotId::first(1).next().unwrap();
        let lengths = |order: &[usize]| -> Vec<f64> {
            let visits = visits(order);
            assert!(visits.robots().all(|(_, way)| way.is_sorted_by_key(|visit| visit.time)));
            visits.track_cells(robot).map(|(_, cells)| cells).collect()
        };
        let diagonal = 2.0_f64.sqrt();
        let expected = [0.5, 0.5 + diagonal / 2.0, diagonal / 2.0 + 1.0, 1.0];
        for order in [[0, 1, 2, 3, 4], [4, 3, 2, 1, 0], [2, 0, 4, 1, 3], [3, 1, 4, 2, 0]] {
            let given = lengths(&order);
            let is_near =
                given.iter().zip(expected).all(|(given, expected)| (given - expected).abs() < 1e-12);
            assert!(given.len() == expected.len() && is_near, "{order:?}: {given:?}");
        }
    }
}
