//! Evidence: two integers per cell, from which every policy computes.
//!
//! `precision = sum 1/v` and `weighted_sum = sum y/v` over all readings of a cell, in units of 1/65,536, each reading
//! quantized once from its `f32` values. Sums of integers commute exactly, so robots with the same observations have
//! bit-for-bit the same evidence, independently of the order, delay and route of messages.

use std::fmt;

use xxhash_rust::xxh3::Xxh3;

use crate::cell::Cell;

/// Units of evidence that represent the number 1.
pub const UNITS: f64 = 65_536.0;
/// The least variance of a reading.
pub const MIN_VARIANCE: f32 = 1e-6;
/// The greatest variance of a reading.
pub const MAX_VARIANCE: f32 = 1e4;
/// The greatest absolute value of a reading: an object reads 1, an empty cell 0.
pub const MAX_VALUE: f32 = 1e3;

/// Number of cells that are hashed in one call, for speed; the hash is the same.
const HASHED_AT_ONCE: usize = 64;
/// The value halfway between an empty cell (0) and an object (1).
const UNDECIDED: f32 = 0.5;

/// A measurement of one cell: `value = theta + N(0, variance)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// The measured cell.
    pub cell: Cell,
    /// `-MAX_VALUE..=MAX_VALUE`.
    pub value: f32,
    /// `MIN_VARIANCE..=MAX_VARIANCE`.
    pub variance: f32,
}

impl Reading {
    /// A reading that favors neither an object nor an empty cell, for a cell that a detection may belong to instead of
    /// a neighbor. Robots plan and end their searches as if an object were there, until it is seen to be empty.
    #[must_use]
    pub const fn undecided(cell: Cell) -> Self {
        Self { cell, value: UNDECIDED, variance: MAX_VARIANCE }
    }

    /// A reading of 0 or 1 with this evidence, nats: `|2 y - 1| / (2 v)`.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "readings have single precision")]
    pub fn with_nats(cell: Cell, value: f32, nats: f64) -> Self {
        Self { cell, value, variance: (1.0 / (2.0 * nats)) as f32 }
    }

    /// Whether the reading is undecided.
    #[must_use]
    pub fn is_undecided(&self) -> bool {
        self.value.to_bits() == UNDECIDED.to_bits()
    }

    /// The reading as radios carry it: its value rounded to a whole number of steps ([`value_step`]), which adds at most
    /// 0.6 % to its variance. Rounded once, where it is taken, it is the same reading for all. An undecided one stays so,
    /// and no other becomes one.
    #[must_use]
    pub fn rounded(self) -> Self {
        if self.is_undecided() {
            return self;
        }
        let step = value_step(self.variance);
        // Not -0: equal readings have equal bits.
        let mut value = (self.value / step).round() * step + 0.0;
        if value.to_bits() == UNDECIDED.to_bits() {
            value += step.copysign(self.value - UNDECIDED);
        }
        let value = if value.abs() > MAX_VALUE { (self.value / step).trunc() * step } else { value };
        Self { value, ..self }
    }

    /// Whether value and variance are finite and in range. One reading then adds less than 2^46 units, so that no
    /// sum saturates within the first 100,000 of even the most extreme readings of a cell.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.value.abs() <= MAX_VALUE && (MIN_VARIANCE..=MAX_VARIANCE).contains(&self.variance)
    }

    /// The reading as evidence of its cell.
    #[must_use]
    pub fn evidence(&self) -> CellEvidence {
        self.evidence_of(precision_units(self.variance))
    }

    /// Like [`Reading::evidence`], with the precision `1 / variance` (units of evidence) already computed.
    #[must_use]
    #[inline]
    pub fn evidence_of(&self, precision: i64) -> CellEvidence {
        debug_assert_eq!(precision, precision_units(self.variance));
        let weighted_sum = whole_units(f64::from(self.value) * UNITS / f64::from(self.variance));
        CellEvidence { precision, weighted_sum }
    }
}

/// The step to which radios round values of a variance: a power of two between 1/8 and 1/4 of the standard deviation, so
/// that steps are exact.
#[must_use]
pub fn value_step(variance: f32) -> f32 {
    const BIAS: u32 = 127;
    // floor(log2 variance) + BIAS, for any bits.
    let exponent = (variance.to_bits() >> 23) & 0xFF;
    // Half of it is that of the standard deviation; BIAS + 1 is even.
    let halved = u32::midpoint(exponent, BIAS);
    f32::from_bits((halved - 2) << 23)
}

