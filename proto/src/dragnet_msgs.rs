//! Dragnet's own messages, package `dragnet_msgs`. Units and ranges are documented in `proto/msg/*.msg`.
//!
//! Cells are row-major numbers. Each message begins with its version, so that another version is reported rather than
//! misread.
#![expect(missing_docs, reason = "fields are described once, in the .msg file that each struct names")]

mod definitions;

use serde::{Deserialize, Serialize};

pub use definitions::{DEFINITIONS, NAMES};

/// The version of all messages of this program but those below.
pub const VERSION: u8 = 4;
/// The version of [`Observation`], and of [`SyncReply`] and [`ObjectPosition`].
pub const OBSERVATION_VERSION: u8 = 5;
/// The version of [`StepReply`]. Only processes of one simulation exchange it, and it is never stored.
pub const STEP_REPLY_VERSION: u8 = 5;

/// `dragnet_msgs/msg/Observation`, see `msg/Observation.msg`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Observation {
    pub version: u8,
    pub robot: u16,
    pub incarnation: u64,
    pub sequence: u64,
    pub time_ns: u64,
    pub cell: u32,
    pub cells: Vec<u32>,
    pub values: Vec<f32>,
    pub variances: Vec<f32>,
    pub positions: Vec<ObjectPosition>,
}

/// `dragnet_msgs/msg/ObjectPosition`, see `msg/ObjectPosition.msg`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectPosition {
    pub version: u8,
    pub cell: u32,
    pub east_meters: f64,
    pub north_meters: f64,
    pub covariance_square_meters: [f32; 3],
}

/// An [`Observation`] of version 4, as recordings and journals of earlier programs hold it.
#[derive(Debug, Deserialize)]
pub(crate) struct EarlierObservation {
    _version: u8,
    robot: u16,
    incarnation: u64,
    sequence: u64,
    time_ns: u64,
    cell: u32,
    cells: Vec<u32>,
    values: Vec<f32>,
    variances: Vec<f32>,
}

impl EarlierObservation {
    /// The version of all of them.
    pub(crate) const VERSION: u8 = 4;
}

impl From<EarlierObservation> for Observation {
    fn from(earlier: EarlierObservation) -> Self {
        let EarlierObservation {
            robot, incarnation, sequence, time_ns, cell, cells, values, variances, ..
        } = earlier;
        let version = OBSERVATION_VERSION;
        let positions = Vec::new();
        Self { version, robot, incarnation, sequence, time_ns, cell, cells, values, variances, positions }
    }
}

/// `dragnet_msgs/msg/Intent`, see `msg/Intent.msg`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Intent {
    pub version: u8,
    pub robot: u16,
    pub incarnation: u64,
    pub decision: u64,
    pub time_ns: u64,
    pub path: Vec<u32>,
}

/// `dragnet_msgs/msg/Heartbeat`, see `msg/Heartbeat.msg`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Heartbeat {
    pub version: u8,
    pub robot: u16,
    pub time_ns: u64,
    pub activity: u8,
    pub cell: u32,
    pub path_meters: f64,
    pub intent: Intent,
    pub version_vector: Vec<Version>,
    pub digest: [u64; 2],
    pub directive: Directive,
}

/// `dragnet_msgs/msg/SyncRequest`, see `msg/SyncRequest.msg`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SyncRequest {
    pub version: u8,
    pub from_kind: u8,
    pub from_robot: u16,
    pub of_robot: u16,
    pub of_incarnation: u64,
    pub first: u64,
}

/// `dragnet_msgs/msg/SyncReply`, see `msg/SyncReply.msg`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SyncReply {
    pub version: u8,
    pub observations: Vec<Observation>,
}

/// `dragnet_msgs/msg/Version`, see `msg/Version.msg`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Version {
    pub version: u8,
    pub robot: u16,
    pub incarnation: u64,
    pub next: u64,
}

/// `dragnet_msgs/msg/Detection`, see `msg/Detection.msg`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Detection {
    pub version: u8,
    pub cell: u32,
    pub probability: f64,
    pub time_ns: u64,
}

