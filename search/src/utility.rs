//! Utility tables: what an observation of a cell is worth, by its log-odds and precision.
//!
//! Readings of one cell are independent given what it holds, so the worth of any set of observations depends on their
//! summed precision only, and one table of two axes serves every policy. There are two utilities: the information of
//! `information.rs`, and the expected recall of `recall.rs`.

mod information;
mod recall;

use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use crate::situation::Situation;

pub(crate) use recall::{found, log_odds_nats};

/// What observations are worth. The paper takes information "by default, though other utilities (e.g., expected recall)
/// can be substituted".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Utility {
    /// Entropy that they are expected to remove, nats.
    Information,
    /// Objects that they are expected to find.
    Recall,
}

impl Utility {
    /// All utilities.
    pub const ALL: [Self; 2] = [Self::Information, Self::Recall];

    /// The name used in scenarios and on the command line.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Information => "information",
            Self::Recall => "recall",
        }
    }
}

/// The table of a utility, for a policy that decides by it.
pub(crate) struct Tables {
    utility: Utility,
    recall: Option<(f64, Arc<UtilityTable>)>,
}

impl Tables {
    pub(crate) const fn new(utility: Utility) -> Self {
        Self { utility, recall: None }
    }

    /// The table for a situation.
    pub(crate) fn of(&mut self, situation: &Situation<'_>) -> &UtilityTable {
        let threshold = situation.detection_threshold;
        match self.utility {
            Utility::Information => UtilityTable::information(),
            Utility::Recall => {
                let is_of_other = |(of, _): &mut (f64, _)| of.to_bits() != threshold.to_bits();
                self.recall.take_if(is_of_other);
                &self.recall.get_or_insert_with(|| (threshold, UtilityTable::recall(threshold))).1
            }
        }
    }
}

/// `U(L, k)`, the utility of a precision `k` for a cell of log-odds `L`, by bilinear interpolation over `|L|` and `k`.
/// The error is below 1e-4 nat of information, and below 0.01 objects, everywhere.
///
/// Both axes are linear within an octave of `1 + x` and double their step with each, so that index and fraction are
/// the exponent and mantissa of one floating-point number: no logarithm is taken in a lookup.
#[derive(Debug)]
pub struct UtilityTable {
    /// Bilinear coefficients `[constant, k, L, k L]` of each patch, row-major: a row that is all zero, those of positive
    /// log-odds by `|L|`, and those of negative ones, unless they are the same.
    patches: Vec<[f32; 4]>,
    /// How many patches those of negative log-odds are behind those of positive ones.
    negative: u32,
    /// Log-odds from which a cell yields nothing, nats.
    certain_nats: f64,
}

/// Where log-odds fall on the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Index of the row's first patch; 0 for cells that yield nothing.
    start: u32,
    /// `0.0..1.0` within the row.
    fraction: f32,
}

/// Where a precision falls on the table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Column {
    step: u32,
    /// `0.0..1.0` within the step.
    fraction: f32,
}

impl Row {
    const CERTAIN: Self = Self { start: 0, fraction: 0.0 };

    /// Whether observations of the cells of this row have no utility.
    #[must_use]
    pub const fn is_certain(self) -> bool {
        self.start == Self::CERTAIN.start
    }
}

/// From this precision on (units of evidence) a cell is as good as known: more of it adds below 1e-6 nat.
pub const SATURATION: i32 = 127 << 16;

/// A precision of 1, in units of evidence.
const ONE: f32 = 65_536.0;

/// An axis of `octaves` octaves of `1 + x`, each of `2^bits` equal steps.
struct Axis {
    octaves: u32,
    bits: u32,
}

/// `|L|` from 0 to 31, where the entropy is 1e-12 nat.
const LOG_ODDS: Axis = Axis { octaves: 5, bits: 6 };
/// `k` from 0 to 127.
const PRECISION: Axis = Axis { octaves: 7, bits: 5 };

impl Axis {
    const fn steps(&self) -> u32 {
        self.octaves << self.bits
    }

    /// Step and fraction of `base + x base`, where `base` is a power of 2 and `0 <= x < 2^octaves - 1`.
    fn place(&self, shifted: f32, base: f32) -> (u32, f32) {
        let shift = f32::MANTISSA_DIGITS - 1 - self.bits;
        let bits = shifted.to_bits() - base.to_bits();
        let mask = (1 << shift) - 1;
        let fraction = (bits & mask) as f32 / (1_u32 << shift) as f32;
        (bits >> shift, fraction)
    }

    /// Value at the lower end of a step.
    fn value(&self, step: u32) -> f64 {
        let within = f64::from(step & ((1 << self.bits) - 1)) / f64::from(1_u32 << self.bits);
        f64::from(1_u32 << (step >> self.bits)) * (1.0 + within) - 1.0
    }
}

