//! What the operator has told the team, as the messages of all participants pass it on.

use crate::directive::Directive;
use crate::marks::Marks;
use crate::message::{Heartbeat, Message, MissionStatus};
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
