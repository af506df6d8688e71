//! Messages between robots, coordinator and simulator, in the types of [`dragnet_search`].
//!
//! [`crate::convert`] converts them to the ROS 2 messages of [`crate::dragnet_msgs`] and checks them on the way back:
//! cells on the map, readings in range, lengths bounded. Values of these types are well formed.

use std::sync::Arc;

use dragnet_scenario::participant::Participant;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::intent::PlannedPath;
use dragnet_search::observation::{Observation, Origin, RobotId, Versions};

use crate::directive::Directive;
use crate::marks::Marks;
use crate::orders::RobotOrders;
use crate::verdict::Verdicts;
use crate::zones::Zones;

/// The receivers of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Audience {
    /// All participants.
    All,
    /// One participant.
    One(Participant),
}

/// A message of one participant to the others.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// To all: an observation of a robot.
    Observation(Arc<Observation>),
    /// To all: a robot's plan.
    Intent(Intent),
    /// To all, periodically: a robot's state and its version vector.
    Heartbeat(Heartbeat),
    /// To one: a request for missing observations.
    SyncRequest(SyncRequest),
    /// To one: the missing observations.
    SyncReply(SyncReply),
    /// From the coordinator to all: the mission's status.
    MissionStatus(MissionStatus),
    /// To all, beside heartbeats and status once there are any: the operator's verdicts that the sender knows.
    Verdicts(VerdictReport),
    /// To all, beside heartbeats and status once there are any: the operator's orders to single robots that the sender knows.
    Orders(OrderReport),
    /// To all, beside heartbeats and status once there are any: the operator's zones that the sender knows.
    Zones(ZoneReport),
    /// To all, beside heartbeats and status once there are any: the operator's marks that the sender knows.
    Marks(MarkReport),
}

impl Message {
    /// The kind of the message.
    #[must_use]
    pub const fn kind(&self) -> MessageKind {
        match self {
            Self::Observation(_) => MessageKind::Observation,
            Self::Intent(_) => MessageKind::Intent,
            Self::Heartbeat(_) => MessageKind::Heartbeat,
            Self::SyncRequest(_) => MessageKind::SyncRequest,
            Self::SyncReply(_) => MessageKind::SyncReply,
            Self::MissionStatus(_) => MessageKind::MissionStatus,
            Self::Verdicts(_) => MessageKind::Verdicts,
            Self::Orders(_) => MessageKind::Orders,
            Self::Zones(_) => MessageKind::Zones,
            Self::Marks(_) => MessageKind::Marks,
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
    /// [`Message::Verdicts`].
    Verdicts,
    /// [`Message::Orders`].
    Orders,
    /// [`Message::Zones`].
    Zones,
    /// [`Message::Marks`].
    Marks,
}

impl MessageKind {
    /// All kinds.
    pub const ALL: [Self; 10] = [
        Self::Observation,
        Self::Intent,
        Self::Heartbeat,
        Self::SyncRequest,
        Self::SyncReply,
        Self::MissionStatus,
        Self::Verdicts,
        Self::Orders,
        Self::Zones,
        Self::Marks,
    ];
}

/// A robot's plan. Each replaces the one before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Intent {
    /// The robot.
    pub robot: RobotId,
    /// Its incarnation, as in its [`Origin`].
    pub incarnation: u64,
    /// Number of the decision in that incarnation, from 0; a higher number replaces a lower one.
    pub decision: u64,
    /// When the decision was made, nanoseconds of mission time.
    pub time_ns: u64,
    /// Cells still to be entered, in order; empty when the robot rests.
    pub path: PlannedPath,
}

impl Intent {
    /// Whether this replaces a known plan of the same robot: it is newer, or it is the same plan with fewer cells left.
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

/// A robot's heartbeat.
#[derive(Clone, Debug, PartialEq)]
pub struct Heartbeat {
    /// The robot.
    pub robot: RobotId,
    /// When it was sent, nanoseconds of mission time.
    pub time_ns: u64,
    /// The robot's activity.
    pub activity: Activity,
    /// The robot's cell.
    pub cell: Cell,
    /// Distance driven since the mission's start, meters.
    pub path_meters: f64,
    /// The robot's current plan.
    pub intent: Intent,
    /// The version vector of its observations.
    pub versions: Versions,
    /// Digest of its evidence.
    pub digest: Digest,
    /// The operator's directive, as far as the robot has received it.
    pub directive: Directive,
}

/// The activity of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// It follows a plan.
    Searching,
    /// The search is over: the expected number of remaining objects is at most the mission's limit, or the policy finds no
    /// path worth driving.
    Cleared,
    /// Its budget of path length or time is spent, or its battery is low.
    Spent,
    /// No way is open: to no cell, or not to its base.
    Stuck,
    /// The operator has paused the search.
    Paused,
    /// Its teammates plan to observe all that is left, or are to pass first where robots keep apart: it waits for them.
    Waiting,
    /// Its search is over, or its budget leaves no more than the way home: it drives to its base.
    Returning,
    /// The operator has called the robots back: it is at its base.
    Recalled,
    /// It drives to the cell to which the operator has sent it.
    Sent,
    /// It is in that cell, where it waits for the operator's next order.
    Holding,
    /// The operator has closed the cell that it is in: it leaves the no-go zone by the shortest way.
    Leaving,
    /// It makes way for its teammates, and decides again where it is out of their way.
    GivingWay,
}

impl Activity {
    /// The reason why a robot with this activity does not move, in words.
    #[must_use]
    pub const fn reason(self) -> &'static str {
        match self {
            Self::Searching => "it has not decided yet",
            Self::Cleared => "too little is left for it to find",
            Self::Spent => "its budget or battery leaves no further step",
            Self::Stuck => "no way is open to it",
            Self::Paused => "the operator has paused it",
            Self::Waiting => "its teammates are to observe all that is left, or to pass first",
            Self::Returning => "it returns to its base",
            Self::Recalled => "the operator has called it back",
            Self::Sent => "it goes where the operator sends it",
            Self::Holding => "it waits for the operator's next order",
            Self::Leaving => "it leaves a no-go zone",
            Self::GivingWay => "it makes way for its teammates",
        }
    }

