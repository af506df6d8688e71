//! The operator's zones to the wire and back: their cells travel as runs.

use dragnet_search::cell::Cell;
use dragnet_search::observation::Source;

use super::check::Check;
use super::error::ConvertError;
use crate::dragnet_msgs as wire;
use crate::message::ZoneReport;
use crate::newest::Numbered;
use crate::runs::runs;
use crate::zones::{Zone, Zones};

impl From<&ZoneReport> for wire::Zones {
    fn from(report: &ZoneReport) -> Self {
        let ZoneReport { from, time_ns, zones } = report;
        let (robot, time_ns) = (Source::from(*from).number(), *time_ns);
        let mut wire = Self { version: wire::VERSION, robot, time_ns, ..Self::default() };
        for run in runs(zones.iter()) {
            wire.firsts.push(run.first);
            wire.counts.push(run.count);
            wire.numbers.push(run.value.number);
            wire.zones.push(run.value.value.number());
        }
        wire
    }
}

impl Check {
    pub(super) fn zones(self, wire: &wire::Zones) -> Result<ZoneReport, ConvertError> {
        self.version(wire.version)?;
        let expected = wire.firsts.len();
        let runs = self.runs(&wire.firsts, &wire.counts)?;
        self.same_length("numbers", wire.numbers.len(), "firsts", expected)?;
        self.same_length("zones", wire.zones.len(), "firsts", expected)?;
        let mut zones: Vec<(Cell, Numbered<Zone>)> = Vec::new();
        for (index, run) in runs.into_iter().enumerate() {
            let found = wire.zones[index];
            let value = Zone::numbered(found).ok_or_else(|| {
                let allowed = "0 open, 1 skip, 2 no-go";
                ConvertError::Alternative { at: self.at_entry("zones", index), found, allowed }
            })?;
            let entry = Numbered { number: wire.numbers[index], value };
            zones.extend(self.cells(run).map(|cell| (cell, entry)));
        }
        let zones: Zones = zones.into_iter().collect();
        Ok(ZoneReport { from: Source::numbered(wire.robot).into(), time_ns: wire.time_ns, zones })
    }
}
