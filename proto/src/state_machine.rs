//! The contract of a mission's participants: a state machine that turns an event into effects.
//!
//! Robots and the coordinator are state machines without clock, network or files: the caller, in real time or in
//! simulation, passes the time with each event and carries out the effects.

use std::collections::BTreeSet;
use std::fmt;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Duration;

use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::line_of_sight::LineOfSight;
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::{Observation, RobotId};
use dragnet_search::subjects::Standing;

use crate::command::Command;
use crate::message::{Activity, Audience, Message, SyncRequest};
use crate::picture::Picture;
use crate::validation::Rejected;

/// A robot or the coordinator.
pub trait StateMachine: Send {
    /// Handles an event at the caller's time.
    ///
    /// # Errors
    /// If the participant cannot continue, for example because its disk is full.
    fn handle(
        &mut self,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError>;

    /// Handles a message like [`Event::Received`], by reference: a message need not be copied for each of its
    /// receivers.
    ///
    /// # Errors
    /// As [`StateMachine::handle`].
    fn receive(
        &mut self,
        now: MissionTime,
        from: Participant,
        message: &Message,
    ) -> Result<Effects<Message>, ParticipantError> {
        self.handle(now, Event::Received { from, message: message.clone() })
    }

    /// Releases stored observations from memory: at most the last `held` of each origin are kept. To be called only
    /// when all observations are stored, by a caller that answers requests for the others ([`Effects::repeats`]). A
    /// participant without storage keeps all in memory.
    fn release(&mut self, _held: NonZeroUsize) {}

    /// Whether a cell's probability reaches the detection threshold of a robot. Always false for the coordinator, which
    /// declares objects instead.
    fn is_found(&self, _cell: Cell) -> bool {
        false
    }

    /// The position of the object that is declared in a cell, if a robot knows it.
    fn position(&self, _cell: Cell) -> Option<&ObjectPosition> {
        None
    }

    /// Whether the operator's mission is over: the coordinator ends. Robots never do by themselves.
    fn is_over(&self) -> bool {
        false
    }

    /// The robots that are not known to be back, if the operator's mission is ending and that is known here.
    fn awaited(&self) -> Option<Vec<RobotId>> {
        None
    }

    /// The cell that a robot was last in, as far as the coordinator knows.
    fn cell_of(&self, _robot: RobotId) -> Option<Cell> {
        None
    }

    /// Robots that have been under way for long without entering a cell, by number; robots know of none.
    fn standstills(&self) -> Vec<Standstill> {
        Vec::new()
    }

    /// What may not have been found, as far as the coordinator knows.
    fn left(&self) -> Option<Left> {
        None
    }

    /// Digest of its evidence.
    fn digest(&self) -> Digest;

    /// Number of known observations.
    fn observations(&self) -> u64;
}

/// A robot that has been under way for longer than usual without entering a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standstill {
    /// The robot.
    pub robot: RobotId,
    /// The cell that it is in.
    pub cell: Cell,
    /// For how long it was heard there.
    pub lasts: Duration,
}

/// What may not have been found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left {
    /// Objects expected in searched cells in reach that are not declared.
    pub in_reach: f64,
    /// The same of cells out of every robot's reach.
    pub out_of_reach: f64,
    /// How many cells are out of reach.
    pub cells_out_of_reach: usize,
    /// Where the subjects are, if their number is known.
    pub subjects: Option<Standing>,
}

impl fmt::Display for Left {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { in_reach, out_of_reach, cells_out_of_reach, subjects } = self;
        if let Some(standing) = subjects {
            return write!(formatter, "the {}: {standing}", standing.noun());
        }
        write!(formatter, "{in_reach:.2} more expected in reach")?;
        if *cells_out_of_reach > 0 {
            write!(formatter, ", {out_of_reach:.2} in {cells_out_of_reach} cells out of reach")?;
        }
        Ok(())
    }
}

/// Why a participant cannot continue.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{participant} cannot go on: {reason}")]
pub struct ParticipantError {
    /// The participant.
    pub participant: Participant,
    /// The reason.
    pub reason: String,
}

