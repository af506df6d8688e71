//! `path` by its definition: every candidate's path walked and summed anew. What the policy is measured against.

use dragnet_search::cell::Cell;
use dragnet_search::information::{InformationTable, Row, SATURATION};
use dragnet_search::policy::Parameters;
use dragnet_search::route::Routes;
use dragnet_search::situation::Situation;

/// Scores of all cells, as `path` gives them: nothing is shared between candidates but the tree of paths, the table,
/// and where each cell falls on it.
pub(crate) fn path_scores(situation: &Situation<'_>) -> Vec<f64> {
    let routes = Routes::from(situation.terrain, situation.moves, situation.robot);
    let mut sum = PathSum::new(situation);
    let mut scores = vec![f64::NEG_INFINITY; situation.terrain.grid().cell_count()];
    let length_weight = Parameters::default().length_weight;
    for &cell in routes.candidates() {
        let weight = 1.0 / (1.0 + length_weight * f64::from(routes.length(cell)));
        scores[cell.index()] = weight * sum.of(&routes.path(cell));
    }
    scores
}

struct PathSum<'a> {
    situation: &'a Situation<'a>,
    rows: Vec<Row>,
    /// What the path under way adds to the precision of each cell, units of evidence, shape `[cells]`.
    added: Vec<i64>,
    /// Cells that the path under way sees.
    seen: Vec<Cell>,
}

impl<'a> PathSum<'a> {
    fn new(situation: &'a Situation<'a>) -> Self {
        let grid = situation.terrain.grid();
        let table = InformationTable::shared();
        let rows = grid.cells().map(|cell| table.row(situation.belief.log_odds_nats(cell))).collect();
        Self { situation, rows, added: vec![0; grid.cell_count()], seen: Vec::new() }
    }

    /// Information of looks from all cells of a path, nats.
    fn of(&mut self, path: &[Cell]) -> f64 {
        for &from in path {
            self.look(from);
        }
        let mut sum = 0.0;
        for cell in self.seen.drain(..) {
            let promised = self.situation.promised.precision(cell);
            let added = std::mem::take(&mut self.added[cell.index()]);
            let row = self.rows[cell.index()];
            sum += information(row, promised + added) - information(row, promised);
        }
        sum
    }

    fn look(&mut self, from: Cell) {
        for look in self.situation.sensor.footprint() {
            if let Some(cell) = self.situation.terrain.grid().step(from, look.offset) {
                let added = &mut self.added[cell.index()];
                if *added == 0 {
                    self.seen.push(cell);
                }
                *added += look.precision;
            }
        }
    }
}

fn information(row: Row, precision: i64) -> f64 {
    let precision = i32::try_from(precision.min(i64::from(SATURATION))).unwrap();
    f64::from(InformationTable::shared().information(row, precision))
}
