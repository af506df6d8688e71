//! Marks: what the operator has marked on the map, gossiped by all participants as the newest entry for each mark.
//!
//! A mark is evidence ([`dragnet_search::mark`]) with a note. It is never removed, only withdrawn: then its evidence is taken back
//! to the bit. Merging is commutative and idempotent, so equal readings and equal marks give equal beliefs, in any order of
//! arrival.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use dragnet_scenario::Places;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::{Cell, Grid};
use dragnet_search::evidence::{CellEvidence, UNITS};
use dragnet_search::mark::{Clue, Mark, Searched};

use crate::newest::Newest;

/// The name of a mark: when it was made, nanoseconds of mission time, or the next that is unused.
pub type MarkId = u64;

/// A mark with what is said of it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Marked {
    /// Whether it was withdrawn, and counts no longer.
    pub is_withdrawn: bool,
    /// The mark.
    pub mark: Mark,
    /// The operator's words, at most [`Marked::MAX_NOTE_BYTES`]; may be empty.
    pub note: String,
}

impl Marked {
    /// The greatest length of a note, bytes of UTF-8.
    pub const MAX_NOTE_BYTES: usize = 240;

    /// The mark in words, on one line: `a clue at [3, 4], 20 to 1 for an object within about 35 m: a glove`.
    #[must_use]
    pub fn said(&self, places: &Places) -> String {
        let note: String = self.note.chars().filter(|letter| !letter.is_control()).collect();
        let note = if note.is_empty() { note } else { format!(": {note}") };
        match &self.mark {
            Mark::Clue(clue) => {
                let times = clue.ratio();
                let near = match clue.radius_hundredths {
                    0 => "this cell".to_owned(),
                    _ => format!("about {:.0} m", places.meters(clue.radius_cells())),
                };
                format!(
                    "a clue at {}, {times} to 1 for an object within {near}{note}",
                    places.on_earth(clue.cell)
                )
            }
            Mark::Searched(search) => {
                let cells = places.some(&search.cells);
                let percent = f64::from(search.pod_thousandths) / 10.0;
                format!(
                    "a search of {cells} by others, who found nothing and would have found {percent} % of the objects{note}"
                )
            }
        }
    }
}

/// The marks that a participant knows. The default contains none.
pub type Marks = Newest<MarkId, Arc<Marked>>;

impl Marks {
    /// The greatest number of marks that an operator can make, withdrawn ones included.
    pub const MOST: usize = 500;
    /// A participant takes the marks and cells of this number of operators: operators who do not hear each other make more together.
    pub(crate) const OPERATORS: usize = 4;

    /// The greatest number of cells of all marks together that an operator can make.
    #[must_use]
    pub const fn most_cells(grid: Grid) -> usize {
        8 * grid.cell_count()
    }

