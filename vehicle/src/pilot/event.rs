//! What happens to a vehicle, and what its pilot does.

use std::collections::BTreeSet;

use dragnet_search::cell::Cell;
use dragnet_search::evidence::Reading;

use super::diagnostic::Diagnostic;
use crate::camera::DetectionBox;
use dragnet_lattice::costmap::CostMap;
use dragnet_lattice::plan::Plan;
use dragnet_lattice::plane::Pose;

/// What happens to a vehicle.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// Where it is.
    Pose(PoseEstimate),
    /// What a camera's detector found in an image.
    Frame(CameraFrame),
    /// What the ground costs, from now on.
    Map(CostMap),
    /// The agent's route: cells to enter, in order. Without a cell: stay.
    Route(Vec<Cell>),
    /// All cells in which the team has declared objects: an object on a border is declared in one cell only.
    Declared(BTreeSet<Cell>),
    /// How a navigation stack gets on with the last [`Action::Go`].
    Drive(Report),
    /// Time passes. Needed at least as often as silences are to be noticed.
    Tick,
}

/// Where a vehicle was at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseEstimate {
    /// When, nanoseconds of mission time.
    pub time_ns: u64,
    /// Where, on the map.
    pub pose: Pose,
    /// Standard deviation of its place, meters, at least 0.
    pub deviation_meters: f64,
    /// Standard deviation of its heading, radians, at least 0.
    pub heading_deviation_radians: f64,
}

/// What a camera's detector found in an image.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraFrame {
    /// When the image was taken, nanoseconds of mission time.
    pub time_ns: u64,
    /// The camera's name, as in the settings.
    pub camera: String,
    /// How far the head that the camera is mounted on was turned, radians counter-clockwise; 0 if it is on none.
    pub head_radians: f64,
    /// What was found.
    pub sights: CameraDetections,
}

/// What was found in an image.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraDetections {
    /// Boxes, pixels.
    Boxes(Vec<DetectionBox>),
    /// Radians counter-clockwise from the vehicle's heading (from its head, if it has one), from where the
    /// camera is.
    Bearings(Vec<f64>),
}

/// How a drive gets on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Report {
    /// The vehicle is where it was to go.
    Arrived,
    /// It cannot get there; why.
    Failed(String),
}

/// What a pilot does, in this order.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Tell the agent that it stands in a cell, and what was seen.
    Sensed {
        /// Where it stands.
        cell: Cell,
        /// What was seen since the last time.
        readings: Vec<Reading>,
    },
    /// Drive along this path, instead of any before.
    Drive(Plan),
    /// Have the navigation stack drive there.
    Go(Pose),
    /// Stand still.
    Hold,
    /// Tell whoever watches.
    Tell(Diagnostic),
    /// Count something that was sensed and cannot be used. It comes with each, where [`Action::Tell`] comes once.
    Refuse(InputSource, String),
}

/// Who told the pilot something.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum InputSource {
    /// Whoever knows where the vehicle is.
    Pose,
    /// The camera of this name.
    Camera(String),
}
