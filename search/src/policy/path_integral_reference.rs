//! A reference implementation of [`Path`](super::path): every candidate's path is traversed and summed separately.
//!
//! The same scores as `path`, up to rounding, at the cost that its single traversal avoids. It is the reference of
//! tests and benchmarks; no scenario can name it.

use super::{Decision, Policy, path_length_weight};
use crate::cell::Cell;
use crate::seed::Stream;
use crate::situation::Situation;
use crate::utility::{Row, UtilityTable};
use crate::utility_gain::saturated;

/// `path` as Eq. 3 and 4 of the paper define it: candidates share nothing but the tree of paths, the table, and each
/// cell's row in it.
#[derive(Clone, Copy, Debug)]
pub struct PathIntegralReference {
    path_length_weight: f64,
}

impl PathIntegralReference {
    /// A policy with this `w_l` of the path-length weight (Eq. 4), at least 0.
    #[must_use]
    pub const fn new(path_length_weight: f64) -> Self {
        Self { path_length_weight }
    }
}

impl Policy for PathIntegralReference {
    fn decide(&mut self, situation: &Situation<'_>, _: &mut Stream) -> Decision {
        let routes = situation.routes();
        let mut sum = PathSum::new(situation);
        let mut scores = vec![f64::NEG_INFINITY; situation.terrain.grid().cell_count()];
        for &cell in routes.candidates() {
            let weight = path_length_weight(self.path_length_weight, routes.length(cell));
            scores[cell.index()] = weight * sum.of(&routes.path(cell));
        }
        Decision::most_informative(&routes, scores)
    }
}

struct PathSum<'a> {
    situation: &'a Situation<'a>,
    /// Shape `[cells]`.
    rows: Vec<Row>,
    /// Precision that the current path adds to each cell, units of evidence, shape `[cells]`.
    added: Vec<i64>,
    /// Cells that the current path observes.
    seen: Vec<Cell>,
}

impl<'a> PathSum<'a> {
    fn new(situation: &'a Situation<'a>) -> Self {
        let grid = situation.terrain.grid();
        let table = UtilityTable::information();
        let rows = grid.cells().map(|cell| table.row(situation.belief.log_odds_nats(cell))).collect();
        Self { situation, rows, added: vec![0; grid.cell_count()], seen: Vec::new() }
    }

    /// Information of observations from all cells of a path, nats.
    fn of(&mut self, path: &[Cell]) -> f64 {
        for &from in path {
            self.observation(from);
        }
        let mut sum = 0.0;
        for cell in self.seen.drain(..) {
            let planned_precision = self.situation.planned_precision.precision(cell);
            let added = std::mem::take(&mut self.added[cell.index()]);
            let row = self.rows[cell.index()];
            sum += information(row, planned_precision + added) - information(row, planned_precision);
        }
        sum
    }

    fn observation(&mut self, from: Cell) {
        for (cell, observation) in self.situation.terrain.in_sight(self.situation.sensor, from) {
            let added = &mut self.added[cell.index()];
            if *added == 0 {
                self.seen.push(cell);
            }
            *added += observation.precision;
        }
    }
}

fn information(row: Row, precision: i64) -> f64 {
    f64::from(UtilityTable::information().utility(row, saturated(precision)))
}