    /// Whether the robot follows a path.
    #[must_use]
    pub const fn is_under_way(self) -> bool {
        matches!(self, Self::Searching | Self::Returning | Self::Sent | Self::Leaving | Self::GivingWay)
    }

    /// Whether the robot has ended its search; a paused, holding or waiting robot may continue.
    #[must_use]
    pub const fn is_rest(self) -> bool {
        match self {
            Self::Cleared | Self::Spent | Self::Stuck | Self::Recalled => true,
            Self::Searching
            | Self::Paused
            | Self::Waiting
            | Self::Returning
            | Self::Sent
            | Self::Holding
            | Self::Leaving
            | Self::GivingWay => false,
        }
    }
}

/// A request to repeat observations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyncRequest {
    /// The participant that asks.
    pub from: Participant,
    /// The origin of the missing observations; it may be another participant than the one that is asked.
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
    /// The maximum number of observations in one reply.
    pub const MAX_OBSERVATIONS: usize = 64;
}

/// The coordinator's status of the mission.
#[derive(Clone, Debug, PartialEq)]
pub struct MissionStatus {
    /// When, nanoseconds of mission time.
    pub time_ns: u64,
    /// Currently declared objects.
    pub declared: Vec<Detection>,
    /// Expected number of objects that are not declared.
    pub expected_remaining: f64,
    /// Robots that are alive, by number.
    pub alive: Vec<RobotId>,
    /// Observations merged so far.
    pub observations: u64,
    /// The version vector of its observations, which spreads observations that only the coordinator received from a
    /// lost robot.
    pub versions: Versions,
    /// Digest of the merged evidence.
    pub digest: Digest,
    /// The operator's directive.
    pub directive: Directive,
    /// Robots whose number is used by several processes, by number.
    pub doubled: Vec<RobotId>,
}

/// The operator's verdicts that a participant knows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VerdictReport {
    /// The participant.
    pub from: Participant,
    /// When it was sent, nanoseconds of mission time.
    pub time_ns: u64,
    /// The verdicts.
    pub verdicts: Verdicts,
}

/// The operator's orders to single robots that a participant knows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OrderReport {
    /// The participant.
    pub from: Participant,
    /// When it was sent, nanoseconds of mission time.
    pub time_ns: u64,
    /// The orders.
    pub orders: RobotOrders,
}

/// The operator's zones that a participant knows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ZoneReport {
    /// The participant.
    pub from: Participant,
    /// When it was sent, nanoseconds of mission time.
    pub time_ns: u64,
    /// The zones.
    pub zones: Zones,
}

/// The operator's marks that a participant knows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MarkReport {
    /// The participant.
    pub from: Participant,
    /// When it was sent, nanoseconds of mission time.
    pub time_ns: u64,
    /// The marks.
    pub marks: Marks,
}

/// A declared object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Its cell.
    pub cell: Cell,
    /// Its probability now.
    pub probability: f64,
    /// When it was declared, nanoseconds of mission time.
    pub time_ns: u64,
}
