//! What a cell still hides from a search, by its log-odds and the precision that is planned for it.

use crate::situation::Situation;
use crate::utility::{found, log_odds_nats as log_odds_of};
use crate::utility_gain::Frame;

/// Log-odds of the axis of rows, nats; a belief outside counts as at its end. At the lower end a cell in 3e10 holds an
/// object.
const LOWEST_NATS: f64 = -24.0;
const HIGHEST_NATS: f64 = 6.0;
const ROWS_PER_NAT: f64 = 4.0;
const ROWS: usize = 121;
/// Precision of the axis of columns, from 0.
const COLUMNS: usize = u8::MAX as usize + 1;
/// Steps of precision in 1, the precision of a reading of variance 1. At the end of the axis, 127.5, an object in any
/// cell of the table is found almost surely.
const STEPS_PER_PRECISION: f64 = 2.0;
/// Log-odds that a first observation of a cell must raise it to, nats: the tour is planned anew then.
const NOTICED_NATS: f64 = 1.0;
/// Below this much a cell hides nothing.
const NOTHING: f32 = 1e-9;

/// A row of the table: where it starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Row(u32);

/// `S(L, k) = -ln(1 - p (1 - F))`, with `p` the cell's probability and `F` the probability that an object in it is
/// found by a further precision `k`.
///
/// Readings of precision `k` in total add `N(+k/2, k)` to the log-odds `L` of a cell with an object, so `F(L, k) =
/// Phi((L + k/2 - theta) / sqrt k)`. `theta` is the detection threshold for cells that are suspected already, and
/// [`NOTICED_NATS`] for others. `exp(-sum S)` is the probability that no object is left, if cells are independent.
#[derive(Clone, Debug)]
pub(super) struct HiddenTable {
    detection_threshold: f64,
    values: Vec<f32>,
}

impl HiddenTable {
    /// The table for a detection threshold, a probability.
    pub(super) fn new(detection_threshold: f64) -> Self {
        let found_nats = log_odds_of(detection_threshold).clamp(LOWEST_NATS, HIGHEST_NATS);
        let mut values = Vec::with_capacity((2 * ROWS + 1) * COLUMNS);
        for theta in [found_nats, NOTICED_NATS.min(found_nats)] {
            for row in 0..ROWS {
                let log_odds_nats = LOWEST_NATS + row as f64 / ROWS_PER_NAT;
                let probability = 1.0 / (1.0 + libm::exp(-log_odds_nats));
                for column in 0..COLUMNS {
                    let found = found(log_odds_nats, column as f64 / STEPS_PER_PRECISION, theta);
                    let hidden = -libm::log1p(-(probability * (1.0 - found)).min(1.0 - 1e-6));
                    #[expect(clippy::cast_possible_truncation, reason = "the planner's values are f32")]
                    values.push(hidden as f32);
                }
            }
        }
        values.resize(values.len() + COLUMNS, 0.0);
        Self { detection_threshold, values }
    }

    /// The table for a detection threshold: the one that is kept, if it is, or else a new one, which is kept.
    pub(super) fn kept_for(kept: &mut Option<Self>, detection_threshold: f64) -> &Self {
        let known = kept.take().filter(|table| table.serves(detection_threshold));
        kept.insert(known.unwrap_or_else(|| Self::new(detection_threshold)))
    }

    /// Whether it is for this detection threshold.
    const fn serves(&self, detection_threshold: f64) -> bool {
        self.detection_threshold.to_bits() == detection_threshold.to_bits()
    }

    /// The row of cells that hide nothing.
    #[expect(clippy::cast_possible_truncation, reason = "the table is small")]
    pub(super) const NOTHING: Row = Row((2 * ROWS * COLUMNS) as u32);

    /// The row of log-odds (nats).
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a position in the table")]
    pub(super) fn row(&self, log_odds_nats: f64) -> Row {
        let clamped = log_odds_nats.clamp(LOWEST_NATS, HIGHEST_NATS);
        let row = ((clamped - LOWEST_NATS) * ROWS_PER_NAT).round() as usize;
        let sheet = usize::from(log_odds_nats < NOTICED_NATS);
        let start = (sheet * ROWS + row) * COLUMNS;
        if self.values[start] < NOTHING { Self::NOTHING } else { Row(start as u32) }
    }

    /// What a cell hides after this precision, in steps of [`steps`].
    #[inline]
    pub(super) fn hidden(&self, row: Row, precision: u8) -> f32 {
        self.values[row.0 as usize + precision as usize]
    }
}

/// Precision (units of evidence, 1/65,536) in steps of the table.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
pub(super) fn steps(precision_units: i64) -> u8 {
    let steps = precision_units as f64 / crate::evidence::UNITS * STEPS_PER_PRECISION;
    steps.round().clamp(0.0, f64::from(u8::MAX)) as u8
}

/// What the cells of a map hide, as `tour` counts it: for policies that learn from it. It keeps its table.
#[derive(Clone, Debug, Default)]
pub struct HiddenMass(Option<HiddenTable>);

/// What cells hide, and how much less after one observation from a cell, shape `[cells]` each.
#[derive(Clone, Debug)]
pub struct Hidden {
    /// `S` of each cell.
    pub mass: Vec<f32>,
    /// What an observation from each cell would take from the sum over all cells.
    pub gain: Vec<f32>,
}

impl HiddenMass {
    /// In a situation, beyond what teammates plan to observe.
    #[must_use]
    pub fn of(&mut self, situation: &Situation<'_>) -> Hidden {
        let table = HiddenTable::kept_for(&mut self.0, situation.detection_threshold);
        let grid = situation.terrain.grid();
        let frame = Frame::new(grid, situation.sensor.radius());
        let mut cells = vec![(HiddenTable::NOTHING, 0_u8); frame.cell_count()];
        let mut mass = vec![0.0; grid.cell_count()];
        for cell in situation.terrain.searched_cells() {
            let row = table.row(situation.belief.log_odds_nats(cell));
            let planned = steps(situation.planned_precision.precision(cell));
            cells[frame.index(cell)] = (row, planned);
            mass[cell.index()] = table.hidden(row, planned);
        }
        let gain = frame.sum_over_footprints(situation, &cells, |&(row, planned), precision| {
            table.hidden(row, planned) - table.hidden(row, planned.saturating_add(steps(precision)))
        });
        Hidden { mass, gain }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_hides_less_the_better_it_is_seen_and_nothing_once_found() {
        let table = HiddenTable::new(0.95);
        for nats in [-12.0, -4.6, 0.5] {
            let row = table.row(nats);
            let hidden: Vec<f32> = (0..=u8::MAX).map(|precision| table.hidden(row, precision)).collect();
            assert!(hidden.windows(2).all(|pair| pair[1] <= pair[0]), "{nats}");
            let probability = 1.0 / (1.0 + (-nats).exp());
            assert!((f64::from(hidden[0]) + (-probability).ln_1p()).abs() < 0.2 * probability, "{nats}");
            assert!(hidden[255] < 1e-6, "{nats}");
        }
        assert!(table.hidden(table.row(3.5), 0) < NOTHING);
        assert_eq!(table.row(f64::NEG_INFINITY), HiddenTable::NOTHING);
    }

    #[test]
    fn precision_is_counted_in_halves_and_saturates() {
        assert_eq!(steps(0), 0);
        assert_eq!(steps(65_536), 2);
        assert_eq!(steps(8 * 65_536), 16);
        assert_eq!(steps(i64::MAX), u8::MAX);
    }
}
