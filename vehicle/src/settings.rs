//! The `[vehicle]` table of a robot's settings.
//!
//! The types here are the tables as they are written: names and defaults, unchecked. [`Settings::check`] checks them
//! and converts them for the rest of this crate; each error names the key, its value, and the allowed values. The
//! descriptions here are also those of the reference of settings (`docs/settings.md`).

mod cameras;
mod check;

pub use cameras::{Measured, MeasuredCamera};
pub(crate) use check::nanoseconds;
pub use check::{Checked, Motion, SettingsError, Source};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::tracker::settings::Settings as TrackerSettings;

/// The `[vehicle]` table. Without any key: two cameras that look forward, and a small ground vehicle that drives forward
/// on lattice plans.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[schemars(title = "Vehicle")]
pub struct Settings {
    /// Cameras, 1 to 16, with distinct names.
    pub cameras: Vec<CameraTable>,
    /// How detections become tracks.
    pub tracker: TrackerTable,
    /// How the vehicle gets to a cell.
    pub motion: MotionTable,
    /// The ground that the vehicle covers.
    pub footprint: FootprintTable,
    /// Full speed, m/s, above 0 to 1000. A pose farther away than this allows is a jump.
    pub speed_meters_per_second: f64,
    /// Duration of the first observation, seconds, 0 to 3600: one turn of the head, if the cameras are on one.
    pub initial_scan_seconds: f64,
    /// When to stop.
    pub safety: SafetyTable,
}

/// A camera. Its position and direction are relative to the vehicle's reference point, as in REP 103.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraTable {
    /// Name of the camera in detections; not empty.
    #[schemars(extend("examples" = ["front"]))]
    pub name: String,
    /// Columns of the images that boxes refer to, pixels, at least 1. Left out, with the next two, if the camera's calibration
    /// comes from its network (`camera_info` of `ros.cameras`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("examples" = [1920]))]
    pub width_pixels: Option<u32>,
    /// Rows of those images, pixels, at least 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("examples" = [1080]))]
    pub height_pixels: Option<u32>,
    /// Angle between the left and the right edge of an image, degrees, above 0 and below 180.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("examples" = [63.0]))]
    pub field_of_view_degrees: Option<f64>,
    /// Position forward of the reference point, meters; by default 0. Left out, with the next four, if the camera's mounting
    /// comes from its network (`mounting` of `ros.cameras`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x_meters: Option<f64>,
    /// Position left of the reference point, meters; by default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y_meters: Option<f64>,
    /// Viewing direction, degrees counter-clockwise from forward; by default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw_degrees: Option<f64>,
    /// Height above the ground, meters, 0 to 1000; by default 0. It bounds how near the ground is seen; with 0 the ground is
    /// seen from `min_range_meters` on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z_meters: Option<f64>,
    /// Angle below the horizon, degrees, between -90 and 90; by default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pitch_degrees: Option<f64>,
    /// Shortest range of a detection, meters, above 0.
    #[serde(default = "min_range_meters")]
    pub min_range_meters: f64,
    /// Longest range of a detection, meters, above `min_range_meters`.
    #[schemars(extend("examples" = [60.0]))]
    pub max_range_meters: f64,
    /// Standard deviation of the middle of a box, pixels, above 0 to a quarter of the width.
    #[serde(default = "column_std_pixels")]
    pub column_std_pixels: f64,
}

/// How detections become tracks; see [`crate::tracker::settings::Settings`].
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrackerTable {
    /// Range hypotheses of a new track, 1 to 64.
    pub range_hypotheses: u32,
    /// Standard deviation of each velocity component of a new track, m/s, above 0 to 1000. The default is for static
    /// objects; for people on foot 0.5.
    pub velocity_std_meters_per_second: f64,
    /// Standard deviation of a velocity's change within a second, m/s, 0 to 1000. The default is for static objects; for
    /// people on foot 0.1.
    pub acceleration_std_meters_per_second: f64,
    /// Largest difference between a bearing and its track, degrees, above 0 to 180; the uncertainty of the track is added.
    pub gate_degrees: f64,
    /// Detections within the first `initial_frames` that confirm a track, at least 1.
    pub confirm_hits: u32,
    /// First frames of a track, at least `confirm_hits`.
    pub initial_frames: u32,
    /// Misses in a row that end a confirmed track, at least 1.
    pub max_misses: u32,
    /// Time without a detection that ends any track, seconds, above 0.
    pub track_timeout_seconds: f64,
    /// Probability that the detector misses a visible object in a frame, 0 to 0.95. The readings of empty cells follow
    /// from it.
    pub miss_probability: f64,
    /// False detections per frame, above 0 to 100. The more there are, the more detections confirm a track.
    pub false_alarms_per_frame: f64,
    /// Time over which pose errors persist, seconds, 0 to 3600, or from one pose to the next if that is longer: bearings
    /// within that time share one error.
    pub pose_correlation_seconds: f64,
    /// Time that a slower camera is waited for, seconds, 0 to 60. Frames are fused by their stamps; later ones do not
    /// count.
    pub fusion_window_seconds: f64,
}

/// How the vehicle gets to a cell: by a plan of the lattice, or by a navigation stack of its own.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum MotionTable {
    /// Paths on a state lattice, for a path follower.
    Lattice {
        /// A file with SBPL motion primitives, relative to the settings. Excludes the five keys after it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        primitives: Option<String>,
        /// Radius of the tightest turn, meters, above 0.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        turning_radius_meters: Option<f64>,
        /// Headings of the lattice: 8, 16 or 32.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        headings: Option<u32>,
        /// Cost factor of driving backward, 1 to 1000; without it the vehicle does not.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        reverse_cost: Option<u32>,
        /// Cost factor of turning on the spot, 1 to 1000; without it the vehicle does not.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        turn_in_place_cost: Option<u32>,
        /// Lattice states that a plan may expand, 1000 to 10^8.
        #[serde(default = "max_expansions")]
        max_expansions: u64,
        /// Distance from the path beyond which it is planned anew, meters, above 0.
        #[serde(default = "replan_beyond_meters")]
        replan_beyond_meters: f64,
    },
    /// Goal poses for a navigation stack that drives by itself and reports their status.
    Goal {},
}

