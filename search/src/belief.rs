//! The belief: the probability that a cell holds an object, from the prior and the evidence.

use std::sync::Arc;

use crate::cell::Cell;
use crate::evidence::{CellEvidence, Digest, Evidence, Reading};
use crate::reach::Reach;
use crate::terrain::Terrain;

/// Independent Bernoulli prior and all evidence so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Belief {
    /// `ln(p / (1 - p))` before any reading, shape `[cells]`; `-inf` where nothing is searched.
    /// Copies share it.
    prior_log_odds_nats: Arc<[f64]>,
    evidence: Evidence,
}

/// Why a prior is invalid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PriorError {
    /// A value that is not a probability, or a probability of 1, which no reading could change.
    #[error("prior {probability} of cell {cell}: allowed is from 0 to below 1")]
    Probability {
        /// Index of the cell.
        cell: usize,
        /// The given value.
        probability: f64,
    },
    /// The list does not have one entry for each cell.
    #[error("a prior of {given} cells for a map of {expected}")]
    CellCount {
        /// Cells given.
        given: usize,
        /// Cells of the map.
        expected: usize,
    },
}

impl Belief {
    /// The prior probability of an object, shape `[cells]`. Cells outside the search area get 0 regardless of the list,
    /// and no reading changes them.
    ///
    /// # Errors
    /// If the list does not fit the map or holds a number outside `0.0..1.0`.
    pub fn new(terrain: &Terrain, probability: &[f64]) -> Result<Self, PriorError> {
        let expected = terrain.grid().cell_count();
        if probability.len() != expected {
            return Err(PriorError::CellCount { given: probability.len(), expected });
        }
        let mut prior_log_odds_nats = Vec::with_capacity(expected);
        for (cell, &probability) in terrain.grid().cells().zip(probability) {
            if !(0.0..1.0).contains(&probability) {
                return Err(PriorError::Probability { cell: cell.index(), probability });
            }
            let probability = if terrain.is_searched(cell) { probability } else { 0.0 };
            prior_log_odds_nats.push((probability / (1.0 - probability)).ln());
        }
        Ok(Self { prior_log_odds_nats: prior_log_odds_nats.into(), evidence: Evidence::none(expected) })
    }

    /// The posterior of another belief as a prior: `ln(p / (1 - p))`, shape `[cells]`. Unlike [`Belief::new`] it
    /// accepts certain cells (infinite log-odds).
    ///
    /// # Errors
    /// If the list does not fit the map or holds a NaN.
    pub fn from_log_odds(terrain: &Terrain, log_odds_nats: Vec<f64>) -> Result<Self, PriorError> {
        let expected = terrain.grid().cell_count();
        if log_odds_nats.len() != expected {
            return Err(PriorError::CellCount { given: log_odds_nats.len(), expected });
        }
        if let Some(cell) = log_odds_nats.iter().position(|log_odds| log_odds.is_nan()) {
            return Err(PriorError::Probability { cell, probability: f64::NAN });
        }
        Ok(Self { prior_log_odds_nats: log_odds_nats.into(), evidence: Evidence::none(expected) })
    }

    /// The same prior with other evidence.
    ///
    /// # Errors
    /// If the evidence has another number of cells.
    pub fn with_evidence(&self, evidence: Evidence) -> Result<Self, PriorError> {
        let (given, expected) = (evidence.cells().len(), self.prior_log_odds_nats.len());
        if given != expected {
            return Err(PriorError::CellCount { given, expected });
        }
        Ok(Self { prior_log_odds_nats: Arc::clone(&self.prior_log_odds_nats), evidence })
    }

    /// The same prior probability in every searched cell.
    ///
    /// # Errors
    /// If it is outside `0.0..1.0`.
    pub fn uniform(terrain: &Terrain, probability: f64) -> Result<Self, PriorError> {
        Self::new(terrain, &vec![probability; terrain.grid().cell_count()])
    }

    /// Mean prior probability of the cells that a terrain searches; 0 if it searches none.
    #[must_use]
    pub fn mean_prior(&self, terrain: &Terrain) -> f64 {
        let sum: f64 = terrain.searched_cells().map(|cell| self.prior_probability(cell)).sum();
        sum / (terrain.searched_cells().count().max(1) as f64)
    }

    /// Adds cells to the search area with this prior probability, strictly between 0 and 1; cells that are already
    /// searched keep theirs. Earlier readings of the added cells count too. Returns the cells that were not searched
    /// before.
    pub fn search_also(
        &mut self,
        terrain: &mut Terrain,
        cells: impl IntoIterator<Item = Cell>,
        probability: f64,
    ) -> Vec<Cell> {
        let prior_log_odds_nats = (probability / (1.0 - probability)).ln();
        let new: Vec<Cell> = cells.into_iter().filter(|&cell| !terrain.is_searched(cell)).collect();
        if !new.is_empty() {
            let prior = Arc::make_mut(&mut self.prior_log_odds_nats);
            for &cell in &new {
                terrain.search(cell);
                prior[cell.index()] = prior_log_odds_nats;
            }
        }
        new
    }

