//! Marks: evidence that people give beside the readings of robots.
//!
//! A clue speaks for an object near it. Let the clue be `r` times as likely if an object is where it lies as if there is none,
//! and let it lie from its object by a normal error of `s` cells a direction. Then for an object in distance `d` it is
//!
//! ```text
//! L(d) = 1 + (r - 1) exp(-d^2 / (2 s^2))
//! ```
//!
//! times as likely as without an object: `r` at the clue, 1 far from it. A search of others with the probability of detection
//! `POD` that found nothing is `1 - POD` times as likely if an object is there. Both are likelihood ratios, so their
//! logarithm is added to the log-odds of the cell, and subtracted when the mark is withdrawn.
//!
//! Source: B. O. Koopman, "Search and Screening" (1946), for the search without success; the form of `L` is ours.
//! All numbers of a mark are integers: everybody computes the same evidence, to the bit.

use std::collections::BTreeSet;

use crate::cell::{Cell, Grid, Position};
use crate::evidence::{CellEvidence, UNITS};

/// Beyond this multiple of its radius a clue of the greatest ratio says less than a unit of evidence.
const REACH_RADII: f64 = 6.0;

/// What an operator marks.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Mark {
    /// Something that speaks for an object near it.
    Clue(Clue),
    /// Cells that others have searched without a find.
    Searched(Searched),
}

/// A clue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Clue {
    /// Where it lies.
    pub cell: Cell,
    /// `r`, thousandths: see [`Clue::RATIO_THOUSANDTHS`].
    pub ratio_thousandths: u32,
    /// `s`, hundredths of a cell: see [`Clue::MAX_RADIUS_HUNDREDTHS`]. At 0 it speaks for its own cell alone.
    pub radius_hundredths: u32,
}

/// A search of others without a find.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Searched {
    /// The cells, at least one.
    pub cells: BTreeSet<Cell>,
    /// Its probability of detection, thousandths: see [`Searched::POD_THOUSANDTHS`].
    pub pod_thousandths: u16,
}

impl Clue {
    /// Allowed ratios, thousandths: 1.001 to 1000.
    pub const RATIO_THOUSANDTHS: std::ops::RangeInclusive<u32> = 1001..=1_000_000;
    /// The greatest radius, hundredths of a cell: 100 cells.
    pub const MAX_RADIUS_HUNDREDTHS: u32 = 10_000;

    /// `r`.
    #[must_use]
    pub fn ratio(self) -> f64 {
        f64::from(self.ratio_thousandths) / 1000.0
    }

    /// `s`, cells.
    #[must_use]
    pub fn radius_cells(self) -> f64 {
        f64::from(self.radius_hundredths) / 100.0
    }

    /// What it adds to the log-odds of a cell in this distance, units.
    fn units(self, squared_cells: f64) -> i64 {
        let radius_cells = self.radius_cells();
        let nearness = match self.radius_hundredths {
            0 => f64::from(u8::from(squared_cells <= 0.0)),
            _ => libm::exp(-squared_cells / (2.0 * radius_cells * radius_cells)),
        };
        units(libm::log1p((self.ratio() - 1.0) * nearness))
    }
}

impl Searched {
    /// Allowed probabilities of detection, thousandths: 0.001 to 0.999.
    pub const POD_THOUSANDTHS: std::ops::RangeInclusive<u16> = 1..=999;

    /// Its probability of detection.
    #[must_use]
    pub fn probability_of_detection(&self) -> f64 {
        f64::from(self.pod_thousandths) / 1000.0
    }
}

impl Mark {
    /// What it adds to the log-odds of cells, without those to which it adds nothing; each cell once.
    #[must_use]
    pub fn evidence(&self, grid: Grid) -> Vec<(Cell, CellEvidence)> {
        let of = |weighted_sum| CellEvidence { precision: 0, weighted_sum };
        match self {
            Self::Searched(search) => {
                let fall = units(libm::log1p(-search.probability_of_detection()));
                search.cells.iter().map(|&cell| (cell, of(fall))).collect()
            }
            Self::Clue(clue) => {
                let near = near(grid, clue.cell, REACH_RADII * clue.radius_cells());
                let rise = |(cell, squared_cells)| (cell, of(clue.units(squared_cells)));
                near.map(rise).filter(|(_, rise)| rise.weighted_sum != 0).collect()
            }
        }
    }