/// `1 / variance` in units.
#[must_use]
pub fn precision_units(variance: f32) -> i64 {
    whole_units(UNITS / f64::from(variance))
}

/// The nearest integer, halves away from zero: `units.round() as i64`, without the call that processors before SSE 4.1 need.
#[expect(clippy::cast_possible_truncation, reason = "saturates, as that does")]
#[inline]
fn whole_units(units: f64) -> i64 {
    let toward_zero = units as i64;
    // Exact: a fraction has no more digits than its number.
    let rest = units - toward_zero as f64;
    toward_zero.saturating_add(i64::from(rest >= 0.5) - i64::from(rest <= -0.5))
}

/// The evidence of one cell, in units of 1/65,536.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CellEvidence {
    /// `sum 1/v`, at least 0.
    pub precision: i64,
    /// `sum y/v`.
    pub weighted_sum: i64,
}

impl CellEvidence {
    /// The sum of two pieces of evidence, saturating at the limits of `i64`.
    #[must_use]
    #[inline]
    pub const fn plus(self, other: Self) -> Self {
        Self {
            precision: self.precision.saturating_add(other.precision),
            weighted_sum: self.weighted_sum.saturating_add(other.weighted_sum),
        }
    }

    /// `ln p(y | object) / p(y | empty) = weighted_sum - precision / 2`, nats: exact for Gaussian readings.
    #[must_use]
    #[inline]
    pub fn log_likelihood_ratio_nats(self) -> f64 {
        (self.weighted_sum as f64 - self.precision as f64 / 2.0) / UNITS
    }
}

/// The evidence of every cell, shape `[cells]`, by index.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Evidence {
    cells: Vec<CellEvidence>,
}

/// A hash, such as that of all evidence: equal contents have equal digests on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(pub u128);

impl fmt::Display for Digest {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:032x}", self.0)
    }
}

impl Evidence {
    /// Evidence of no readings, for a number of cells.
    #[must_use]
    pub fn none(cell_count: usize) -> Self {
        Self { cells: vec![CellEvidence::default(); cell_count] }
    }

    /// Evidence from stored sums, shape `[cells]`; `None` if a precision is below 0.
    #[must_use]
    pub fn from_cells(cells: Vec<CellEvidence>) -> Option<Self> {
        cells.iter().all(|cell| cell.precision >= 0).then_some(Self { cells })
    }

    /// Adds a reading.
    pub fn add(&mut self, reading: &Reading) {
        self.add_evidence(reading.cell, reading.evidence());
    }

    /// Adds the evidence of a reading of a cell.
    #[inline]
    pub fn add_evidence(&mut self, cell: Cell, evidence: CellEvidence) {
        let cell = &mut self.cells[cell.index()];
        *cell = cell.plus(evidence);
    }

    /// The evidence of one cell.
    #[must_use]
    #[inline]
    pub fn of(&self, cell: Cell) -> CellEvidence {
        self.cells[cell.index()]
    }

    /// The evidence of every cell, shape `[cells]`.
    #[must_use]
    pub fn cells(&self) -> &[CellEvidence] {
        &self.cells
    }