    /// The log-odds before any reading, shape `[cells]`, as they are now: cells that are added later change the belief alone.
    #[must_use]
    pub fn shared_prior(&self) -> Arc<[f64]> {
        Arc::clone(&self.prior_log_odds_nats)
    }

    /// The address of the prior: copies whose prior has not been changed have the same.
    #[must_use]
    pub fn prior_address(&self) -> usize {
        self.prior_log_odds_nats.as_ptr().addr()
    }

    /// Adds the evidence of a reading of a cell.
    #[inline]
    pub fn add_evidence(&mut self, cell: Cell, evidence: CellEvidence) {
        self.evidence.add_evidence(cell, evidence);
    }

    /// Adds a reading.
    pub fn add(&mut self, reading: &Reading) {
        self.evidence.add(reading);
    }

    /// All evidence so far.
    #[must_use]
    pub const fn evidence(&self) -> &Evidence {
        &self.evidence
    }

    /// Digest of all evidence so far.
    #[must_use]
    pub fn digest(&self) -> Digest {
        self.evidence.digest()
    }

    /// `ln(p / (1 - p))` of a cell before any reading; `-inf` where nothing is searched.
    #[must_use]
    #[inline]
    pub fn prior_log_odds_nats(&self, cell: Cell) -> f64 {
        self.prior_log_odds_nats[cell.index()]
    }

    /// `ln(p / (1 - p))` of each cell before any reading, shape `[cells]`.
    #[must_use]
    pub fn prior_log_odds(&self) -> &[f64] {
        &self.prior_log_odds_nats
    }

    /// Probability that a cell holds an object, before any reading.
    #[must_use]
    pub fn prior_probability(&self, cell: Cell) -> f64 {
        probability(self.prior_log_odds_nats(cell))
    }

    /// `ln(p / (1 - p))` of a cell; `-inf` where nothing is searched.
    #[must_use]
    #[inline]
    pub fn log_odds_nats(&self, cell: Cell) -> f64 {
        self.prior_log_odds_nats(cell) + self.evidence.of(cell).log_likelihood_ratio_nats()
    }

    /// Probability that a cell holds an object.
    #[must_use]
    #[inline]
    pub fn probability(&self, cell: Cell) -> f64 {
        probability(self.log_odds_nats(cell))
    }

    /// `ln(p / (1 - p))` of each cell, shape `[cells]`, by index.
    pub(crate) fn log_odds(&self) -> impl Iterator<Item = f64> {
        let cells = self.prior_log_odds_nats.iter().zip(self.evidence.cells());
        cells.map(|(prior, evidence)| prior + evidence.log_likelihood_ratio_nats())
    }

    /// Probability of each cell, shape `[cells]`, by index.
    #[must_use]
    pub fn probabilities(&self) -> Vec<f64> {
        self.log_odds().map(probability).collect()
    }

    /// Whether a cell's probability is at least `tau`.
    #[must_use]
    #[inline]
    pub fn is_found(&self, cell: Cell, tau: f64) -> bool {
        let log_odds_nats = self.log_odds_nats(cell);
        // Most cells are empty and need no exponential: below even odds no `tau` above one half is reached.
        (log_odds_nats > 0.0 || tau <= 0.5) && probability(log_odds_nats) >= tau
    }

    /// Expected number of objects in cells whose probability is below `tau`, of those that a robot can see.
    #[must_use]
    pub fn expected_remaining(&self, terrain: &Terrain, reach: &Reach, tau: f64) -> f64 {
        // The sum of none is -0.
        self.remaining(terrain, reach, tau).sum::<f64>() + 0.0
    }

    /// Whether [`Belief::expected_remaining`] is at most `most`; the sum stops as soon as it is above.
    #[must_use]
    pub fn expects_at_most(&self, terrain: &Terrain, reach: &Reach, tau: f64, most: f64) -> bool {
        let mut expected = 0.0;
        // No probability is negative, and so no sum, rounded as it is, is below one of fewer cells.
        self.remaining(terrain, reach, tau).all(|probability| {
            expected += probability;
            expected <= most
        })
    }

    fn remaining(&self, terrain: &Terrain, reach: &Reach, tau: f64) -> impl Iterator<Item = f64> {
        terrain
            .searched_cells()
            .filter(move |&cell| reach.covers(cell))
            .map(move |cell| self.probability(cell))
            .filter(move |&probability| probability < tau)
    }

    /// Entropy of the whole map, nats.
    #[must_use]
    pub fn entropy_nats(&self, terrain: &Terrain) -> f64 {
        terrain.searched_cells().map(|cell| entropy_nats(self.log_odds_nats(cell))).sum()
    }
}

/// Probability of these log-odds (nats).
#[must_use]
#[inline]
pub fn probability(log_odds_nats: f64) -> f64 {
    1.0 / (1.0 + (-log_odds_nats).exp())
}

