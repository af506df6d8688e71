//! Events and actions of a pilot.

use std::collections::BTreeSet;
use std::sync::Arc;

use dragnet_search::cell::Cell;
use dragnet_search::evidence::Reading;
use dragnet_search::line_of_sight::LineOfSight;
use dragnet_search::object_position::ObjectPosition;

use super::diagnostic::Diagnostic;
use crate::camera::{DetectionBox, MountedCamera};
use crate::tracker::track::TrackId;
use dragnet_lattice::costmap::CostMap;
use dragnet_lattice::plan::Plan;
use dragnet_lattice::plane::Pose;

/// An event of a vehicle.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A pose estimate of the vehicle.
    Pose(PoseEstimate),
    /// A camera's detections in an image.
    Frame(CameraFrame),
    /// A new cost map.
    Map(CostMap),
    /// The agent's route: cells to enter, in order. Empty: stay.
    Route(Vec<Cell>),
    /// The cells that the operator has closed: paths avoid them wherever they can.
    Closed(BTreeSet<Cell>),
    /// All cells in which the team has declared objects: an object on a border is declared in one cell only.
    Declared(BTreeSet<Cell>),
    /// Progress of a navigation stack with the last [`Action::Go`].
    Drive(Report),
    /// Something beside sensors and paths stops the vehicle, or no longer does.
    Interlock(Interlock, Option<InterlockFault>),
    /// Time has passed. The caller sends this event often enough to detect timeouts.
    Tick,
}

/// Something beside sensors and paths that stops a vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Interlock {
    /// A switch, or its silence.
    EmergencyStop,
    /// A low battery.
    Battery,
}

/// Why an interlock stops the vehicle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InterlockFault {
    /// In a word: the same kind is not reported again.
    pub kind: &'static str,
    /// In a sentence.
    pub message: String,
}

/// The pose of a vehicle at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseEstimate {
    /// Nanoseconds of mission time.
    pub time_ns: u64,
    /// The pose, on the map.
    pub pose: Pose,
    /// Standard deviation of the position, meters, at least 0.
    pub deviation_meters: f64,
    /// Standard deviation of the heading, radians, at least 0.
    pub heading_deviation_radians: f64,
}

/// A camera's detections in an image.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraFrame {
    /// When the image was taken, nanoseconds of mission time.
    pub time_ns: u64,
    /// The camera's name, as in the settings.
    pub camera: String,
    /// The angle of the head that the camera is mounted on, radians counter-clockwise; 0 without one.
    pub head_radians: f64,
    /// The detections.
    pub detections: CameraDetections,
}

/// The detections in an image.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraDetections {
    /// Boxes, pixels.
    Boxes(Vec<DetectionBox>),
    /// Boxes of a camera whose lens and mounting are measured, pixels.
    Measured {
        /// The camera at the time of the image.
        camera: Arc<MountedCamera>,
        /// The boxes.
        boxes: Vec<DetectionBox>,
    },
    /// Radians counter-clockwise from the vehicle's heading (from its head, if it has one), from the camera's position.
    Bearings(Vec<f64>),
}

/// A detection that belongs to a track.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Assigned {
    /// The camera's name, as in its [`CameraFrame`].
    pub camera: String,
    /// When the image was taken, as in its [`CameraFrame`].
    pub time_ns: u64,
    /// Index of the box, or of the bearing, in its [`CameraFrame`].
    pub detection: usize,
    /// The track.
    pub track: TrackId,
}

/// The progress of a drive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Report {
    /// The vehicle has reached its goal.
    Arrived,
    /// It cannot reach the goal; the reason.
    Failed(String),
}

/// An action of a pilot, to be carried out in order.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Report a cell and its readings to the agent.
    Sensed {
        /// The vehicle's cell.
        cell: Cell,
        /// Readings since the last observation.
        readings: Vec<Reading>,
    },
    /// Report to the agent that its route is given up: a cell and its readings follow.
    RouteFailed {
        /// The ends of runs that could not be driven and, if one was too narrow, all cells that are.
        blocked: Vec<Cell>,
    },
    /// Report to the agent that an object is or may be in cells that were reported to be empty and are out of sight: the robot
    /// has to come back to them. An observation follows.
    Doubted {
        /// The cells.
        cells: Vec<Cell>,
    },
    /// Report to the agent which cells walls hide from which, or need no other observation from there: at first if the mission's map has
    /// walls, and whenever a map of the vehicle or an observation changes it.
    LineOfSight(LineOfSight),
    /// Report to the agent positions of objects that this vehicle declares, new or better known than before, by cell. An
    /// observation follows.
    Located(Vec<ObjectPosition>),
    /// Drive along this path, replacing any earlier one.
    Drive(Plan),
    /// Send this goal to the navigation stack.
    Go(Pose),
    /// Stand still.
    Hold,
    /// Publish a diagnostic.
    Tell(Diagnostic),
    /// Count an invalid input. It occurs for each invalid input, while [`Action::Tell`] occurs once per fault.
    Refuse(InputSource, String),
}

/// The source of an input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum InputSource {
    /// Localization.
    Pose,
    /// The camera of this name.
    Camera(String),
}
