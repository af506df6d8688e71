//! Finds, orders, zones, marks and verdicts that the coordinator shows for the first time: they are of now, or robots knew them.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use dragnet_proto::directive::{Directive, TeamOrder};
use dragnet_proto::marks::{MarkId, Marked, Marks};
use dragnet_proto::message::{Detection, MissionStatus};
use dragnet_proto::newest::Numbered;
use dragnet_proto::orders::{NumberedOrder, RobotOrders};
use dragnet_proto::verdict::{Verdict, Verdicts};
use dragnet_proto::zones::{Zone, Zones};
use dragnet_scenario::Places;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;

/// When that was what the coordinator shows for the first time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Given {
    /// Now.
    Now,
    /// Before: a coordinator that has started again has learned it from robots.
    Before(MissionTime),
    /// It was shown already, and is dated anew: robots knew the same of a later time, or another order that it replaces.
    Anew(MissionTime),
}

impl Given {
    /// An order or verdict has the time at which it was given as its number, or a later one if the clock was behind.
    fn at(number: u64, shown: MissionTime) -> Self {
        if number < shown.0 { Self::Before(MissionTime(number)) } else { Self::Now }
    }

    fn or_anew(self, is_known: bool) -> Self {
        match self {
            Self::Before(time) if is_known => Self::Anew(time),
            given => given,
        }
    }
}

/// The order to all robots, if it is news in a status that the coordinator shows at a time; `before` is that of the
/// status before.
#[must_use]
pub fn to_all(before: (u64, TeamOrder), directive: &Directive, shown: MissionTime) -> Option<Given> {
    let (number, order) = directive.numbered_order();
    let is_known = before.0 > 0 && before.1 == order;
    (before != (number, order)).then(|| Given::at(number, shown).or_anew(is_known))
}

/// Cells that a directive adds to the search area and that were not told before, in words; none if there are none. When those
/// were added that robots knew of is not known.
#[must_use]
pub fn added(told: &mut BTreeSet<Cell>, directive: &Directive, places: &Places) -> Option<String> {
    let new: BTreeSet<Cell> = directive.added.difference(told).copied().collect();
    told.extend(&new);
    (!new.is_empty()).then(|| format!("added to the search by the operator: {}", places.some(&new)))
}

/// Orders to single robots that are news in a report that the coordinator shows at a time.
pub fn to_robots(
    before: &RobotOrders,
    after: &RobotOrders,
    shown: MissionTime,
) -> impl Iterator<Item = (RobotId, NumberedOrder, Given)> {
    let new = after.iter().filter(|(robot, order)| !before.includes(*robot, order));
    new.map(move |(robot, order)| {
        let is_known = before.of(robot) == Some(order.value);
        (robot, order, Given::at(order.number, shown).or_anew(is_known))
    })
}

/// Zones that are news in a report that the coordinator shows at a time, each with its cells.
pub fn zones(
    before: &Zones,
    after: &Zones,
    shown: MissionTime,
) -> impl Iterator<Item = (Numbered<Zone>, BTreeSet<Cell>, Given)> {
    let mut new: BTreeMap<Numbered<Zone>, BTreeSet<Cell>> = BTreeMap::new();
    for (cell, zone) in after.iter().filter(|(cell, zone)| !before.includes(*cell, zone)) {
        new.entry(zone).or_default().insert(cell);
    }
    new.into_iter().map(move |(zone, cells)| {
        let is_known = cells.iter().all(|&cell| before.of(cell) == Some(zone.value));
        (zone, cells, Given::at(zone.number, shown).or_anew(is_known))
    })
}

/// Marks that are news in a report that the coordinator shows at a time: made, or withdrawn.
pub fn marks(
    before: &Marks,
    after: &Marks,
    shown: MissionTime,
) -> impl Iterator<Item = (MarkId, Numbered<Arc<Marked>>, Given)> {
    let new = after.iter().filter(|(id, entry)| !before.includes(*id, entry));
    new.map(move |(id, entry)| {
        let given = Given::at(entry.number, shown);
        (id, entry, given)
    })
}

/// Objects that a status declares and the one before did not; `before` are the cells of those.
pub fn declared<'a>(
    before: &'a BTreeSet<Cell>,
    status: &'a MissionStatus,
) -> impl Iterator<Item = (&'a Detection, Given)> {
    let new = status.declared.iter().filter(|object| !before.contains(&object.cell));
    new.map(|object| (object, Given::at(object.time_ns, MissionTime(status.time_ns))))
}

/// Verdicts that are news in a report that the coordinator shows at a time.
pub fn verdicts(
    before: &Verdicts,
    after: &Verdicts,
    shown: MissionTime,
) -> impl Iterator<Item = (Cell, Verdict, Given)> {
    let new = after.iter().filter(|&(cell, verdict)| !before.includes(cell, verdict));
    new.map(move |(cell, verdict)| (cell, verdict, Given::at(verdict.number, shown)))
}

#[cfg(test)]
mod tests {
    use dragnet_search::terrain::Terrain;

    use super::TeamOrder::{Pause, Search};
    use super::*;

    #[test]
    fn cells_that_are_added_are_told_once() {
        let terrain = Terrain::from_ascii("....", 5.0).unwrap();
        let (places, mut told) = (Places::new(&terrain, None), BTreeSet::new());
        let mut tell = |numbers: &[u32]| {
            let cell = |&number: &u32| terrain.grid().cell_numbered(number).unwrap();
            let directive = Directive { added: numbers.iter().map(cell).collect(), ..Directive::default() };
            added(&mut told, &directive, &places)
        };
        assert_eq!(tell(&[]), None);
        assert_eq!(tell(&[1]).unwrap(), "added to the search by the operator: cell [0, 1]");
        assert_eq!(tell(&[1, 2, 3]).unwrap(), "added to the search by the operator: 2 cells around [0, 2]");
        assert_eq!(tell(&[1, 2, 3]), None);
    }

    #[test]
    fn a_number_before_the_time_at_which_it_is_shown_was_given_before() {
        let check = |before, (number, order), expected| {
            let directive = Directive { number, order, ..Directive::default() };
            assert_eq!(to_all(before, &directive, MissionTime(100)), expected, "{before:?} {directive:?}");
        };
        check((0, Search), (0, Search), None);
        check((0, Search), (100, Pause), Some(Given::Now));
        check((0, Search), (30, Pause), Some(Given::Before(MissionTime(30))));
        check((0, Search), (30, Search), Some(Given::Before(MissionTime(30))));
        check((3, Pause), (31, Pause), Some(Given::Anew(MissionTime(31))));
        check((30, Pause), (100, Pause), Some(Given::Now));
        // The coordinator's clock is behind.
        check((300, Pause), (301, Search), Some(Given::Now));
        check((300, Pause), (300, Pause), None);
    }
}
