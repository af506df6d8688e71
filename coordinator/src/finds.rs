//! Finds with what the operator has decided about them: declared objects, and those that were dismissed.

use std::collections::BTreeMap;
use std::fmt;

use dragnet_proto::message::Detection;
use dragnet_proto::verdict::{Decision, Verdicts};
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::Source;

use crate::fold::MissionFold;

/// A find.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Find {
    /// Its cell.
    pub cell: Cell,
    /// When it was declared, or dismissed if it is not declared any more.
    pub since: MissionTime,
    /// Whether it is declared. A dismissed find is declared again if enough new evidence speaks for it.
    pub is_declared: bool,
    /// The operator's decision, if there is one.
    pub operator: Option<Decision>,
}

/// Declared objects, in their order, and then dismissed ones that are not declared any more, by cell.
#[must_use]
pub fn finds(declared: &[Detection], verdicts: &Verdicts) -> Vec<Find> {
    let is_declared = |cell| declared.iter().any(|object| object.cell == cell);
    let found = declared.iter().map(|object| Find {
        cell: object.cell,
        since: MissionTime(object.time_ns),
        is_declared: true,
        operator: verdicts.decision(object.cell),
    });
    let dismissed = verdicts.iter().filter(|(_, verdict)| verdict.decision == Decision::Dismissed);
    let dismissed = dismissed.filter(|&(cell, _)| !is_declared(cell)).map(|(cell, verdict)| Find {
        cell,
        since: verdict.time(),
        is_declared: false,
        operator: Some(Decision::Dismissed),
    });
    found.chain(dismissed).collect()
}

/// Whose evidence made a cell reach the detection threshold, while it does.
#[derive(Clone, Debug)]
pub struct Finders {
    detection_threshold: f64,
    of: BTreeMap<Cell, Source>,
}

impl Finders {
    /// Before the first observation.
    #[must_use]
    pub const fn new(detection_threshold: f64) -> Self {
        Self { detection_threshold, of: BTreeMap::new() }
    }

    /// Credits evidence of these cells that the fold has just taken; a find that was dismissed keeps its finder.
    pub fn credit(&mut self, fold: &MissionFold, source: Source, cells: impl IntoIterator<Item = Cell>) {
        for cell in cells {
            if fold.belief().is_found(cell, self.detection_threshold) {
                self.of.entry(cell).or_insert(source);
            } else if fold.verdicts().decision(cell).is_none() {
                self.of.remove(&cell);
            }
        }
    }

    /// The finder of a cell.
    #[must_use]
    pub fn of(&self, cell: Cell) -> Option<Source> {
        self.of.get(&cell).copied()
    }
}

/// Numbers of finds, for reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FindCounts {
    /// Declared objects.
    pub declared: usize,
    /// Those of them that the operator has confirmed.
    pub confirmed: usize,
    /// Finds that the operator has dismissed and that are not declared any more.
    pub dismissed: usize,
}

impl FindCounts {
    /// The numbers of these finds.
    #[must_use]
    pub fn of(finds: &[Find]) -> Self {
        let count = |counts: &dyn Fn(&Find) -> bool| finds.iter().filter(|find| counts(find)).count();
        Self {
            declared: count(&|find| find.is_declared),
            confirmed: count(&|find| find.is_declared && find.operator == Some(Decision::Confirmed)),
            dismissed: count(&|find| !find.is_declared),
        }
    }

    /// Whether the operator has decided about a find.
    #[must_use]
    pub const fn has_verdicts(self) -> bool {
        self.confirmed + self.dismissed > 0
    }
}

impl fmt::Display for FindCounts {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} found", self.declared)?;
        if self.confirmed > 0 {
            write!(formatter, ", of them {} confirmed by hand", self.confirmed)?;
        }
        if self.dismissed > 0 {
            write!(formatter, "; {} dismissed", self.dismissed)?;
        }
        Ok(())
    }
}

/// From this probability on a find that nobody has confirmed is told without the advice to look.
const ALMOST_CERTAIN: f64 = 0.99;

/// A find of a subject in the words for who leads the search: what is declared is a probability, until a person has
/// looked.
#[must_use]
pub fn of_subject(place: &str, probability: f64, operator: Option<Decision>) -> String {
    // Rounded down: no find is certain.
    let percent = format!("{:.1} %", (1000.0 * probability).floor().min(999.0) / 10.0);
    match operator {
        Some(Decision::Confirmed) => format!("find ({percent}) at {place}, confirmed by hand"),
        Some(Decision::Dismissed) => {
            format!(
                "find ({percent}) at {place}, dismissed by hand and declared again by later readings: look again"
            )
        }
        Some(Decision::Undone) | None if probability < ALMOST_CERTAIN => {
            format!("probable find ({percent}) at {place}, not confirmed by hand: look before you stand down")
        }
        Some(Decision::Undone) | None => format!("find ({percent}) at {place}, not confirmed by hand"),
    }
}

#[cfg(test)]
mod tests {
    use dragnet_proto::verdict::Verdict;
    use dragnet_search::cell::Grid;

    use super::*;

    #[test]
    fn a_dismissed_find_is_listed_once_whether_or_not_it_is_declared_again() {
        let cell = |number| Grid::new(1, 5).unwrap().cell_numbered(number).unwrap();
        let object = |number| Detection { cell: cell(number), probability: 0.97, time_ns: number.into() };
        let verdict =
            |(number, decision)| (cell(number), Verdict { number: 50, decision, log_odds_units: 0 });
        let decided = [
            (1, Decision::Confirmed),
            (2, Decision::Dismissed),
            (3, Decision::Dismissed),
            (4, Decision::Undone),
        ];
        let finds = finds(&[0, 1, 2].map(object), &decided.map(verdict).into_iter().collect());
        let listed: Vec<_> =
            finds.iter().map(|it| (it.cell.number(), it.since.0, it.is_declared, it.operator)).collect();
        let (confirmed, dismissed) = (Some(Decision::Confirmed), Some(Decision::Dismissed));
        assert_eq!(
            listed,
            [(0, 0, true, None), (1, 1, true, confirmed), (2, 2, true, dismissed), (3, 50, false, dismissed)]
        );
        assert_eq!(FindCounts::of(&finds).to_string(), "3 found, of them 1 confirmed by hand; 1 dismissed");
        assert_eq!(FindCounts::of(&finds[..1]).to_string(), "1 found");
    }

    #[test]
    fn a_find_of_the_one_subject_is_probable_until_somebody_has_looked() {
        let check = |probability, operator, expected: &str| {
            let words = of_subject("[1, 2]", probability, operator);
            assert_eq!(words, expected);
        };
        let advice = "at [1, 2], not confirmed by hand: look before you stand down";
        check(0.98, None, &format!("probable find (98.0 %) {advice}"));
        check(0.989_99, Some(Decision::Undone), &format!("probable find (98.9 %) {advice}"));
        check(1.0, None, "find (99.9 %) at [1, 2], not confirmed by hand");
        check(0.98, Some(Decision::Confirmed), "find (98.0 %) at [1, 2], confirmed by hand");
        let again =
            "find (96.0 %) at [1, 2], dismissed by hand and declared again by later readings: look again";
        check(0.96, Some(Decision::Dismissed), again);
    }
}