    /// XXH3-128 of all pairs of integers, little-endian, in order of the cells' indices.
    #[must_use]
    pub fn digest(&self) -> Digest {
        let mut hash = Xxh3::new();
        let mut bytes = [[[0; 8]; 2]; HASHED_AT_ONCE];
        for cells in self.cells.chunks(HASHED_AT_ONCE) {
            for (bytes, cell) in bytes.iter_mut().zip(cells) {
                *bytes = [cell.precision.to_le_bytes(), cell.weighted_sum.to_le_bytes()];
            }
            hash.update(bytes[..cells.len()].as_flattened().as_flattened());
        }
        Digest(hash.digest128())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::cell::Grid;

    fn reading(value: f32, variance: f32) -> Reading {
        let cell = Grid::new(1, 1).unwrap().cells().next().unwrap();
        Reading { cell, value, variance }
    }

    #[test]
    fn whole_units_are_rounded_as_round_does() {
        let (below, above) = (0.5_f64.next_down(), 0.5_f64.next_up());
        let edges =
            [0.0, 0.5, below, above, 1.5, 2.5, 2f64.powi(52) - 0.5, 2f64.powi(53), 1e300, f64::INFINITY];
        for units in edges.into_iter().flat_map(|edge| [edge, -edge]).chain([f64::NAN]) {
            #[expect(clippy::cast_possible_truncation, reason = "the definition")]
            let expected = units.round() as i64;
            assert_eq!(whole_units(units), expected, "{units}");
        }
    }

    proptest! {
        #[test]
        fn all_whole_units_are_rounded_as_round_does(bits: u64, near in -1e7_f64..1e7, halves in -1_000_000_i32..1_000_000) {
            for units in [f64::from_bits(bits), near, f64::from(halves) / 2.0] {
                #[expect(clippy::cast_possible_truncation, reason = "the definition")]
                let expected = units.round() as i64;
                prop_assert_eq!(whole_units(units), expected);
            }
        }
    }

    #[test]
    fn opposite_evidence_cancels() {
        let sum = reading(1.0, 0.005).evidence().plus(reading(0.0, 0.005).evidence());
        assert!(sum.log_likelihood_ratio_nats().abs() < 1e-9);
    }

    #[test]
    fn a_reading_updates_by_bayes_rule() {
        let (value, variance) = (0.9_f32, 0.045_f32);
        let density = |theta: f64| -(f64::from(value) - theta).powi(2) / 2.0 / f64::from(variance);
        let expected = density(1.0) - density(0.0);
        let given = reading(value, variance).evidence().log_likelihood_ratio_nats();
        assert!((given - expected).abs() < 1e-4, "{given} {expected}");
    }

    #[test]
    fn rounding_adds_little_to_the_variance_and_happens_once() {
        for variance in [MIN_VARIANCE, 0.001, 0.005, 0.045, 0.125, 1.0, 3.0, MAX_VARIANCE] {
            let share = value_step(variance) / variance.sqrt();
            assert!((0.125..=0.25).contains(&share), "{share} of the standard deviation of {variance}");
            for value in [-MAX_VALUE, -0.3, -1e-9, 0.0, 0.47, 0.5001, 0.97, 1.0, 17.3, MAX_VALUE] {
                let given = reading(value, variance);
                let rounded = given.rounded();
                assert!(rounded.is_valid() && !rounded.is_undecided(), "{rounded:?}");
                assert!((rounded.value - value).abs() <= 1.5 * value_step(variance), "{given:?} {rounded:?}");
                assert_eq!(rounded.rounded().value.to_bits(), rounded.value.to_bits());
            }
        }
        let undecided = Reading::undecided(reading(0.0, 1.0).cell);
        assert!(undecided.rounded().is_undecided());
    }

    #[test]
    fn undecided_readings_are_no_evidence() {
        let cell = reading(0.0, 1.0).cell;
        let undecided = Reading::undecided(cell);
        assert!(undecided.is_valid() && undecided.is_undecided() && !reading(0.0, 1.0).is_undecided());
        assert!(undecided.evidence().log_likelihood_ratio_nats().abs() < 1e-4);
        assert!(undecided.evidence().precision < 10);
    }

    #[test]
    fn out_of_range_is_invalid() {
        for (value, variance) in
            [(f32::NAN, 1.0), (1.0, f32::NAN), (1.0, 0.0), (1.0, -1.0), (1e9, 1.0), (1.0, f32::INFINITY)]
        {
            assert!(!reading(value, variance).is_valid());
        }
        assert!(reading(1.0, 0.005).is_valid());
    }

    #[test]
    fn the_digest_is_the_hash_of_all_bytes_however_many_are_hashed_at_once() {
        for count in [1, HASHED_AT_ONCE - 1, HASHED_AT_ONCE, 3 * HASHED_AT_ONCE + 5] {
            let mut evidence = Evidence::none(count);
            let mut bytes = Vec::new();
            for (cell, number) in evidence.cells.iter_mut().zip(1..) {
                *cell = CellEvidence { precision: number, weighted_sum: -number * number };
                bytes.extend(cell.precision.to_le_bytes());
                bytes.extend(cell.weighted_sum.to_le_bytes());
            }
            assert_eq!(evidence.digest(), Digest(xxhash_rust::xxh3::xxh3_128(&bytes)), "{count}");
        }
    }

    proptest! {
        #[test]
        fn any_order_gives_the_same_evidence(
            mut readings in prop::collection::vec((-2.0_f32..3.0, 0.001_f32..4.0), 1..40), swaps in any::<u64>(),
        ) {
            let digest = |readings: &[(f32, f32)]| {
                let mut evidence = Evidence::none(1);
                for &(value, variance) in readings {
                    evidence.add(&reading(value, variance));
                }
                evidence.digest()
            };
            let before = digest(&readings);
            let middle = usize::try_from(swaps).unwrap_or(0) % readings.len();
            readings.rotate_left(middle);
            readings.reverse();
            prop_assert_eq!(digest(&readings), before);
        }
    }
}
