//! What has changed since something was computed from a belief, so that only that is computed again.

use dragnet_search::belief::{Belief, entropy_nats};
use dragnet_search::cell::{Cell, Grid};

/// Cells whose belief has changed, each once.
#[derive(Clone, Debug)]
pub(crate) struct ChangedCells {
    cells: Vec<Cell>,
    /// Whether a cell is one of them, shape `[cells]`.
    is_changed: Vec<bool>,
}

impl ChangedCells {
    pub(crate) fn new(grid: Grid) -> Self {
        Self { cells: Vec::new(), is_changed: vec![false; grid.cell_count()] }
    }

    pub(crate) fn extend(&mut self, cells: impl IntoIterator<Item = Cell>) {
        for cell in cells {
            if !std::mem::replace(&mut self.is_changed[cell.index()], true) {
                self.cells.push(cell);
            }
        }
    }

    pub(crate) fn cells(&self) -> &[Cell] {
        &self.cells
    }

    pub(crate) fn clear(&mut self) {
        for cell in self.cells.drain(..) {
            self.is_changed[cell.index()] = false;
        }
    }
}

/// Entropy of each cell when it was last asked for, nats, shape `[cells]`.
#[derive(Clone, Debug)]
pub(crate) struct Entropies(Vec<f64>);

impl Entropies {
    pub(crate) fn of(grid: Grid, belief: &Belief) -> Self {
        Self(grid.cells().map(|cell| entropy_nats(belief.log_odds_nats(cell))).collect())
    }

    /// Entropy that these cells have lost since, nats; a repeated cell counts once.
    pub(crate) fn removed(&mut self, belief: &Belief, cells: impl IntoIterator<Item = Cell>) -> f64 {
        let mut removed = 0.0;
        for cell in cells {
            let entropy = &mut self.0[cell.index()];
            let now = entropy_nats(belief.log_odds_nats(cell));
            removed += *entropy - now;
            *entropy = now;
        }
        removed
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::evidence::CellEvidence;
    use dragnet_search::terrain::Terrain;

    use super::*;

    #[test]
    fn a_cell_is_changed_once_however_often_it_changes() {
        let terrain = Terrain::from_ascii("..\n..\n", 1.0).unwrap();
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        let mut changed = ChangedCells::new(terrain.grid());
        for _ in 0..2 {
            changed.extend([cells[3], cells[1], cells[3]]);
            changed.extend([cells[1], cells[0]]);
            assert_eq!(changed.cells(), [cells[3], cells[1], cells[0]]);
            changed.clear();
            assert_eq!(changed.cells(), []);
        }
    }

    #[test]
    fn the_entropy_of_a_repeated_cell_is_removed_once() {
        let terrain = Terrain::from_ascii("..\n", 1.0).unwrap();
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        let mut belief = Belief::uniform(&terrain, 0.3).unwrap();
        let mut entropies = Entropies::of(terrain.grid(), &belief);
        let before = belief.entropy_nats(&terrain);
        belief.add_evidence(cells[1], CellEvidence { precision: 1 << 24, weighted_sum: 0 });
        let removed = entropies.removed(&belief, [cells[1], cells[1]]);
        assert!((removed - (before - belief.entropy_nats(&terrain))).abs() < 1e-12);
        assert!(removed.abs() > 1e-9);
    }
}
