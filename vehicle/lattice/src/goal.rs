//! The goal states of a plan.

use dragnet_search::cell::{Cell, Grid, Position};

use super::costmap::CostMap;
use super::layers::Layers;
use super::metric::Metric;
use super::motions::Motions;

/// The goal states: the goal's cell, and those whose centers are within the tolerance.
#[derive(Clone, Debug)]
pub(super) struct GoalStates {
    cell: Position,
    /// The goal in cells, east and north of the center of cell (0, 0).
    east_north_cells: (f64, f64),
    tolerance_cells: f64,
    heading: Option<u8>,
}

impl GoalStates {
    pub(super) fn new(
        map: &CostMap,
        cell: Cell,
        position_meters: (f64, f64),
        tolerance_meters: f64,
        heading: Option<u8>,
    ) -> Self {
        let at = map.grid().position(cell);
        let center = map.center_meters(cell);
        let cells = |meters: f64| meters / map.resolution_meters();
        Self {
            cell: at,
            east_north_cells: (
                f64::from(at.column) + cells(position_meters.0 - center.0),
                f64::from(at.row) + cells(position_meters.1 - center.1),
            ),
            tolerance_cells: cells(tolerance_meters),
            heading,
        }
    }

    pub(super) const fn cell(&self) -> Position {
        self.cell
    }

    fn is_near(&self, at: Position) -> bool {
        let (east, north) = self.east_north_cells;
        at == self.cell
            || (f64::from(at.column) - east).hypot(f64::from(at.row) - north) <= self.tolerance_cells
    }

    #[inline]
    pub(super) fn contains(&self, at: Position, heading: u8) -> bool {
        self.heading.is_none_or(|goal| goal == heading) && self.is_near(at)
    }

    /// Goal cells, by index, over which a motion can lead.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a cast saturates, and a map ends"
    )]
    pub(super) fn open_cells(&self, grid: Grid, layers: &Layers) -> Vec<Position> {
        let around = |center: f64, own: u32, count: u32| {
            let first = (center - self.tolerance_cells).floor().max(0.0) as u32;
            let last = (center + self.tolerance_cells).ceil().max(0.0) as u32;
            first.min(own)..=last.max(own).min(count - 1)
        };
        let (east, north) = self.east_north_cells;
        let mut cells = Vec::new();
        for row in around(north, self.cell.row, grid.rows()) {
            for column in around(east, self.cell.column, grid.columns()) {
                let at = Position { row, column };
                if self.is_near(at) && !layers.is_blocked(row as usize, column as usize) {
                    cells.push(at);
                }
            }
        }
        cells
    }

    /// Whether the vehicle can stand in one of these cells with the goal's heading.
    pub(super) fn has_room(&self, cells: &[Position], layers: &Layers, motions: &Motions) -> bool {
        let headings = match self.heading {
            Some(heading) => usize::from(heading)..usize::from(heading) + 1,
            None => 0..motions.heading_count(),
        };
        cells.iter().any(|&at| headings.clone().any(|heading| layers.is_free(at, motions.standing(heading))))
    }

    /// Distance over free ground to the farthest of these cells, in units.
    pub(super) fn tolerance_units(&self, cells: &[Position], metric: Metric) -> u64 {
        let distance = |at: &Position| {
            let east = at.column.cast_signed() - self.cell.column.cast_signed();
            metric.cost(east, at.row.cast_signed() - self.cell.row.cast_signed())
        };
        cells.iter().map(distance).max().unwrap_or(0)
    }
}