    /// The marks that count, in the order in which they were made.
    pub fn standing(&self) -> impl Iterator<Item = (MarkId, Arc<Marked>)> + '_ {
        self.iter().map(|(id, entry)| (id, entry.value)).filter(|(_, marked)| !marked.is_withdrawn)
    }

    /// Clues that count, each with its number: the first clue is 1, also after it was withdrawn, so that names stay.
    pub fn clues(&self) -> impl Iterator<Item = (usize, MarkId, Clue, Arc<Marked>)> + '_ {
        let clues = self.iter().filter_map(|(id, entry)| match entry.value.mark {
            Mark::Clue(clue) => Some((id, clue, entry.value)),
            Mark::Searched(_) => None,
        });
        let numbered = (1..).zip(clues).map(|(number, (id, clue, marked))| (number, id, clue, marked));
        numbered.filter(|(.., marked)| !marked.is_withdrawn)
    }

    /// What others have searched, as far as it counts, likewise.
    pub fn searches(&self) -> impl Iterator<Item = (usize, MarkId, Searched, Arc<Marked>)> + '_ {
        let searches = self.iter().filter_map(|(id, entry)| match &entry.value.mark {
            Mark::Searched(search) => Some((id, search.clone(), Arc::clone(&entry.value))),
            Mark::Clue(_) => None,
        });
        let numbered = (1..).zip(searches).map(|(number, (id, search, marked))| (number, id, search, marked));
        numbered.filter(|(.., marked)| !marked.is_withdrawn)
    }

    /// Whether a further mark of this number of cells can be made.
    #[must_use]
    pub fn has_room(&self, grid: Grid, cells: usize) -> bool {
        let known: usize = self.iter().map(|(_, entry)| entry.value.mark.cell_count()).sum();
        self.iter().len() < Self::MOST && known + cells <= Self::most_cells(grid)
    }

    /// Makes a mark, as of a time in nanoseconds.
    pub fn make(&mut self, time_ns: u64, mark: Mark, note: String) {
        let mut id = time_ns;
        while self.numbered(id).is_some() {
            // Time may be at its end, if a faulty participant has set the clock.
            id = id.wrapping_add(1);
        }
        self.give(time_ns, id, Arc::new(Marked { is_withdrawn: false, mark, note }));
    }

    /// Withdraws a mark, as of a time in nanoseconds; false if it does not count.
    pub fn withdraw(&mut self, time_ns: u64, id: MarkId) -> bool {
        let standing = self.of(id).filter(|marked| !marked.is_withdrawn);
        let Some(marked) = standing else { return false };
        self.give(time_ns, id, Arc::new(Marked { is_withdrawn: true, ..Arc::unwrap_or_clone(marked) }));
        true
    }

    /// Merges the marks of another participant, and adds the changes to the belief; returns the cells that they concern,
    /// `None` if nothing is news. `prior` has the log-odds before any reading or added cell, shape `[cells]`.
    pub fn merge_into(
        &mut self,
        now: MissionTime,
        other: &Self,
        grid: Grid,
        prior: &[f64],
        belief: &mut Belief,
    ) -> Option<BTreeSet<Cell>> {
        let before = self.clone();
        let news = self.merge_news(now, other);
        if news.is_empty() {
            return None;
        }
        let news = news.iter().flat_map(|(before, after)| before.iter().chain([after]));
        let concerned: BTreeSet<Cell> =
            news.flat_map(|marked| marked.mark.evidence(grid)).map(|(cell, _)| cell).collect();
        let (was, is) = (before.units(&concerned, grid, prior), self.units(&concerned, grid, prior));
        let units = |of: &BTreeMap<Cell, i64>, cell| of.get(&cell).copied().unwrap_or(0);
        for &cell in &concerned {
            let weighted_sum = units(&is, cell) - units(&was, cell);
            belief.add_evidence(cell, CellEvidence { precision: 0, weighted_sum });
        }
        Some(concerned)
    }

    /// What all marks together add to the log-odds of these cells, units. Clues never make a find: see [`most_units`].
    fn units(&self, cells: &BTreeSet<Cell>, grid: Grid, prior: &[f64]) -> BTreeMap<Cell, i64> {
        let (mut rises, mut falls) = (BTreeMap::new(), BTreeMap::new());
        for (_, marked) in self.standing() {
            let sums = if matches!(marked.mark, Mark::Clue(_)) { &mut rises } else { &mut falls };
            for (cell, evidence) in marked.mark.evidence(grid) {
                if cells.contains(&cell) {
                    *sums.entry(cell).or_insert(0) += evidence.weighted_sum;
                }
            }
        }
        let mut sums: BTreeMap<Cell, i64> = falls;
        for (cell, rise) in rises {
            *sums.entry(cell).or_insert(0) += rise.min(most_units(prior[cell.index()]));
        }
        sums
    }

    /// Probability that the searches of others would have detected an object, of each of these cells.
    #[must_use]
    pub fn probability_of_detection(&self, cells: &BTreeSet<Cell>) -> BTreeMap<Cell, f64> {
        let mut missed: BTreeMap<Cell, f64> = cells.iter().map(|&cell| (cell, 1.0)).collect();
        for (_, marked) in self.standing() {
            if let Mark::Searched(search) = &marked.mark {
                for &cell in search.cells.intersection(cells) {
                    missed
                        .entry(cell)
                        .and_modify(|missed| *missed *= 1.0 - search.probability_of_detection());
                }
            }
        }
        missed.into_iter().map(|(cell, missed)| (cell, 1.0 - missed)).collect()
    }
}

/// The most that all clues together add to the log-odds of a cell with this prior, units: they make it at most as likely as not,
/// so that robots go and look, and a find always rests on what they have seen. A cell that nothing was known of before gets at
/// most [`MOST_NATS_BEYOND`].
#[expect(clippy::cast_possible_truncation, reason = "saturates")]
fn most_units(prior_log_odds_nats: f64) -> i64 {
    let most = if prior_log_odds_nats.is_finite() { -prior_log_odds_nats } else { MOST_NATS_BEYOND };
    // Steps that are coarser than any rounding of logarithms: everybody has the same.
    ((most * 16.0).floor().max(0.0) / 16.0 * UNITS) as i64
}

/// In cells beyond the scenario's search area, which the operator may add: the odds rise at most 20 times.
const MOST_NATS_BEYOND: f64 = 3.0;

#[cfg(test)]
mod tests {
    use dragnet_search::terrain::Terrain;
    use proptest::prelude::*;

    use super::*;

    /// The belief of an operator, and marks as they are made.
    #[derive(Clone)]
    struct Desk {
        terrain: Terrain,
        belief: Belief,
        marks: Marks,
        now: MissionTime,
    }

    impl Desk {
        fn new() -> Self {
            let terrain = Terrain::from_ascii("....\n....", 1.0).unwrap();
            let belief = Belief::uniform(&terrain, 0.1).unwrap();
            Self { terrain, belief, marks: Marks::default(), now: MissionTime(9) }
        }

        fn receive(&mut self, marks: &Marks) -> Option<BTreeSet<Cell>> {
            self.now = MissionTime(self.now.0 + 1);
            let prior = Belief::uniform(&self.terrain, 0.1).unwrap().shared_prior();
            self.marks.merge_into(self.now, marks, self.terrain.grid(), &prior, &mut self.belief)
        }

