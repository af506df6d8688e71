//! What the simulator and a participant say to each other, one simulated event at a time.
//!
//! Messages between participants travel on their own keys; the simulator says when each arrives. It knows them by their
//! numbers.

use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::observation::RobotId;

use crate::message::MessageKind;
use crate::state_machine::{Effects, Event};

/// The simulator tells one participant what happens to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// When, nanoseconds of mission time.
    pub time_ns: u64,
    /// What.
    pub event: StepEvent,
}

/// What the simulator tells a participant.
#[derive(Clone, Debug, PartialEq)]
pub enum StepEvent {
    /// An event of the contract; messages are known by their numbers among their sender's. Only events that happen in
    /// simulated time have bytes: nobody comes, is halted, doubled or commanded there.
    Event(Event<u64>),
    /// Nothing happens; the digest of its evidence is asked for.
    Report,
    /// The mission is over: leave.
    Finish,
}

/// What a participant does in answer to a [`Step`].
#[derive(Clone, Debug, PartialEq)]
pub struct StepReply {
    /// The effects of the event, without what does not concern the simulator: what is kept, to be repeated, or refused.
    pub effects: Effects<MessageRef>,
    /// Digest of the participant's evidence, in answer to [`StepEvent::Report`]; 0 otherwise.
    pub digest: Digest,
    /// Observations known to the participant.
    pub observations: u64,
    /// Why the participant cannot go on; empty if it can.
    pub error: String,
}

/// One published message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MessageRef {
    /// Its number among the messages of the participant.
    pub number: u64,
    /// What it is.
    pub kind: MessageKind,
}

/// What a simulated sensor has seen, told to its robot. Not yet an observation: the robot numbers those.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensed {
    /// Whose sensor.
    pub robot: RobotId,
    /// When, nanoseconds of mission time.
    pub time_ns: u64,
    /// Where the robot is.
    pub from: Cell,
    /// What it saw.
    pub readings: Vec<Reading>,
}