/// `dragnet_msgs/msg/MissionStatus`, see `msg/MissionStatus.msg`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MissionStatus {
    pub version: u8,
    pub time_ns: u64,
    pub declared: Vec<Detection>,
    pub expected_remaining: f64,
    pub alive: Vec<u16>,
    pub observations: u64,
    pub version_vector: Vec<Version>,
    pub digest: [u64; 2],
    pub directive: Directive,
    pub doubled: Vec<u16>,
}

/// `dragnet_msgs/msg/Directive`, see `msg/Directive.msg`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Directive {
    pub version: u8,
    pub number: u64,
    pub order: u8,
    pub firsts: Vec<u32>,
    pub counts: Vec<u32>,
}

/// `dragnet_msgs/msg/Verdicts`, see `msg/Verdicts.msg`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Verdicts {
    pub version: u8,
    pub robot: u16,
    pub time_ns: u64,
    pub cells: Vec<u32>,
    pub numbers: Vec<u64>,
    pub decisions: Vec<u8>,
    pub log_odds: Vec<i64>,
}

/// `dragnet_msgs/msg/Picture`, see `msg/Picture.msg`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    pub version: u8,
    pub robot: u16,
    pub time_ns: u64,
    pub cell: u32,
    pub camera: String,
    pub label: String,
    pub score: f32,
    pub quality: f32,
    pub size: u32,
    pub first: u32,
    pub data: Vec<u8>,
}

/// `dragnet_msgs/msg/Orders`, see `msg/Orders.msg`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Orders {
    pub version: u8,
    pub robot: u16,
    pub time_ns: u64,
    pub robots: Vec<u16>,
    pub numbers: Vec<u64>,
    pub orders: Vec<u8>,
    pub cells: Vec<u32>,
}

/// `dragnet_msgs/msg/Zones`, see `msg/Zones.msg`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Zones {
    pub version: u8,
    pub robot: u16,
    pub time_ns: u64,
    pub firsts: Vec<u32>,
    pub counts: Vec<u32>,
    pub numbers: Vec<u64>,
    pub zones: Vec<u8>,
}

/// `dragnet_msgs/msg/Mark`, see `msg/Mark.msg`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mark {
    pub version: u8,
    pub id: u64,
    pub number: u64,
    pub withdrawn: bool,
    pub kind: u8,
    pub strength: u32,
    pub radius: u32,
    pub firsts: Vec<u32>,
    pub counts: Vec<u32>,
    pub note: String,
}

/// `dragnet_msgs/msg/Marks`, see `msg/Marks.msg`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Marks {
    pub version: u8,
    pub robot: u16,
    pub time_ns: u64,
    pub marks: Vec<Mark>,
}

/// `dragnet_msgs/msg/Step`, see `msg/Step.msg`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Step {
    pub version: u8,
    pub kind: u8,
    pub time_ns: u64,
    pub cell: u32,
    pub cells: Vec<u32>,
    pub values: Vec<f32>,
    pub variances: Vec<f32>,
    pub sender_kind: u8,
    pub sender_robot: u16,
    pub message: u64,
}

/// `dragnet_msgs/msg/StepReply`, see `msg/StepReply.msg`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepReply {
    pub version: u8,
    pub messages: Vec<u64>,
    pub kinds: Vec<u8>,
    pub to_kinds: Vec<u8>,
    pub to_robots: Vec<u16>,
    pub sizes: Vec<u32>,
    pub priorities: Vec<u8>,
    pub about_robots: Vec<u16>,
    pub has_route: bool,
    pub route: Vec<u32>,
    pub wake_at_ns: u64,
    pub activity: u8,
    pub decision_seconds: f64,
    pub digest: [u64; 2],
    pub observations: u64,
    pub error: String,
}

/// `dragnet_msgs/msg/Sensed`, see `msg/Sensed.msg`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sensed {
    pub version: u8,
    pub robot: u16,
    pub time_ns: u64,
    pub cell: u32,
    pub cells: Vec<u32>,
    pub values: Vec<f32>,
    pub variances: Vec<f32>,
}