        fn make(&mut self, time_ns: u64, mark: Mark) {
            let mut marks = self.marks.clone();
            marks.make(time_ns, mark, "a glove".to_owned());
            assert!(self.receive(&marks).is_some());
        }

        fn withdraw(&mut self, time_ns: u64, id: MarkId) -> bool {
            let mut marks = self.marks.clone();
            let is_new = marks.withdraw(time_ns, id);
            self.receive(&marks);
            is_new
        }
    }

    fn cell(number: u32) -> Cell {
        Desk::new().terrain.grid().cell_numbered(number).unwrap()
    }

    fn clue(number: u32) -> Mark {
        Mark::Clue(Clue { cell: cell(number), ratio_thousandths: 20_000, radius_hundredths: 100 })
    }

    fn searched(numbers: impl IntoIterator<Item = u32>) -> Mark {
        Mark::Searched(Searched { cells: numbers.into_iter().map(cell).collect(), pod_thousandths: 700 })
    }

    #[test]
    fn two_marks_of_one_moment_both_count_and_a_withdrawn_one_no_longer() {
        let mut desk = Desk::new();
        desk.make(5, clue(1));
        let one = desk.belief.digest();
        desk.make(5, searched([1, 2]));
        desk.make(5, searched([2]));
        assert_eq!(desk.marks.standing().map(|(id, _)| id).collect::<Vec<_>>(), [5, 6, 7]);
        let pod = |desk: &Desk, number| {
            desk.marks.probability_of_detection(&[1, 2, 3].map(cell).into())[&cell(number)]
        };
        assert!((pod(&desk, 1) - 0.7).abs() < 1e-12 && (pod(&desk, 2) - 0.91).abs() < 1e-12);
        assert!(pod(&desk, 3).abs() < 1e-12);
        assert!(desk.withdraw(8, 6) && desk.withdraw(8, 7) && !desk.withdraw(9, 7) && !desk.withdraw(9, 4));
        assert_eq!((desk.belief.digest(), desk.marks.standing().count()), (one, 1));
        assert!(pod(&desk, 2).abs() < 1e-12);
    }

    #[test]
    fn an_operator_makes_so_many_marks_of_so_many_cells() {
        let grid = Desk::new().terrain.grid();
        let mut marks = Marks::default();
        (0..8).for_each(|time| marks.make(time, searched(0..8), String::new()));
        assert!(marks.has_room(grid, 0) && !marks.has_room(grid, 1), "8 times the map");
        let mut marks = Marks::default();
        (0..500).for_each(|time| marks.make(time, searched([]), String::new()));
        assert!(!marks.has_room(grid, 0));
    }

    #[test]
    fn however_many_clues_there_are_a_find_rests_on_what_was_seen() {
        let mut desk = Desk::new();
        let before = desk.belief.digest();
        (0..9).for_each(|time| desk.make(time, clue(1)));
        let probability = |desk: &Desk| desk.belief.probability(cell(1));
        assert!((0.48..=0.5).contains(&probability(&desk)), "{}", probability(&desk));
        desk.make(9, searched([1]));
        assert!(probability(&desk) < 0.25, "a search of others counts in full: {}", probability(&desk));
        (0..10).rev().for_each(|id| assert!(desk.withdraw(20, id)));
        assert_eq!(desk.belief.digest(), before);
    }

    #[test]
    fn at_the_end_of_time_marks_have_names_of_their_own_too() {
        let mut desk = Desk::new();
        (0..3).for_each(|number| desk.make(u64::MAX, clue(number)));
        assert_eq!(desk.marks.standing().map(|(id, _)| id).collect::<Vec<_>>(), [0, 1, u64::MAX]);
        assert!(desk.withdraw(3, u64::MAX));
    }

    proptest! {
        #[test]
        fn any_order_of_arrival_gives_the_same_marks_and_belief(
            given in prop::collection::vec((0_u32..8, 0_u64..6, any::<bool>(), any::<bool>()), 1..12),
            seed in 0_usize..100,
        ) {
            // Two operators, who do not always know of each other, and make marks at other times.
            let mut desks = [Desk::new(), Desk::new()];
            let mut published = Vec::new();
            for (number, time, is_first, withdraws) in given {
                let desk = &mut desks[usize::from(is_first)];
                let time = 100 * time + u64::from(is_first);
                let first = desk.marks.iter().next().map(|(id, _)| id);
                match first {
                    Some(id) if withdraws => drop(desk.withdraw(time, id)),
                    _ => desk.make(time, if number % 2 == 0 { clue(number) } else { searched([number]) }),
                }
                published.push(desk.marks.clone());
            }
            let mut expected = Desk::new();
            for marks in &published {
                expected.receive(marks);
            }
            let mut other = Desk::new();
            let start = seed % published.len();
            published.rotate_left(start);
            for marks in published.iter().rev() {
                other.receive(marks);
            }
            prop_assert!(published.iter().all(|it| other.receive(it).is_none()), "nothing is news twice");
            prop_assert_eq!(&other.marks, &expected.marks);
            prop_assert_eq!(other.belief.digest(), expected.belief.digest());
        }
    }
}