/// An event of a participant. `M` is a message, or the number by which the simulator refers to one.
///
/// Robots ignore commands, doubled numbers, pictures and what is said of their clock; the coordinator ignores a vehicle's events.
#[derive(Clone, Debug, PartialEq)]
pub enum Event<M> {
    /// The mission starts.
    Start,
    /// A robot has taken readings from a cell: at its start, after a move, or while it stands.
    Sensed {
        /// The robot's cell.
        cell: Cell,
        /// Its readings.
        readings: Vec<Reading>,
    },
    /// A robot's vehicle has found no way along its route, and stands; it senses next, in the same cell.
    RouteFailed {
        /// The cells that it could not enter.
        blocked: Vec<Cell>,
    },
    /// A robot's vehicle has come to doubt that these cells, which it does not observe now, are empty; an observation follows.
    Doubted {
        /// The cells.
        cells: Vec<Cell>,
    },
    /// A robot's vehicle knows which cells are hidden from which, by its own map too, or need no other observation from there.
    LineOfSight(LineOfSight),
    /// A robot's vehicle knows positions of objects that it declares, of each cell at most one; an observation follows, which
    /// carries them.
    Located(Vec<ObjectPosition>),
    /// A message arrives.
    Received {
        /// Its publisher.
        from: Participant,
        /// The message.
        message: M,
    },
    /// The time of [`Effects::wake_at`] has come.
    Woke,
    /// A participant has joined the network.
    Came,
    /// A robot has left the network.
    Lost(RobotId),
    /// The operator has given a command at the coordinator.
    Commanded(Command),
    /// Another process of this robot's number goes on: the robot stops.
    Halted,
    /// There is no older process any more: the robot continues.
    Released,
    /// Whether the robot's vehicle must return to its base: its battery is low, and is not charged yet.
    MustReturn(bool),
    /// The robots whose number is now used by several processes.
    Doubled(BTreeSet<RobotId>),
    /// A robot has sent a picture of a find.
    Pictured(Arc<Picture>),
    /// The participant's clock was set forward by this, because another has counted longer: what it dated before happened
    /// later than it says.
    ClockSet(Duration),
    /// The date of mission time 0, as the participant's clock knows it now. It is for people: nothing of the mission depends on it.
    Began {
        /// Unix time by the participant's computer, nanoseconds.
        unix_ns: i64,
    },
}

impl<M> Event<M> {
    /// The sender and message of [`Event::Received`].
    ///
    /// # Errors
    /// Any other event, converted to another message type, since it contains no message.
    pub fn into_message<N>(self) -> Result<(Participant, M), Event<N>> {
        Err(match self {
            Self::Received { from, message } => return Ok((from, message)),
            Self::Start => Event::Start,
            Self::Sensed { cell, readings } => Event::Sensed { cell, readings },
            Self::RouteFailed { blocked } => Event::RouteFailed { blocked },
            Self::Doubted { cells } => Event::Doubted { cells },
            Self::LineOfSight(seen) => Event::LineOfSight(seen),
            Self::Located(positions) => Event::Located(positions),
            Self::Woke => Event::Woke,
            Self::Came => Event::Came,
            Self::Lost(robot) => Event::Lost(robot),
            Self::Commanded(command) => Event::Commanded(command),
            Self::Halted => Event::Halted,
            Self::Released => Event::Released,
            Self::MustReturn(must) => Event::MustReturn(must),
            Self::Doubled(robots) => Event::Doubled(robots),
            Self::Pictured(picture) => Event::Pictured(picture),
            Self::ClockSet(by) => Event::ClockSet(by),
            Self::Began { unix_ns } => Event::Began { unix_ns },
        })
    }
}

/// The effects of an event, to be carried out in the order of the fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Effects<M> {
    /// New observations, to be stored before anything is published.
    pub kept: Vec<Arc<Observation>>,
    /// Published messages, in order.
    pub published: Vec<(Audience, M)>,
    /// A robot's new path, if it changes: cells to enter, in order; empty to stay.
    pub route: Option<Vec<Cell>>,
    /// When to wake the participant if no event happens before.
    pub wake_at: MissionTime,
    /// The robot's activity; always [`Activity::Searching`] for the coordinator.
    pub activity: Activity,
    /// Computing time of the decision, if one was made.
    pub decision: Option<Duration>,
    /// Requests for released observations, to be answered from where they are stored.
    pub repeats: Vec<SyncRequest>,
    /// Rejected messages and observations.
    pub rejected: Vec<Rejected>,
}

/// No effects, and no time to wake.
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
            rejected: Vec::new(),
        }
    }
}

impl<M> Effects<M> {
    /// The effects with each message converted.
    #[must_use]
    pub fn map<N>(self, replace: impl Fn(M) -> N) -> Effects<N> {
        let published = self.published.into_iter().map(|(audience, message)| (audience, replace(message)));
        Effects {
            kept: self.kept,
            published: published.collect(),
            route: self.route,
            wake_at: self.wake_at,
            activity: self.activity,
            decision: self.decision,
            repeats: self.repeats,
            rejected: self.rejected,
        }
    }
}