/// Entropy of a Bernoulli variable of these log-odds, nats, `0..=ln 2`.
///
/// Computed from `|log_odds|`, so that a certain cell gives 0 rather than `0 * -inf`.
#[must_use]
#[inline]
pub fn entropy_nats(log_odds_nats: f64) -> f64 {
    let magnitude = log_odds_nats.abs();
    if magnitude > 700.0 {
        return 0.0;
    }
    let odds = (-magnitude).exp();
    // Where 1 and the odds add up to 1, the rest is the same to the bit.
    if magnitude > 40.0 {
        return odds + magnitude * odds;
    }
    odds.ln_1p() + magnitude * odds / (1.0 + odds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reach::Sight;

    #[test]
    fn entropy_is_symmetric_and_vanishes_when_certain() {
        assert!((entropy_nats(0.0) - std::f64::consts::LN_2).abs() < 1e-15);
        assert!((entropy_nats(2.0) - entropy_nats(-2.0)).abs() < 1e-15);
        let p: f64 = 0.05;
        let direct = -p * p.ln() - (1.0 - p) * (1.0 - p).ln();
        assert!((entropy_nats((p / (1.0 - p)).ln()) - direct).abs() < 1e-12);
        assert!(entropy_nats(f64::NEG_INFINITY).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn finds_are_the_cells_above_the_threshold() {
        let terrain = Terrain::from_ascii(".", 1.0).unwrap();
        let cell = terrain.grid().cells().next().unwrap();
        let mut met = [0, 0];
        for step in -200..=200 {
            let log_odds = f64::from(step) / 40.0;
            let belief = Belief::from_log_odds(&terrain, vec![log_odds]).unwrap();
            for tau in [0.0, 0.2, 0.5, 0.6, 0.95, probability(log_odds)] {
                let is_found = belief.is_found(cell, tau);
                assert_eq!(is_found, belief.probability(cell) >= tau, "{log_odds} {tau}");
                met[usize::from(is_found)] += 1;
            }
            let (far, odds) = (log_odds.abs() * 10.0, (-log_odds.abs() * 10.0).exp());
            assert_eq!(entropy_nats(far).to_bits(), (odds.ln_1p() + far * odds / (1.0 + odds)).to_bits());
        }
        assert!(met[0] > 100 && met[1] > 100);
    }

    #[test]
    fn nothing_convinces_where_nothing_is_searched() {
        let terrain = Terrain::from_ascii(",.", 1.0).unwrap();
        let mut belief = Belief::uniform(&terrain, 0.2).unwrap();
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        for &cell in &cells {
            belief.add(&Reading { cell, value: 1.0, variance: 0.001 });
        }
        assert!(belief.probability(cells[0]).abs() < f64::MIN_POSITIVE);
        assert!(belief.is_found(cells[1], 0.95));
        let reach = Reach::unknown(terrain.grid());
        assert!(belief.expected_remaining(&terrain, &reach, 0.95).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn no_objects_are_expected_out_of_reach() {
        let terrain = Terrain::from_ascii(".~~~", 1.0).unwrap();
        let belief = Belief::uniform(&terrain, 0.2).unwrap();
        let mut reach = Reach::unknown(terrain.grid());
        assert!((belief.expected_remaining(&terrain, &reach, 0.95) - 0.8).abs() < 1e-12);
        reach.add_robot(&terrain, Sight::on_ground(1), terrain.grid().cells().next().unwrap());
        assert!((belief.expected_remaining(&terrain, &reach, 0.95) - 0.4).abs() < 1e-12);
    }

    #[test]
    fn cells_that_are_added_count_like_any_whenever_they_were_seen() {
        let drawn = Terrain::from_ascii(".,,", 1.0).unwrap();
        let cells: Vec<Cell> = drawn.grid().cells().collect();
        let see = |belief: &mut Belief| belief.add(&Reading { cell: cells[1], value: 1.0, variance: 0.1 });
        let beliefs = [true, false].map(|is_seen_first| {
            let (mut terrain, mut belief) = (drawn.clone(), Belief::uniform(&drawn, 0.2).unwrap());
            if is_seen_first {
                see(&mut belief);
            }
            let mean = belief.mean_prior(&terrain);
            assert!((mean - 0.2).abs() < 1e-12);
            assert_eq!(belief.search_also(&mut terrain, cells[..2].to_vec(), mean), [cells[1]]);
            assert!(belief.search_also(&mut terrain, cells[..2].to_vec(), 0.5).is_empty());
            assert_eq!(terrain.searched_cells().collect::<Vec<_>>(), cells[..2]);
            if !is_seen_first {
                see(&mut belief);
            }
            belief
        });
        assert_eq!(beliefs[0], beliefs[1]);
        assert!(beliefs[0].is_found(cells[1], 0.95));
        assert!(beliefs[0].probability(cells[2]).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn certainty_is_no_prior() {
        let terrain = Terrain::from_ascii("..", 1.0).unwrap();
        assert!(Belief::uniform(&terrain, 1.0).is_err());
        assert!(Belief::uniform(&terrain, f64::NAN).is_err());
        assert!(Belief::new(&terrain, &[0.1]).is_err());
    }
}
