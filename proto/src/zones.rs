//! Zones: cells that the operator takes out of a running search, gossiped by all participants as the newest entry for each
//! cell.
//!
//! Zones say where robots plan. They are no evidence: belief, reach and the number of objects that are still expected
//! do not know of them, so that a cell that is opened again is as uncertain as it was.

use dragnet_search::cell::Cell;
use dragnet_search::terrain::{Ground, Terrain};

use crate::newest::Newest;

/// What the operator wants of robots in a cell. Of two simultaneous entries the later one here counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Zone {
    /// An earlier zone is lifted: the map alone counts.
    Open,
    /// They do not search it: they may cross it.
    Skip,
    /// They do not enter it, whether they drive or fly, and leave it if they are there. They search it from beside it.
    NoGo,
}

impl Zone {
    /// All zones.
    pub const ALL: [Self; 3] = [Self::Open, Self::Skip, Self::NoGo];

    /// Its number in messages.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::Open => 0,
            Self::Skip => 1,
            Self::NoGo => 2,
        }
    }

    /// The zone with this number in messages, if there is one.
    #[must_use]
    pub fn numbered(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|zone| zone.number() == number)
    }

    /// What is said of a number of cells in it: `is no-go`, `are skipped`.
    #[must_use]
    pub fn said_of(self, cells: usize) -> String {
        let is = if cells == 1 { "is" } else { "are" };
        let what = match self {
            Self::Open => "open again",
            Self::Skip => "skipped",
            Self::NoGo => "no-go",
        };
        format!("{is} {what}")
    }

    /// Ground as robots plan on it.
    const fn on(self, ground: Ground) -> Ground {
        match self {
            Self::Open => ground,
            Self::Skip => Ground { searched: false, ..ground },
            Self::NoGo => Ground { traversable: false, ..ground },
        }
    }
}

/// The zones that a participant knows, by cell. The default contains none.
pub type Zones = Newest<Cell, Zone>;

impl Zones {
    /// The cells in a zone, ascending.
    pub fn cells(&self, zone: Zone) -> impl Iterator<Item = Cell> + '_ {
        self.iter().filter(move |(_, entry)| entry.value == zone).map(|(cell, _)| cell)
    }

    /// A map as robots plan on it.
    #[must_use]
    pub fn on(&self, terrain: &Terrain) -> Terrain {
        terrain.with_ground(self.iter().map(|(cell, zone)| (cell, zone.value.on(terrain.ground(cell)))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zone_closes_or_skips_its_cells_until_they_are_opened() {
        let terrain = Terrain::from_ascii("....", 1.0).unwrap();
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        let mut zones = Zones::default();
        zones.give(1, cells[1], Zone::Skip);
        zones.give(1, cells[2], Zone::NoGo);
        assert_eq!(zones.on(&terrain), Terrain::from_ascii(".,~.", 1.0).unwrap());
        assert_eq!(zones.cells(Zone::NoGo).collect::<Vec<_>>(), [cells[2]]);
        zones.give(2, cells[1], Zone::Open);
        zones.give(2, cells[2], Zone::Open);
        assert_eq!(zones.on(&terrain), terrain);
    }

    #[test]
    fn a_zone_has_a_number() {
        assert_eq!(Zone::ALL.map(|zone| Zone::numbered(zone.number())), Zone::ALL.map(Some));
        assert_eq!(Zone::numbered(3), None);
    }
}