    /// Number of its cells: 1 of a clue.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        match self {
            Self::Searched(search) => search.cells.len(),
            Self::Clue(_) => 1,
        }
    }
}

/// The cells in a square around a cell, with their squared distances from it in cells.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 600 cells")]
fn near(grid: Grid, center: Cell, reach_cells: f64) -> impl Iterator<Item = (Cell, f64)> {
    let (reach, Position { row, column }) = (reach_cells.ceil() as u32, grid.position(center));
    let around = |at: u32, count: u32| at.saturating_sub(reach)..(at + reach + 1).min(count);
    let columns = around(column, grid.columns());
    let positions = around(row, grid.rows())
        .flat_map(move |row| columns.clone().map(move |column| Position { row, column }));
    positions.filter_map(move |at| {
        let [north, east] = [at.row.abs_diff(row), at.column.abs_diff(column)].map(f64::from);
        grid.cell(at).map(|cell| (cell, north * north + east * east))
    })
}

#[expect(clippy::cast_possible_truncation, reason = "at most ln(1000) nats")]
fn units(nats: f64) -> i64 {
    (nats * UNITS).round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belief::Belief;
    use crate::terrain::Terrain;

    fn field() -> (Terrain, Belief) {
        let terrain = Terrain::from_ascii(&vec![".".repeat(21); 21].join("\n"), 1.0).unwrap();
        let belief = Belief::uniform(&terrain, 0.1).unwrap();
        (terrain, belief)
    }

    fn at(grid: Grid, row: u32, column: u32) -> Cell {
        grid.cell(Position { row, column }).unwrap()
    }

    fn odds(belief: &Belief, cell: Cell) -> f64 {
        belief.log_odds_nats(cell).exp()
    }

    fn marked(terrain: &Terrain, belief: &Belief, mark: &Mark) -> Belief {
        let mut belief = belief.clone();
        for (cell, evidence) in mark.evidence(terrain.grid()) {
            belief.add_evidence(cell, evidence);
        }
        belief
    }

    #[test]
    fn a_clue_multiplies_the_odds_by_its_ratio_and_less_the_farther_away() {
        let (terrain, before) = field();
        let grid = terrain.grid();
        let clue = |radius_hundredths| {
            Mark::Clue(Clue { cell: at(grid, 10, 10), ratio_thousandths: 20_000, radius_hundredths })
        };
        let times = |belief: &Belief, cell| odds(belief, cell) / odds(&before, cell);
        let wide = marked(&terrain, &before, &clue(200));
        for (cell, expected) in [
            (at(grid, 10, 10), 20.0),
            (at(grid, 12, 10), 1.0 + 19.0 * (-0.5_f64).exp()),
            (at(grid, 13, 14), 1.0 + 19.0 * (-25.0_f64 / 8.0).exp()),
            (at(grid, 0, 0), 1.0),
        ] {
            assert!((times(&wide, cell) / expected - 1.0).abs() < 1e-4, "{expected}: {}", times(&wide, cell));
        }
        assert_eq!(clue(0).evidence(grid).len(), 1, "its own cell alone");
        assert!(clue(Clue::MAX_RADIUS_HUNDREDTHS).evidence(grid).len() == grid.cell_count());
    }

    #[test]
    fn beyond_its_reach_a_clue_adds_nothing() {
        let clue = Clue {
            cell: at(field().0.grid(), 0, 0),
            ratio_thousandths: *Clue::RATIO_THOUSANDTHS.end(),
            radius_hundredths: 100,
        };
        assert_eq!(clue.units((REACH_RADII + 1.0).powi(2)), 0);
    }

    #[test]
    fn a_search_of_others_leaves_what_it_may_have_missed() {
        let (terrain, before) = field();
        let cells = BTreeSet::from([1, 2].map(|column| at(terrain.grid(), 1, column)));
        let search = Searched { cells: cells.clone(), pod_thousandths: 800 };
        assert!((search.probability_of_detection() - 0.8).abs() < 1e-12);
        let after = marked(&terrain, &before, &Mark::Searched(search));
        for cell in terrain.grid().cells() {
            let expected = if cells.contains(&cell) { 0.2 } else { 1.0 };
            let times = odds(&after, cell) / odds(&before, cell);
            assert!((times - expected).abs() < 1e-4, "{cell:?} {times}");
        }
    }
}
