//! What is odd about a scenario, and can still be run.

use std::collections::VecDeque;
use std::fmt;

use dragnet_search::cell::{Cell, Offset, Position};
use dragnet_search::observation::RobotId;
use dragnet_search::route::Routes;
use dragnet_search::terrain::Terrain;

use super::{Scenario, Start};

/// What is odd about a scenario, and can still be run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Warning {
    /// Searched cells that no robot sees from any cell that it reaches: objects there are never found.
    Unseen {
        /// How many.
        cells: usize,
        /// Of so many searched cells.
        searched: usize,
        /// Where the first one is.
        first: Position,
    },
    /// Two robots start in areas that no path connects.
    Apart {
        /// The robot with the smallest number.
        robot: RobotId,
        /// The first one that it cannot reach.
        other: RobotId,
    },
    /// Something that is drawn in a file and means nothing to the search.
    LeftOut {
        /// Its name, or where it stands.
        name: String,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unseen { cells, searched, first: Position { row, column } } => write!(
                formatter,
                "{cells} of {searched} searched cells are out of every robot's sight, the first one [{row}, {column}]"
            ),
            Self::Apart { robot, other } => {
                write!(formatter, "robots {robot} and {other} start in areas that no path connects")
            }
            Self::LeftOut { name } => write!(formatter, "left out: {}, no area of ours", name.escape_debug()),
        }
    }
}

impl Scenario {
    /// What is odd about it, and can still be run.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let mut reached = vec![false; self.terrain().grid().cell_count()];
        let mut apart = None;
        for robot in self.robots() {
            let Some(start) = some_start(self.terrain(), robot.start) else { continue };
            if reached[start.index()] {
                continue;
            }
            if robot.id != self.robots()[0].id && apart.is_none() {
                apart = Some(Warning::Apart { robot: self.robots()[0].id, other: robot.id });
            }
            for cell in Routes::from(self.terrain(), self.moves(), start).reached() {
                reached[cell.index()] = true;
            }
        }
        let left_out = self.areas().left_out.into_iter().map(|name| Warning::LeftOut { name });
        self.unseen(&reached).into_iter().chain(apart).chain(left_out).collect()
    }

    fn unseen(&self, reached: &[bool]) -> Option<Warning> {
        let terrain = self.terrain();
        let is_seen = within(terrain, reached, self.sensor().radius());
        let unseen: Vec<Cell> = terrain.searched_cells().filter(|cell| !is_seen[cell.index()]).collect();
        let first = terrain.grid().position(*unseen.first()?);
        Some(Warning::Unseen { cells: unseen.len(), searched: terrain.searched_cells().count(), first })
    }
}

/// A cell of the area that a robot starts in; all of them reach the same.
fn some_start(terrain: &Terrain, start: Start) -> Option<Cell> {
    match start {
        Start::Cell(cell) => Some(cell),
        Start::Together | Start::Scattered => terrain.largest_area().first().copied(),
    }
}

/// Cells within a Manhattan radius of marked ones, breadth first.
fn within(terrain: &Terrain, marked: &[bool], radius: u32) -> Vec<bool> {
    let grid = terrain.grid();
    let mut is_near = marked.to_vec();
    let mut queue: VecDeque<(Cell, u32)> =
        grid.cells().filter(|cell| marked[cell.index()]).map(|cell| (cell, 0)).collect();
    while let Some((cell, distance)) = queue.pop_front() {
        if distance == radius {
            continue;
        }
        for (north, east) in [(-1, 0), (0, -1), (0, 1), (1, 0)] {
            if let Some(next) = grid.step(cell, Offset { north, east })
                && !std::mem::replace(&mut is_near[next.index()], true)
            {
                queue.push_back((next, distance + 1));
            }
        }
    }
    is_near
}