/// The ground that the vehicle covers, around its reference point.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "snake_case", deny_unknown_fields)]
pub enum FootprintTable {
    /// A disc.
    Disc {
        /// Radius, meters, 0 to 1000.
        #[schemars(extend("examples" = [0.5]))]
        radius_meters: f64,
    },
    /// A rectangle with its middle at the reference point.
    Rectangle {
        /// Length from front to back, meters, above 0.
        #[schemars(extend("examples" = [1.5]))]
        length_meters: f64,
        /// Width from side to side, meters, above 0.
        #[schemars(extend("examples" = [1.0]))]
        width_meters: f64,
    },
}

/// The response to a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultResponse {
    /// The vehicle stands until the fault is over.
    Stop,
    /// The vehicle drives on; untrusted data is not used.
    Continue,
}

/// When to stop.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SafetyTable {
    /// The response to each kind of fault.
    pub on_fault: OnFault,
    /// Time without a valid pose after which the pose is lost, seconds, above 0 to 86400.
    pub pose_timeout_seconds: f64,
    /// Time without a valid frame after which a camera has stopped, seconds, above 0 to 86400.
    pub camera_timeout_seconds: f64,
    /// Largest standard deviation of a valid position, meters, above 0.
    pub max_position_std_meters: f64,
    /// Time without a fault, or of poses that agree after a jump, before input is trusted again, seconds, above 0 to 86400.
    pub recovery_seconds: f64,
}

/// The response to each kind of fault.
#[derive(Clone, Debug, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OnFault {
    /// No valid pose.
    pub pose: FaultResponse,
    /// A camera stops, or its frames are invalid.
    pub camera: FaultResponse,
    /// The clock runs backward.
    pub clock: FaultResponse,
    /// No path leads to the next cells, or the drive there failed; to continue means to try the cells after them.
    pub path: FaultResponse,
    /// A new map is invalid; to continue means on the old one.
    pub map: FaultResponse,
}

const fn min_range_meters() -> f64 {
    2.0
}

const fn column_std_pixels() -> f64 {
    4.0
}

const fn max_expansions() -> u64 {
    200_000
}

const fn replan_beyond_meters() -> f64 {
    3.0
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            cameras: vec![CameraTable::wide(), CameraTable::narrow()],
            tracker: TrackerTable::default(),
            motion: MotionTable::default(),
            footprint: FootprintTable::Rectangle { length_meters: 1.5, width_meters: 1.0 },
            speed_meters_per_second: 2.0,
            initial_scan_seconds: 0.0,
            safety: SafetyTable::default(),
        }
    }
}

impl CameraTable {
    /// The paper's wide camera (section IV), looking ahead.
    #[must_use]
    pub fn wide() -> Self {
        Self::ahead("wide", 63.0, 80.0)
    }

    /// The paper's narrow camera (section IV), looking ahead.
    #[must_use]
    pub fn narrow() -> Self {
        Self::ahead("narrow", 16.0, 200.0)
    }

    fn ahead(name: &str, field_of_view_degrees: f64, max_range_meters: f64) -> Self {
        Self {
            name: name.to_owned(),
            width_pixels: Some(2660),
            height_pixels: Some(1516),
            field_of_view_degrees: Some(field_of_view_degrees),
            x_meters: None,
            y_meters: None,
            yaw_degrees: None,
            z_meters: None,
            pitch_degrees: None,
            min_range_meters: min_range_meters(),
            max_range_meters,
            column_std_pixels: column_std_pixels(),
        }
    }
}

impl Default for TrackerTable {
    fn default() -> Self {
        let settings = TrackerSettings::default();
        Self {
            range_hypotheses: settings.range_hypotheses,
            velocity_std_meters_per_second: settings.velocity_std,
            acceleration_std_meters_per_second: settings.acceleration_density.sqrt(),
            gate_degrees: settings.gate_radians.to_degrees(),
            confirm_hits: settings.confirm_hits,
            initial_frames: settings.initial_frames,
            max_misses: settings.max_misses,
            track_timeout_seconds: settings.track_timeout_seconds,
            miss_probability: settings.miss_probability,
            false_alarms_per_frame: settings.false_alarms_per_frame,
            pose_correlation_seconds: settings.pose_correlation_seconds,
            fusion_window_seconds: 1.0,
        }
    }
}

impl Default for MotionTable {
    fn default() -> Self {
        Self::Lattice {
            primitives: None,
            turning_radius_meters: None,
            headings: None,
            reverse_cost: None,
            turn_in_place_cost: None,
            max_expansions: max_expansions(),
            replan_beyond_meters: replan_beyond_meters(),
        }
    }
}

impl Default for SafetyTable {
    fn default() -> Self {
        Self {
            on_fault: OnFault::default(),
            pose_timeout_seconds: 1.0,
            camera_timeout_seconds: 3.0,
            max_position_std_meters: 5.0,
            recovery_seconds: 3.0,
        }
    }
}

impl Default for OnFault {
    /// The vehicle stops without images or a position; without a path it tries the next cells.
    fn default() -> Self {
        Self {
            pose: FaultResponse::Stop,
            camera: FaultResponse::Stop,
            clock: FaultResponse::Stop,
            path: FaultResponse::Continue,
            map: FaultResponse::Stop,
        }
    }
}

#[cfg(test)]
mod tests;
