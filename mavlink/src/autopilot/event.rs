//! Events and actions of an autopilot's state machine.

use mavlink_core::MavHeader;

use crate::MavMessage;
use crate::target::{Position, Target};

/// An event.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A message arrives, from whomever.
    Received(MavHeader, Box<MavMessage>),
    /// Something arrives that is no message; the reason.
    Unreadable(String),
    /// The vehicle is to go there.
    Go(Target),
    /// The vehicle is to stay where it is.
    Hold,
    /// A notice for the autopilot's ground station.
    Say(Notice),
    /// Time has passed: to be sent every 100 ms.
    Tick,
}

/// An action, to be carried out in order.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Send this message to the autopilot.
    Send(Box<MavMessage>),
    /// The vehicle's position, as the autopilot says.
    Position(Position),
    /// The last target cannot be reached; the reason.
    Failed(String),
    /// A fault begins, changes or ends, or control changes: for the log.
    Tell(Notice),
}

/// The severity of a notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Nothing is wrong, or not any more.
    Ok,
    /// The search goes on, with restrictions.
    Warning,
    /// The vehicle holds, or goes home.
    Error,
}

/// What happened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// The severity.
    pub level: Level,
    /// The subject: `link`, `identity`, `vehicle`, `control`, `position`, `battery`, `fence`, `target`, `start`, `input`.
    pub subject: String,
    /// What, in a sentence.
    pub message: String,
}
