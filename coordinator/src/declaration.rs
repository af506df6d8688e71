//! Declarations: the cells that are declared to hold an object, and the time of each declaration.
//!
//! An object is declared when its probability reaches `detection_threshold`. It stays declared while the evidence
//! fluctuates, and is withdrawn only when its probability falls below one half.
//!
//! A declaration is dated by the reading that warrants it, in the order in which readings were taken, if that is known later
//! than a heartbeat after: a coordinator that has started again, or receives what a robot saw while it was away, dates finds as
//! if it had received all at once.
//!
//! This probability is that of the cell by its own readings, also in a search for subjects of known number
//! ([`dragnet_search::subjects`]): a cell is declared because something was seen there, never because the subject is
//! nowhere else. If two cells are declared, their posterior says which of them it is.

use std::collections::{BTreeMap, BTreeSet};

use dragnet_proto::message::Detection;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::{Belief, probability};
use dragnet_search::cell::Cell;
use dragnet_search::evidence::{CellEvidence, Reading};
use dragnet_search::reach::Reach;
use dragnet_search::terrain::Terrain;

/// Below this probability a declaration is withdrawn, unless `detection_threshold` itself is lower.
pub const WITHDRAWN_BELOW: f64 = 0.5;

/// A reading, and when it was taken.
#[derive(Clone, Copy, Debug)]
pub struct Dated {
    /// When it was taken, by the robot's clock.
    pub time: MissionTime,
    /// The reading.
    pub reading: Reading,
}

/// All declared objects.
#[derive(Clone, Debug)]
pub struct Declarations {
    detection_threshold: f64,
    /// Since when each is declared.
    declared: BTreeMap<Cell, MissionTime>,
}

impl Declarations {
    /// An empty list. Objects are declared from a probability of `detection_threshold` on, which is above 0.
    #[must_use]
    pub const fn new(detection_threshold: f64) -> Self {
        Self { detection_threshold, declared: BTreeMap::new() }
    }

    /// Updates the declarations of cells whose belief has changed; returns whether anything was declared or withdrawn.
    pub fn review(
        &mut self,
        now: MissionTime,
        belief: &Belief,
        cells: impl IntoIterator<Item = Cell>,
    ) -> bool {
        let mut has_changed = false;
        for cell in cells {
            let probability = belief.probability(cell);
            if self.declared.contains_key(&cell) {
                if probability < self.withdrawn_below() {
                    self.declared.remove(&cell);
                    has_changed = true;
                }
            } else if probability >= self.detection_threshold {
                self.declared.insert(cell, now);
                has_changed = true;
            }
        }
        has_changed
    }

    /// Dates the declarations of these cells that are later than these readings, which are all that a log has of them.
    pub fn date(&mut self, belief: &Belief, known: impl Iterator<Item = Dated>, cells: &BTreeSet<Cell>) {
        let mut readings: BTreeMap<Cell, Vec<Dated>> = BTreeMap::new();
        for dated in known.filter(|dated| cells.contains(&dated.reading.cell)) {
            readings.entry(dated.reading.cell).or_default().push(dated);
        }
        for (cell, mut readings) in readings {
            readings.sort_by_key(|dated| dated.time);
            let all =
                readings.iter().fold(CellEvidence::default(), |sum, it| sum.plus(it.reading.evidence()));
            // Marks and verdicts have no place in this order: they count from the start.
            let mut nats = belief.log_odds_nats(cell) - all.log_likelihood_ratio_nats();
            let mut since = None;
            for Dated { time, reading } in readings {
                nats += reading.evidence().log_likelihood_ratio_nats();
                since = match probability(nats) {
                    it if it >= self.detection_threshold => since.or(Some(time)),
                    it if it < self.withdrawn_below() => None,
                    _ => since,
                };
            }
            if let (Some(declared), Some(since)) = (self.declared.get_mut(&cell), since) {
                *declared = since;
            }
        }
    }

    /// Whether an object is declared in a cell, and that later than at this time.
    #[must_use]
    pub fn is_later(&self, cell: Cell, time: MissionTime) -> bool {
        self.declared.get(&cell).is_some_and(|&declared| declared > time)
    }

    fn withdrawn_below(&self) -> f64 {
        self.detection_threshold.min(WITHDRAWN_BELOW)
    }

