//! What the simulator and a participant say to each other, one simulated event at a time.
//!
//! Messages between participants travel on their own keys; the simulator says when each arrives. It knows them by their
//! numbers.

use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::observation::RobotId;

use crate::message::{Activity, Audience, MessageKind};
use crate::state_machine::Event;

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
    /// Messages published in this step, in order.
    pub published: Vec<MessageRef>,
    /// A new route, if there is one: cells to enter from now on; empty means rest.
    pub route: Option<Vec<Cell>>,
    /// When to be woken, nanoseconds of mission time, above 0; `None` means never.
    pub wake_at_ns: Option<u64>,
    /// What the robot does; [`Activity::Searching`] for the coordinator.
    pub activity: Activity,
    /// Computing time of the decision made in this step, seconds; 0 if none was.
    pub decision_seconds: f64,
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
    /// To whom it goes.
    pub to: Audience,
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
