//! What robots, coordinator and simulator say to each other, in the types of [`dragnet_search`].
//!
//! [`crate::convert`] turns these into the ROS 2 messages of [`crate::dragnet_msgs`] and checks them on the way back: cells on
//! the map, readings in range, lengths bounded. A message in hand is well formed.

use std::sync::Arc;

use dragnet_scenario::participant::Participant;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::observation::{Observation, Origin, RobotId, Version};

use crate::directive::Directive;

/// To whom a message goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Audience {
    /// Everybody.
    All,
    /// One participant.
    One(Participant),
}

/// A message of one participant to the others.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// To all: what a robot saw, or a person marked.
    Observation(Arc<Observation>),
    /// To all: where a robot is going.
    Intent(Intent),
    /// To all, periodically: who is there, and what it knows.
    Heartbeat(Heartbeat),
    /// To one: please repeat what I miss.
    SyncRequest(SyncRequest),
    /// To one: what was missed.
    SyncReply(SyncReply),
    /// From the coordinator to all: how the mission stands.
    MissionStatus(MissionStatus),
}

impl Message {
    /// What kind of message this is.
    #[must_use]
    pub const fn kind(&self) -> MessageKind {
        match self {
            Self::Observation(_) => MessageKind::Observation,
            Self::Intent(_) => MessageKind::Intent,
            Self::Heartbeat(_) => MessageKind::Heartbeat,
            Self::SyncRequest(_) => MessageKind::SyncRequest,
            Self::SyncReply(_) => MessageKind::SyncReply,
            Self::MissionStatus(_) => MessageKind::MissionStatus,
        }
    }
}

/// The kinds of [`Message`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MessageKind {
    /// [`Message::Observation`].
    Observation,
    /// [`Message::Intent`].
    Intent,
    /// [`Message::Heartbeat`].
    Heartbeat,
    /// [`Message::SyncRequest`].
    SyncRequest,
    /// [`Message::SyncReply`].
    SyncReply,
    /// [`Message::MissionStatus`].
    MissionStatus,
}

impl MessageKind {
    /// Every kind.
    pub const ALL: [Self; 6] = [
        Self::Observation,
        Self::Intent,
        Self::Heartbeat,
        Self::SyncRequest,
        Self::SyncReply,
        Self::MissionStatus,
    ];
}

/// A robot's plan. Each replaces the one before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Intent {
    /// Whose plan.
    pub robot: RobotId,
    /// Of which of its starts, as in its [`Origin`].
    pub incarnation: u64,
    /// Counts the decisions of that start from 0; a higher one replaces a lower one.
    pub decision: u64,
    /// When it was decided, nanoseconds of mission time.
    pub time_ns: u64,
    /// Cells still to be entered, in order; empty when the robot rests.
    pub path: Vec<Cell>,
}

impl Intent {
    /// Whether this says more than a plan of the same robot that is known: it is newer, or the same one with less of
    /// it left.
    #[must_use]
    pub fn supersedes(&self, known: &Self) -> bool {
        let is_further = self.number() == known.number() && self.path.len() < known.path.len();
        self.is_newer_than(known) || is_further
    }

    /// Whether it was made after a plan of the same robot.
    #[must_use]
    pub fn is_newer_than(&self, known: &Self) -> bool {
        self.number() > known.number()
    }

    const fn number(&self) -> (u64, u64) {
        (self.incarnation, self.decision)
    }
}

/// A robot's sign of life.
#[derive(Clone, Debug, PartialEq)]
pub struct Heartbeat {
    /// Whose.
    pub robot: RobotId,
    /// When it was sent, nanoseconds of mission time.
    pub time_ns: u64,
    /// What the robot does.
    pub activity: Activity,
    /// The cell that it is in.
    pub cell: Cell,
    /// Way covered since the mission's start, meters.
    pub path_meters: f64,
    /// The plan that it follows.
    pub intent: Intent,
    /// Observations that it has, of every robot that it has heard of.
    pub versions: Vec<Version>,
    /// Digest of its evidence.
    pub digest: Digest,
    /// What a person has ordered, as far as it has heard.
    pub directive: Directive,
}

/// What a robot does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// It follows a plan.
    Searching,
    /// Nothing is left that is worth a search.
    Cleared,
    /// Its budget of way or time is spent.
    Spent,
    /// There is nowhere to go.
    Stuck,
    /// A person has paused the search.
    Paused,
    /// Its teammates have promised to see all that is worth a look: it waits for what they see.
    Waiting,
}

impl Activity {
    /// Why a robot does not move, or what it does instead.
    #[must_use]
    pub const fn reason(self) -> &'static str {
        match self {
            Self::Searching => "it has not decided yet",
            Self::Cleared => "nothing is left that is worth a search",
            Self::Spent => "its budget is spent",
            Self::Stuck => "there is nowhere to go",
            Self::Paused => "the search is paused",
            Self::Waiting => "its teammates are about to see all that is worth a look",
        }
    }

    /// Whether the robot has come to rest by itself: one that a person has paused, or that waits, may go on.
    #[must_use]
    pub const fn is_rest(self) -> bool {
        match self {
            Self::Cleared | Self::Spent | Self::Stuck => true,
            Self::Searching | Self::Paused | Self::Waiting => false,
        }
    }
}

/// A request to repeat observations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyncRequest {
    /// Who asks.
    pub from: Participant,
    /// Whose observations are missing; often, not always, those of the one who is asked.
    pub of: Origin,
    /// The first sequence number that is missing.
    pub first: u64,
}

/// Observations of one origin, repeated.
#[derive(Clone, Debug, PartialEq)]
pub struct SyncReply {
    /// In order of their sequence numbers, at most [`SyncReply::MAX_OBSERVATIONS`].
    pub observations: Vec<Arc<Observation>>,
}

impl SyncReply {
    /// The most observations in one reply.
    pub const MAX_OBSERVATIONS: usize = 64;
}

/// How the mission stands, as the coordinator sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct MissionStatus {
    /// When, nanoseconds of mission time.
    pub time_ns: u64,
    /// Objects that are declared now.
    pub declared: Vec<Detection>,
    /// Expected number of objects that are not.
    pub expected_remaining: f64,
    /// Robots that are alive, by number.
    pub alive: Vec<RobotId>,
    /// Observations merged so far.
    pub observations: u64,
    /// Observations that it has, of every robot that it has heard of: what a lost robot told it alone is not lost.
    pub versions: Vec<Version>,
    /// Digest of the merged evidence.
    pub digest: Digest,
    /// What a person has ordered.
    pub directive: Directive,
    /// Robots whose number several processes have, by number.
    pub doubled: Vec<RobotId>,
}

/// A declared object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Where.
    pub cell: Cell,
    /// Its probability now.
    pub probability: f64,
    /// When it was declared, nanoseconds of mission time.
    pub time_ns: u64,
}
