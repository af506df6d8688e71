//! The contract of those who take part in a mission: an event goes in, effects come out.
//!
//! Robots and the coordinator are state machines. They know no clock, network or file: whoever drives them, in real time or in
//! simulation, gives the time with each event and carries the effects out.

use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Duration;

use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::observation::{Observation, RobotId};

use crate::command::Command;
use crate::message::{Activity, Audience, Message, SyncRequest};
use crate::validation::Rejected;

/// A robot or the coordinator.
pub trait StateMachine: Send {
    /// Handles an event at a time that the caller gives.
    ///
    /// # Errors
    /// Why the participant cannot go on, as when its disk is full.
    fn handle(
        &mut self,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError>;

    /// All observations that were to be kept are kept: it need not hold more than the last `held` of each origin, if
    /// whoever keeps the others answers for them ([`Effects::repeats`]). One that nobody keeps anything for holds all.
    fn release(&mut self, _held: NonZeroUsize) {}

    /// Whether a robot has found an object in a cell, as sure as the mission asks. The coordinator has not: it declares.
    fn is_found(&self, _cell: Cell) -> bool {
        false
    }

    /// Digest of its evidence.
    fn digest(&self) -> Digest;

    /// Number of observations known to it.
    fn observations(&self) -> u64;
}

/// Why a participant cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{who} cannot go on: {reason}")]
pub struct ParticipantError {
    /// Who.
    pub who: Participant,
    /// Why.
    pub reason: String,
}

/// An event of a participant. `M` is a message, or the number by which the simulator knows one.
///
/// Robots ignore commands and doubled numbers; the coordinator ignores what concerns a vehicle.
#[derive(Clone, Debug, PartialEq)]
pub enum Event<M> {
    /// The mission starts.
    Start,
    /// A robot stands in a cell, for the first time, after a move, or still, and took these readings.
    Sensed {
        /// Where it stands.
        cell: Cell,
        /// What it saw.
        readings: Vec<Reading>,
    },
    /// A message arrives.
    Received {
        /// Its publisher.
        from: Participant,
        /// The message.
        message: M,
    },
    /// The time that it asked for has come.
    Woke,
    /// Somebody has come to the network.
    Came,
    /// A robot has left the network.
    Lost(RobotId),
    /// A person asks for something, at the coordinator.
    Commanded(Command),
    /// Another process of this one's number is in the mission, and is the older one: the robot stays where it is.
    Halted,
    /// It may go on.
    Released,
    /// These are the robots now whose number several processes have.
    Doubled(BTreeSet<RobotId>),
}

/// The effects of an event, to be carried out in this order.
#[derive(Clone, Debug, PartialEq)]
pub struct Effects<M> {
    /// Observations that are new to it: to be written down before anything is published.
    pub kept: Vec<Arc<Observation>>,
    /// What it publishes, in order.
    pub published: Vec<(Audience, M)>,
    /// A robot's new route, if there is one: cells to enter from now on; without a cell, stay.
    pub route: Option<Vec<Cell>>,
    /// When to be woken, if nothing else happens before.
    pub wake_at: MissionTime,
    /// What a robot does; [`Activity::Searching`] of the coordinator, which nobody waits for.
    pub activity: Activity,
    /// How long the decision took that was made just now, if one was.
    pub decision: Option<Duration>,
    /// Questions for observations that it has released, to be answered from where they are kept.
    pub repeats: Vec<SyncRequest>,
    /// What it refused: it cannot be, or not from whom it came.
    pub refused: Vec<Rejected>,
}

/// Nothing is to be done, ever.
impl<M> Default for Effects<M> {
    fn default() -> Self {
        Self {
            kept: Vec::new(),
            published: Vec::new(),
            route: None,
            wake_at: MissionTime(u64::MAX),
            activity: Activity::Searching,
            decision: None,
            repeats: Vec::new(),
            refused: Vec::new(),
        }
    }
}