impl UtilityTable {
    /// The table of information, built on first use.
    #[must_use]
    pub fn information() -> &'static Self {
        static TABLE: LazyLock<UtilityTable> = LazyLock::new(UtilityTable::build);
        &TABLE
    }

    /// Builds the table of information, which all decisions share, so that the first one is not measured with it.
    pub fn warm_up() {
        let _ = Self::information();
    }

    /// Builds the table of information by quadrature.
    #[must_use]
    pub fn build() -> Self {
        let certain_nats = LOG_ODDS.value(LOG_ODDS.steps());
        Self { patches: patches(&[information::column]), negative: 0, certain_nats }
    }

    /// The table of expected recall for a detection threshold, a probability above 0.5 and below 1. Robots of one
    /// mission share it: the last one is kept.
    #[must_use]
    pub fn recall(detection_threshold: f64) -> Arc<Self> {
        static LAST: Mutex<Option<(u64, Arc<UtilityTable>)>> = Mutex::new(None);
        let name = detection_threshold.to_bits();
        let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
        match &*last {
            Some((kept, table)) if *kept == name => Arc::clone(table),
            _ => {
                let table = Arc::new(Self::build_recall(detection_threshold));
                *last = Some((name, Arc::clone(&table)));
                table
            }
        }
    }

    fn build_recall(detection_threshold: f64) -> Self {
        let found_nats = recall::log_odds_nats(detection_threshold);
        let column = |sign: f64| move |precision: f64| recall::column(found_nats, sign, precision);
        Self {
            patches: patches(&[column(1.0), column(-1.0)]),
            negative: LOG_ODDS.steps() * PRECISION.steps(),
            certain_nats: found_nats,
        }
    }

    /// The row of log-odds (nats).
    #[must_use]
    pub fn row(&self, log_odds_nats: f64) -> Row {
        #[expect(clippy::cast_possible_truncation, reason = "a position on the axis")]
        let shifted = (1.0 + log_odds_nats.abs()) as f32;
        let is_on_axis = shifted < (1_u32 << LOG_ODDS.octaves) as f32;
        // Written so that NaN, which no belief holds, counts as certain.
        if !(is_on_axis && log_odds_nats < self.certain_nats) {
            return Row::CERTAIN;
        }
        let (step, fraction) = LOG_ODDS.place(shifted, 1.0);
        let sheet = if log_odds_nats < 0.0 { self.negative } else { 0 };
        Row { start: sheet + (1 + step) * PRECISION.steps(), fraction }
    }

    /// Utility of an observation of this total precision (units of evidence, from 0; all above [`SATURATION`] are
    /// equal).
    #[must_use]
    #[inline]
    pub fn utility(&self, row: Row, precision: i32) -> f32 {
        self.at(row, Self::column(precision))
    }

    /// Where a total precision falls on the table (units of evidence, from 0; all above [`SATURATION`] are equal).
    #[must_use]
    #[inline]
    pub(crate) fn column(precision: i32) -> Column {
        let shifted = (precision.min(SATURATION - 1) as f32) + ONE;
        let (step, fraction) = PRECISION.place(shifted, ONE);
        Column { step, fraction }
    }

    /// Utility at a place on the table.
    #[must_use]
    #[inline]
    pub(crate) fn at(&self, row: Row, Column { step, fraction }: Column) -> f32 {
        let [constant, along_k, along_l, across] = self.patches[(row.start + step) as usize];
        constant + fraction * along_k + row.fraction * (along_l + fraction * across)
    }
}

/// The patches of one or two signs, after a row of zeros. `columns` give `U(L, k)` of one precision at every step of the
/// axis of log-odds.
fn patches(columns: &[impl Fn(f64) -> Vec<f64>]) -> Vec<[f32; 4]> {
    let mut patches = vec![[0.0; 4]; PRECISION.steps() as usize];
    for column in columns {
        let columns: Vec<Vec<f64>> =
            (0..=PRECISION.steps()).map(|step| column(PRECISION.value(step))).collect();
        for row in 0..LOG_ODDS.steps() as usize {
            for pair in columns.windows(2) {
                let (low, high) = (&pair[0], &pair[1]);
                let corner = low[row];
                let (along_k, along_l) = (high[row] - corner, low[row + 1] - corner);
                let across = high[row + 1] - corner - along_k - along_l;
                #[expect(clippy::cast_possible_truncation, reason = "f32 holds 1e-7 of a nat")]
                patches.push([corner, along_k, along_l, across].map(|value| value as f32));
            }
        }
    }
    patches
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_certain_cell_yields_nothing() {
        let table = UtilityTable::information();
        for log_odds in [f64::NEG_INFINITY, f64::INFINITY, 31.0, -40.0, f64::NAN] {
            let row = table.row(log_odds);
            assert!(row.is_certain());
            assert!(table.utility(row, SATURATION).abs() < f32::MIN_POSITIVE);
        }
        assert!(!table.row(30.9).is_certain());
        let recall = UtilityTable::recall(0.95);
        for log_odds in [f64::NEG_INFINITY, f64::INFINITY, 2.95, -40.0, f64::NAN] {
            assert!(recall.row(log_odds).is_certain(), "{log_odds}");
        }
        assert!(!recall.row(2.94).is_certain() && !recall.row(-30.9).is_certain());
    }
}