    /// Whether an object is declared in a cell.
    #[must_use]
    pub fn contains(&self, cell: Cell) -> bool {
        self.declared.contains_key(&cell)
    }

    /// The cells of all declared objects, in order.
    pub fn cells(&self) -> impl Iterator<Item = Cell> {
        self.declared.keys().copied()
    }

    /// All declared objects, by cell, with these probabilities.
    pub fn detections(&self, probabilities: impl IntoIterator<Item = f64>) -> Vec<Detection> {
        let with_probability = |((&cell, time), probability): ((&Cell, &MissionTime), f64)| Detection {
            cell,
            probability,
            time_ns: time.0,
        };
        self.declared.iter().zip(probabilities).map(with_probability).collect()
    }

    /// Expected number of objects in cells without a declaration, of those in reach.
    #[must_use]
    pub fn expected_remaining(&self, terrain: &Terrain, reach: &Reach, belief: &Belief) -> f64 {
        let undeclared = terrain.searched_cells().filter(|&cell| reach.covers(cell) && !self.contains(cell));
        undeclared.map(|cell| belief.probability(cell)).sum::<f64>() + 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TAU: f64 = 0.95;

    /// One cell, even odds.
    struct Field {
        terrain: Terrain,
        belief: Belief,
        declarations: Declarations,
        now: MissionTime,
    }

    impl Field {
        fn new(detection_threshold: f64) -> Self {
            let terrain = Terrain::from_ascii(".", 1.0).unwrap();
            let belief = Belief::uniform(&terrain, 0.5).unwrap();
            Self {
                terrain,
                belief,
                declarations: Declarations::new(detection_threshold),
                now: MissionTime::START,
            }
        }

        fn cell(&self) -> Cell {
            self.terrain.grid().cell_numbered(0).unwrap()
        }

        /// Adds a reading that moves the log-odds by this much; returns whether the declarations changed.
        fn learn(&mut self, nats: f32) -> bool {
            self.now = MissionTime(self.now.0 + 1);
            self.belief.add(&Reading { cell: self.cell(), value: 0.5 + nats, variance: 1.0 });
            self.declarations.review(self.now, &self.belief, [self.cell()])
        }

        fn declared(&self) -> Vec<(f64, u64)> {
            let probabilities = self.declarations.cells().map(|cell| self.belief.probability(cell));
            let detections = self.declarations.detections(probabilities);
            detections.iter().map(|found| (found.probability, found.time_ns)).collect()
        }
    }

    #[test]
    fn an_object_stays_declared_while_evidence_wavers_and_is_withdrawn_when_it_turns() {
        let mut field = Field::new(TAU);
        assert!(!field.learn(2.0));
        assert!(field.learn(2.0));
        assert!(!field.learn(-3.0), "wavering withdraws nothing");
        let [(probability, time_ns)] = field.declared()[..] else { panic!("not declared") };
        assert!((0.5..TAU).contains(&probability), "{probability}");
        assert_eq!(time_ns, 2);
        assert!(field.learn(-1.5));
        assert_eq!(field.declared(), []);
    }

    #[test]
    fn an_object_that_is_declared_again_counts_from_then() {
        let mut field = Field::new(TAU);
        assert!(field.learn(4.0) && field.learn(-5.0) && field.learn(6.0));
        assert_eq!(field.declared()[0].1, 3);
    }

    #[test]
    fn a_low_tau_does_not_withdraw_its_declarations() {
        let mut field = Field::new(0.3);
        assert!(field.learn(-0.5));
        assert!(!field.learn(0.0));
        assert_eq!(field.declared().len(), 1);
        assert!(field.learn(-1.0));
    }

    #[test]
    fn a_declared_object_is_not_expected_to_remain_even_when_it_wavers() {
        let mut field = Field::new(TAU);
        let reach = Reach::unknown(field.terrain.grid());
        let expected =
            |field: &Field| field.declarations.expected_remaining(&field.terrain, &reach, &field.belief);
        assert!((expected(&field) - 0.5).abs() < 1e-12);
        field.learn(4.0);
        field.learn(-3.0);
        assert!(expected(&field).abs() < 1e-12);
        assert!(field.belief.expected_remaining(&field.terrain, &reach, TAU) > 0.5);
    }
}
