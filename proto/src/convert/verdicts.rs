//! The operator's verdicts to the wire and back.

use dragnet_search::cell::Cell;
use dragnet_search::observation::Source;

use super::check::Check;
use super::error::ConvertError;
use crate::dragnet_msgs as wire;
use crate::message::VerdictReport;
use crate::verdict::{Decision, Verdict, Verdicts};

impl From<&VerdictReport> for wire::Verdicts {
    fn from(report: &VerdictReport) -> Self {
        let VerdictReport { from, time_ns, verdicts } = report;
        Self {
            version: wire::VERSION,
            robot: Source::from(*from).number(),
            time_ns: *time_ns,
            cells: verdicts.iter().map(|(cell, _)| cell.number()).collect(),
            numbers: verdicts.iter().map(|(_, verdict)| verdict.number).collect(),
            decisions: verdicts.iter().map(|(_, verdict)| verdict.decision.number()).collect(),
            log_odds: verdicts.iter().map(|(_, verdict)| verdict.log_odds_units).collect(),
        }
    }
}

impl Check {
    pub(super) fn verdicts(self, wire: &wire::Verdicts) -> Result<VerdictReport, ConvertError> {
        self.version(wire.version)?;
        let expected = wire.cells.len();
        self.at_most(self.grid.cell_count(), "cells", expected)?;
        self.same_length("numbers", wire.numbers.len(), "cells", expected)?;
        self.same_length("decisions", wire.decisions.len(), "cells", expected)?;
        self.same_length("log_odds", wire.log_odds.len(), "cells", expected)?;
        self.ascending("cells", &wire.cells)?;
        let verdicts =
            (0..expected).map(|index| self.verdict(index, wire)).collect::<Result<Verdicts, _>>()?;
        let from = Source::numbered(wire.robot).into();
        Ok(VerdictReport { from, time_ns: wire.time_ns, verdicts })
    }

    fn verdict(self, index: usize, wire: &wire::Verdicts) -> Result<(Cell, Verdict), ConvertError> {
        let cell = self.cell(self.at_entry("cells", index), wire.cells[index])?;
        let found = wire.decisions[index];
        let decision = Decision::numbered(found).ok_or(ConvertError::Alternative {
            at: self.at_entry("decisions", index),
            found,
            allowed: "0 undone, 1 dismissed, 2 confirmed",
        })?;
        let log_odds_units = wire.log_odds[index];
        if !Verdict::allows(decision, log_odds_units) {
            return Err(ConvertError::Number {
                at: self.at_entry("log_odds", index),
                found: log_odds_units as f64,
                allowed: "0 if undone, 2^61 if confirmed, -2^61 to -1 if dismissed",
            });
        }
        Ok((cell, Verdict { number: wire.numbers[index], decision, log_odds_units }))
    }
}
