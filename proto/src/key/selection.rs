//! Sets of keys to subscribe to.

use std::fmt;

use dragnet_scenario::participant::Participant;

use super::{Address, Home};

/// A set of keys of a mission. [`super::Mission::expression`] converts it to a key expression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selection {
    /// All robots' observations.
    Observations,
    /// All robots' plans.
    Intents,
    /// All robots' heartbeats.
    Heartbeats,
    /// The operator's verdicts as all robots and the coordinator know them.
    Verdicts,
    /// The operator's orders to single robots as all robots and the coordinator know them.
    Orders,
    /// The operator's zones as all robots and the coordinator know them.
    Zones,
    /// The operator's marks as all robots and the coordinator know them.
    Marks,
    /// All robots' pictures of finds.
    Pictures,
    /// Liveliness tokens of all robots and the coordinator.
    Alive,
    /// Liveliness tokens that tell the scenarios of all robots and the coordinator.
    Scenarios,
    /// Requests addressed to a participant.
    SyncRequestsTo(Participant),
    /// Replies addressed to a participant.
    SyncRepliesTo(Participant),
    /// All messages that a participant publishes.
    PublishedBy(Participant),
    /// All messages and queries of the simulator.
    Simulator,
    /// All keys.
    Everything,
}

impl fmt::Display for Selection {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Observations => formatter.write_str("robots/*/observation"),
            Self::Intents => formatter.write_str("robots/*/intent"),
            Self::Heartbeats => formatter.write_str("robots/*/heartbeat"),
            Self::Verdicts => formatter.write_str("**/verdicts"),
            Self::Orders => formatter.write_str("**/orders"),
            Self::Zones => formatter.write_str("**/zones"),
            Self::Marks => formatter.write_str("**/marks"),
            Self::Pictures => formatter.write_str("robots/*/picture"),
            Self::Alive => formatter.write_str("**/alive/*/*"),
            Self::Scenarios => formatter.write_str("**/scenario/*"),
            Self::SyncRequestsTo(to) => write!(formatter, "**/sync_request/{}", Address(to)),
            Self::SyncRepliesTo(to) => write!(formatter, "**/sync_reply/{}", Address(to)),
            Self::PublishedBy(participant) => write!(formatter, "{}/**", Home(participant)),
            Self::Simulator => formatter.write_str("sim/**"),
            Self::Everything => formatter.write_str("**"),
        }
    }
}
