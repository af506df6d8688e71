//! Cells in which a vehicle has detected an object that it could not assign to one of them yet.
//!
//! Undecided readings are no evidence: the beliefs of two robots that track one object would add up to two objects. But
//! a robot that has seen something and drove on must not plan as if it had seen nothing. So planning and the end of the
//! search use a belief in which such a cell is at least as probable as that the object is in it rather than in another
//! undecided cell of the same observation, or nowhere. A later reading that the cell is empty ends this. So it is with cells that
//! it has reported to be empty, and has come to doubt when they were out of sight.

use std::borrow::Cow;
use std::collections::BTreeMap;

use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Reading;

/// The cells, each with the probability of an object in it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sightings {
    cells: BTreeMap<Cell, f64>,
}

impl Sightings {
    /// Adds the undecided readings of an observation, and removes the cells that it shows empty. A reading beside
    /// undecided ones that withdraws earlier evidence of a cell's being empty is of the same object.
    pub(crate) fn add(&mut self, readings: &[Reading]) {
        let has_undecided = readings.iter().any(Reading::is_undecided);
        if self.cells.is_empty() && !has_undecided {
            return;
        }
        let is_sighting = |reading: &&Reading| reading.value >= 0.5;
        let places = readings.iter().filter(is_sighting).count();
        for reading in readings {
            if reading.value < 0.5 {
                self.cells.remove(&reading.cell);
            } else if has_undecided {
                self.cells.insert(reading.cell, 1.0 / (places as f64 + 1.0));
            }
        }
    }

    /// Adds cells in one of which an object may be, though they were observed to be empty.
    pub(crate) fn doubt(&mut self, cells: &[Cell]) {
        for &cell in cells {
            self.cells.insert(cell, 1.0 / (cells.len() as f64 + 1.0));
        }
    }

    /// Removes cells about which the operator has decided.
    pub(crate) fn settle(&mut self, cells: &[Cell]) {
        for cell in cells {
            self.cells.remove(cell);
        }
    }

    /// The belief with these sightings, in which no cell becomes found by them.
    pub(crate) fn added_to<'a>(&self, belief: &'a Belief) -> Cow<'a, Belief> {
        let mut belief = Cow::Borrowed(belief);
        for (&cell, &probability) in &self.cells {
            let missing_nats = (probability / (1.0 - probability)).ln() - belief.log_odds_nats(cell);
            if missing_nats > 0.0 && missing_nats.is_finite() {
                belief.to_mut().add(&Reading::with_nats(cell, 1.0, missing_nats));
            }
        }
        belief
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::cell::{Grid, Position};
    use dragnet_search::terrain::Terrain;

    use super::*;

    const TAU: f64 = 0.95;

    fn field() -> (Belief, [Cell; 3]) {
        let terrain = Terrain::from_ascii("...\n...\n...", 10.0).unwrap();
        let cell = |column| Grid::new(3, 3).unwrap().cell(Position { row: 1, column }).unwrap();
        (Belief::uniform(&terrain, 1.0 / 9.0).unwrap(), [0, 1, 2].map(cell))
    }

    fn empty(cell: Cell) -> Reading {
        Reading { cell, value: 0.0, variance: 0.1 }
    }

    #[test]
    fn a_sighting_lasts_until_its_cell_is_seen_to_be_empty() {
        let (mut belief, [a, b, c]) = field();
        let mut sightings = Sightings::default();
        let mut observe = |belief: &mut Belief, readings: &[Reading]| {
            for reading in readings {
                belief.add(reading);
            }
            sightings.add(readings);
            let added = sightings.added_to(belief);
            [a, b, c].map(|cell| format!("{:.0}", added.probability(cell) * 100.0))
        };
        assert_eq!(observe(&mut belief, &[empty(a), empty(c)]), ["0", "11", "0"]);
        assert_eq!(observe(&mut belief, &[Reading::undecided(b)]), ["0", "50", "0"]);
        assert_eq!(observe(&mut belief, &[empty(a)]), ["0", "50", "0"], "elsewhere nothing has changed");
        let withdrawn = Reading { value: 1.0, ..empty(a) };
        let both = [withdrawn, Reading::undecided(b)];
        assert_eq!(observe(&mut belief, &both), ["33", "33", "0"], "in one of two cells, or nowhere");
        assert_eq!(observe(&mut belief, &[empty(b)]), ["33", "0", "0"]);
    }

    #[test]
    fn of_doubted_cells_each_may_hold_an_object_until_it_is_seen_to_be_empty_again() {
        let (mut belief, [a, b, c]) = field();
        for cell in [a, b, c] {
            belief.add(&empty(cell));
        }
        let mut sightings = Sightings::default();
        sightings.doubt(&[a, b]);
        let percent = |sightings: &Sightings| {
            let added = sightings.added_to(&belief);
            [a, b, c].map(|cell| format!("{:.0}", added.probability(cell) * 100.0))
        };
        assert_eq!(percent(&sightings), ["33", "33", "0"]);
        sightings.add(&[empty(a)]);
        assert_eq!(percent(&sightings), ["0", "33", "0"]);
    }

    #[test]
    fn a_sighting_is_no_evidence_and_declares_nothing() {
        let (belief, [a, b, _]) = field();
        let mut sightings = Sightings::default();
        assert!(matches!(sightings.added_to(&belief), Cow::Borrowed(_)));
        for _ in 0..9 {
            sightings.add(&[Reading::undecided(a)]);
        }
        let added = sightings.added_to(&belief);
        assert!(!added.is_found(a, TAU) && added.digest() != belief.digest());
        let mut found = belief.clone();
        found.add(&Reading { cell: b, value: 1.0, variance: 0.05 });
        sightings.add(&[Reading::undecided(b)]);
        assert_eq!(sightings.added_to(&found).log_odds_nats(b).to_bits(), found.log_odds_nats(b).to_bits());
    }
}
