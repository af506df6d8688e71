//! The contract between whoever drives a participant, real time or a simulator, and the participant's mind.

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
use crate::message::{Activity, Audience, LogRequest, Message};
use crate::plausible::Refused;

/// A participant without its clock and its network: told what happens, it says what it does.
pub trait Mind: Send {
    /// Takes in what happens; `now` comes from the caller.
    ///
    /// # Errors
    /// Why the participant cannot go on, as when its disk is full.
    fn experience(
        &mut self,
        now: MissionTime,
        stimulus: Stimulus<Message>,
    ) -> Result<Reaction<Message>, MindError>;

    /// All that it was to keep is kept: it need not hold more than the last so many observations of each origin, if
    /// whoever keeps the others answers for them ([`Reaction::repeats`]). One that nobody keeps anything for holds all.
    fn release(&mut self, _held: NonZeroUsize) {}

    /// Whether a robot has found an object in a cell, as sure as the mission asks; no coordinator has, which declares them.
    fn is_found(&self, _cell: Cell) -> bool {
        false
    }

    /// Digest of its evidence.
    fn digest(&self) -> Digest;

    /// Observations known to it.
    fn observations(&self) -> u64;
}

/// Why a participant cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{who} cannot go on: {reason}")]
pub struct MindError {
    /// Who.
    pub who: Participant,
    /// Why.
    pub reason: String,
}

/// What happens to a participant. `P` is a published message, or the name under which one is known.
#[derive(Clone, Debug, PartialEq)]
pub enum Stimulus<P> {
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
    Delivered {
        /// Who published it.
        from: Participant,
        /// The message.
        parcel: P,
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

/// What a participant does.
#[derive(Clone, Debug, PartialEq)]
pub struct Reaction<P> {
    /// Observations that are new to it: to be written down before anything is published.
    pub kept: Vec<Arc<Observation>>,
    /// What it publishes, in order.
    pub published: Vec<(Audience, P)>,
    /// A robot's new route, if there is one: cells to enter from now on; without a cell, stay.
    pub route: Option<Vec<Cell>>,
    /// When to be woken, if nothing else happens before.
    pub wake_at: MissionTime,
    /// What a robot does; [`Activity::Searching`] of the coordinator, which nobody waits for.
    pub activity: Activity,
    /// How long the decision took that was made just now, if one was.
    pub decision: Option<Duration>,
    /// Questions for observations that it has released, to be answered from where they are kept.
    pub repeats: Vec<LogRequest>,
    /// What it refused: it cannot be, or not from whom it came.
    pub refused: Vec<Refused>,
}
