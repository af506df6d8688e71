//! The directive to the wire and back: its cells travel as runs.

use std::ops::{Range, RangeInclusive};

use dragnet_search::cell::Cell;

use super::check::Check;
use super::error::ConvertError;
use super::field::Place;
use crate::directive::{Directive, TeamOrder};
use crate::dragnet_msgs as wire;
use crate::runs::runs;

impl From<&Directive> for wire::Directive {
    fn from(directive: &Directive) -> Self {
        let Directive { number, order, added } = directive;
        let runs = runs(added.iter().map(|&cell| (cell, ())));
        let (firsts, counts) = runs.into_iter().map(|run| (run.first, run.count)).unzip();
        Self { version: wire::VERSION, number: *number, order: code(*order), firsts, counts }
    }
}

const fn code(order: TeamOrder) -> u8 {
    match order {
        TeamOrder::Search => 0,
        TeamOrder::Pause => 1,
        TeamOrder::Return => 2,
        TeamOrder::End => 3,
    }
}

impl Check {
    pub(super) fn directive(self, wire: &wire::Directive) -> Result<Directive, ConvertError> {
        let check = self.within(Place::Directive);
        check.version(wire.version)?;
        let runs = check.runs(&wire.firsts, &wire.counts)?;
        let added = runs.into_iter().flat_map(|run| check.cells(run)).collect();
        Ok(Directive { number: wire.number, order: check.order(wire.order)?, added })
    }

    fn order(self, found: u8) -> Result<TeamOrder, ConvertError> {
        [TeamOrder::Search, TeamOrder::Pause, TeamOrder::Return, TeamOrder::End]
            .into_iter()
            .find(|&order| code(order) == found)
            .ok_or_else(|| {
                let allowed = "0 search, 1 pause, 2 return, 3 end";
                ConvertError::Alternative { at: self.at("order"), found, allowed }
            })
    }

    /// The numbers of each run of cells, all on the map: runs that ascend and stay on it are no more cells than it has.
    pub(super) fn runs(
        self,
        firsts: &[u32],
        counts: &[u32],
    ) -> Result<Vec<RangeInclusive<u32>>, ConvertError> {
        self.same_length("counts", counts.len(), "firsts", firsts.len())?;
        let mut next = 0;
        let runs = firsts.iter().zip(counts).enumerate().map(|(index, (&first, &count))| {
            let run = self.run(index, next..first, count)?;
            next = *run.end() + 1;
            Ok(run)
        });
        runs.collect()
    }

    /// The cells of a run.
    pub(super) fn cells(self, run: RangeInclusive<u32>) -> impl Iterator<Item = Cell> {
        run.filter_map(move |number| self.grid.cell_numbered(number))
    }

    /// The numbers of one run of cells, all on the map. `gap` counts from the earliest start of this one.
    fn run(self, index: usize, gap: Range<u32>, count: u32) -> Result<RangeInclusive<u32>, ConvertError> {
        let first = gap.end;
        if first < gap.start {
            let (found, before) = (first.into(), gap.start.into());
            return Err(ConvertError::Order { at: self.at_entry("firsts", index), found, before });
        }
        let last = first.saturating_add(count.saturating_sub(1));
        self.cell(self.at_entry("firsts", index), first)?;
        self.cell(self.at_entry("counts", index), last)?;
        if count == 0 {
            let at = self.at_entry("counts", index);
            return Err(ConvertError::Number { at, found: 0.0, allowed: "runs of at least 1 cell" });
        }
        Ok(first..=last)
    }
}
