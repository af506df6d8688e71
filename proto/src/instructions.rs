//! What the operator has told the team, as the messages of all participants pass it on.

use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;

use crate::directive::Directive;
use crate::marks::Marks;
use crate::message::{Heartbeat, MarkReport, Message, MissionStatus, OrderReport, VerdictReport, ZoneReport};
use crate::orders::RobotOrders;
use crate::verdict::Verdicts;
use crate::zones::Zones;

/// What the operator has told the team, as far as one message passes it on. Two messages with equal instructions pass on the
/// same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instructions<'a> {
    /// To all robots.
    Directive(&'a Directive),
    /// About finds.
    Verdicts(&'a Verdicts),
    /// To single robots.
    Orders(&'a RobotOrders),
    /// Areas to be skipped or not entered.
    Zones(&'a Zones),
    /// What was found or searched by others.
    Marks(&'a Marks),
}

/// The messages in which a participant passes on the instructions that it knows, without those of which there are none. The
/// directive is in heartbeats and statuses.
pub fn passed_on(
    from: Participant,
    now: MissionTime,
    (verdicts, orders): (&Verdicts, &RobotOrders),
    (zones, marks): (&Zones, &Marks),
) -> impl Iterator<Item = Message> + use<> {
    let time_ns = now.0;
    let verdicts = (!verdicts.is_empty())
        .then(|| Message::Verdicts(VerdictReport { from, time_ns, verdicts: verdicts.clone() }));
    let orders =
        (!orders.is_empty()).then(|| Message::Orders(OrderReport { from, time_ns, orders: orders.clone() }));
    let zones =
        (!zones.is_empty()).then(|| Message::Zones(ZoneReport { from, time_ns, zones: zones.clone() }));
    let marks =
        (!marks.is_empty()).then(|| Message::Marks(MarkReport { from, time_ns, marks: marks.clone() }));
    [verdicts, orders, zones, marks].into_iter().flatten()
}

impl Message {
    /// The operator's instructions in this message, if there are any.
    #[must_use]
    pub fn instructions(&self) -> Option<Instructions<'_>> {
        match self {
            Self::Heartbeat(Heartbeat { directive, .. })
            | Self::MissionStatus(MissionStatus { directive, .. }) => {
                (*directive != Directive::default()).then_some(Instructions::Directive(directive))
            }
            Self::Verdicts(report) => Some(Instructions::Verdicts(&report.verdicts)),
            Self::Orders(report) => Some(Instructions::Orders(&report.orders)),
            Self::Zones(report) => Some(Instructions::Zones(&report.zones)),
            Self::Marks(report) => Some(Instructions::Marks(&report.marks)),
            Self::Observation(_) | Self::Intent(_) | Self::SyncRequest(_) | Self::SyncReply(_) => None,
        }
    }
}
