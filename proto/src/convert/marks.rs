//! The operator's marks to the wire and back: their cells travel as runs.

use std::collections::BTreeSet;
use std::sync::Arc;

use dragnet_search::cell::Cell;
use dragnet_search::mark::{Clue, Mark, Searched};
use dragnet_search::observation::Source;

use super::check::Check;
use super::error::ConvertError;
use super::field::Place;
use crate::dragnet_msgs as wire;
use crate::marks::{MarkId, Marked, Marks};
use crate::message::MarkReport;
use crate::newest::Numbered;
use crate::runs::runs;

const CLUE: u8 = 0;
const SEARCHED: u8 = 1;

impl From<&MarkReport> for wire::Marks {
    fn from(report: &MarkReport) -> Self {
        let MarkReport { from, time_ns, marks } = report;
        Self {
            version: wire::VERSION,
            robot: Source::from(*from).number(),
            time_ns: *time_ns,
            marks: marks.iter().map(|(id, entry)| mark(id, &entry)).collect(),
        }
    }
}

fn mark(id: MarkId, Numbered { number, value }: &Numbered<Arc<Marked>>) -> wire::Mark {
    let Marked { is_withdrawn, mark, note } = &**value;
    let (kind, strength, radius, cells) = match mark {
        Mark::Clue(clue) => {
            (CLUE, clue.ratio_thousandths, clue.radius_hundredths, &BTreeSet::from([clue.cell]))
        }
        Mark::Searched(search) => (SEARCHED, search.pod_thousandths.into(), 0, &search.cells),
    };
    let runs = runs(cells.iter().map(|&cell| (cell, ())));
    let (firsts, counts) = runs.into_iter().map(|run| (run.first, run.count)).unzip();
    wire::Mark {
        version: wire::VERSION,
        id,
        number: *number,
        withdrawn: *is_withdrawn,
        kind,
        strength,
        radius,
        firsts,
        counts,
        note: note.clone(),
    }
}

impl Check {
    pub(super) fn marks(self, wire: &wire::Marks) -> Result<MarkReport, ConvertError> {
        self.version(wire.version)?;
        self.at_most(Marks::OPERATORS * Marks::MOST, "marks", wire.marks.len())?;
        self.ascending("marks", &wire.marks.iter().map(|mark| mark.id).collect::<Vec<_>>())?;
        let mut cells_left = Marks::OPERATORS * Marks::most_cells(self.grid);
        let marks = wire.marks.iter().enumerate();
        let marks = marks.map(|(index, wire)| self.within(Place::Mark(index)).mark(wire, &mut cells_left));
        let marks = marks.collect::<Result<Marks, _>>()?;
        Ok(MarkReport { from: Source::numbered(wire.robot).into(), time_ns: wire.time_ns, marks })
    }

    fn mark(
        self,
        wire: &wire::Mark,
        cells_left: &mut usize,
    ) -> Result<(MarkId, Numbered<Arc<Marked>>), ConvertError> {
        self.version(wire.version)?;
        self.at_most(Marked::MAX_NOTE_BYTES, "note", wire.note.len())?;
        let cells = self.marked_cells(wire, cells_left)?;
        let mark = match (wire.kind, &cells[..]) {
            (CLUE, &[cell]) => Mark::Clue(Clue {
                cell,
                ratio_thousandths: self.within_range(
                    "strength",
                    wire.strength,
                    Clue::RATIO_THOUSANDTHS,
                    "1001 to 1000000 of a clue",
                )?,
                radius_hundredths: self.within_range(
                    "radius",
                    wire.radius,
                    0..=Clue::MAX_RADIUS_HUNDREDTHS,
                    "0 to 10000",
                )?,
            }),
            (SEARCHED, &[_, ..]) => {
                let pod = u16::try_from(wire.strength).unwrap_or(u16::MAX);
                let allowed = "1 to 999 of a search";
                let pod_thousandths =
                    self.within_range("strength", pod, Searched::POD_THOUSANDTHS, allowed)?;
                Mark::Searched(Searched { cells: cells.into_iter().collect(), pod_thousandths })
            }
            (CLUE | SEARCHED, _) => {
                let (at, found) = (self.at("counts"), cells.len() as f64);
                return Err(ConvertError::Number {
                    at,
                    found,
                    allowed: "1 cell of a clue, and any of a search",
                });
            }
            (found, _) => {
                let allowed = "0 clue, 1 searched";
                return Err(ConvertError::Alternative { at: self.at("kind"), found, allowed });
            }
        };
        let marked = Marked { is_withdrawn: wire.withdrawn, mark, note: wire.note.clone() };
        Ok((wire.id, Numbered { number: wire.number, value: Arc::new(marked) }))
    }

    fn marked_cells(self, wire: &wire::Mark, left: &mut usize) -> Result<Vec<Cell>, ConvertError> {
        let mut cells = Vec::new();
        let runs = self.runs(&wire.firsts, &wire.counts)?;
        for (index, (run, &count)) in runs.into_iter().zip(&wire.counts).enumerate() {
            let most = *left;
            *left = most.checked_sub(count as usize).ok_or(ConvertError::TooMany {
                at: self.at_entry("counts", index),
                found: count as usize,
                most,
            })?;
            cells.extend(self.cells(run));
        }
        Ok(cells)
    }

    fn within_range<N: Copy + PartialOrd + Into<f64>>(
        self,
        name: &'static str,
        found: N,
        range: std::ops::RangeInclusive<N>,
        allowed: &'static str,
    ) -> Result<N, ConvertError> {
        if range.contains(&found) {
            Ok(found)
        } else {
            Err(ConvertError::Number { at: self.at(name), found: found.into(), allowed })
        }
    }
}
