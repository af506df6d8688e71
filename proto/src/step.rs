//! Messages between the simulator and a participant, one simulated event at a time.
//!
//! Messages between participants use their own keys; the simulator determines when each arrives, and refers to them by
//! number.

use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::observation::RobotId;

use crate::radio::Load;
use crate::state_machine::{Effects, Event};

/// An event of one participant, sent by the simulator.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// When, nanoseconds of mission time.
    pub time_ns: u64,
    /// The event.
    pub event: StepEvent,
}

/// The simulator's request.
#[derive(Clone, Debug, PartialEq)]
pub enum StepEvent {
    /// An event of [`crate::state_machine`]; a message is referred to by its sequence number in its sender's process.
    /// Only events that occur in simulated time can be encoded: there, no participant joins, is halted, is doubled or
    /// gets a command.
    Event(Event<u64>),
    /// No event; the digest of the evidence is requested.
    Report,
    /// The mission is over: the participant ends.
    Finish,
}

/// A participant's reply to a [`Step`].
#[derive(Clone, Debug, PartialEq)]
pub struct StepReply {
    /// The effects of the event. Those that do not concern the simulator are empty: stored, repeated and rejected
    /// observations.
    pub effects: Effects<MessageRef>,
    /// Digest of the participant's evidence, in answer to [`StepEvent::Report`]; 0 otherwise.
    pub digest: Digest,
    /// Observations known to the participant.
    pub observations: u64,
    /// Why the participant cannot continue; empty if it can.
    pub error: String,
}

/// One published message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MessageRef {
    /// Its number among the participant's messages.
    pub number: u64,
    /// Its kind, priority and size.
    pub load: Load,
}

/// Readings of a simulated sensor, sent to its robot, which makes an observation of them and numbers it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensed {
    /// The robot.
    pub robot: RobotId,
    /// When, nanoseconds of mission time.
    pub time_ns: u64,
    /// The robot's cell.
    pub from: Cell,
    /// The readings.
    pub readings: Vec<Reading>,
}
