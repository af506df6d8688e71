//! What a robot's own side is told before it starts: the `[vehicle]` table of its settings.
//!
//! Tables here are as they are written: names, defaults, and nothing checked. [`Settings::check`] checks them
//! and makes of them what the rest of this crate works with; each message names the key, what it says, and
//! what is allowed.

mod check;

pub(crate) use check::nanoseconds;
pub use check::{Checked, Motion, SettingsError, Source};

use serde::{Deserialize, Serialize};

use crate::tracker::settings::Settings as TrackerSettings;

/// The `[vehicle]` table. Without any key: two cameras that look ahead, a small ground vehicle that drives
/// forward by the lattice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// What it sees with, 1 to 16; names differ.
    pub cameras: Vec<CameraTable>,
    /// How it follows things.
    pub tracker: TrackerTable,
    /// How it gets to a cell.
    pub motion: MotionTable,
    /// The ground that it covers.
    pub footprint: FootprintTable,
    /// Its full speed, m/s, above 0, at most 1000: a pose that is farther away than this allows is a jump.
    pub speed_meters_per_second: f64,
    /// Its first look lasts so long, seconds, 0 to 3600: one turn of the head, if its cameras are on one.
    pub initial_scan_seconds: f64,
    /// When to stand still.
    pub safety: SafetyTable,
}

/// A camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraTable {
    /// What detections call it; not empty.
    pub name: String,
    /// Columns of the image that boxes are given in, at least 1.
    pub width_pixels: u32,
    /// Rows of that image, at least 1.
    pub height_pixels: u32,
    /// Angle between its left and its right edge, degrees, above 0 and below 180.
    pub field_of_view_degrees: f64,
    /// Meters ahead of the vehicle's reference point.
    #[serde(default)]
    pub x_meters: f64,
    /// Meters to the left of it.
    #[serde(default)]
    pub y_meters: f64,
    /// Where it looks, degrees counter-clockwise from ahead.
    #[serde(default)]
    pub yaw_degrees: f64,
    /// How high it is above the ground, meters, 0 to 1000: from it follows how near the ground is seen. Without,
    /// or with 0, it is seen from `min_range_meters` on.
    #[serde(default)]
    pub z_meters: f64,
    /// How far it looks down from the horizon, degrees, between -90 and 90.
    #[serde(default)]
    pub pitch_degrees: f64,
    /// Things are detected from here on, meters, above 0.
    #[serde(default = "min_range_meters")]
    pub min_range_meters: f64,
    /// And up to here, meters, above `min_range_meters`.
    pub max_range_meters: f64,
    /// Standard deviation of the middle of a box, pixels, above 0.
    #[serde(default = "column_std_pixels")]
    pub column_std_pixels: f64,
}

/// How things are followed; see [`crate::tracker::settings::Settings`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrackerTable {
    /// Members of a new track, 1 to 64.
    pub range_hypotheses: u32,
    /// Of each component of a new track's velocity, m/s, above 0, at most 1000. The default is that of things
    /// that lie still; for people on foot 0.5.
    pub velocity_std_meters_per_second: f64,
    /// In a second a velocity wanders by this, m/s, 0 to 1000. The default is that of things that lie still;
    /// for people on foot 0.1.
    pub acceleration_std_meters_per_second: f64,
    /// A bearing may be so far from where its track is expected, degrees, above 0, at most 180; and as much
    /// farther as it is not known where that is.
    pub gate_degrees: f64,
    /// A track is confirmed once it is seen in so many of its first looks, at least 1.
    pub confirm_hits: u32,
    /// See there; at least `confirm_hits`.
    pub initial_frames: u32,
    /// A confirmed track is lost after so many misses in a row, at least 1.
    pub max_misses: u32,
    /// Any track is lost when it was not seen for so long, seconds, above 0.
    pub track_timeout_seconds: f64,
    /// In a frame a thing in view is missed with this probability, 0 to 0.95. What an empty cell reads follows
    /// from it.
    pub miss_probability: f64,
    /// So many detections of a frame are of nothing, above 0, at most 100: the more there are, the more sights
    /// confirm a track.
    pub false_alarms_per_frame: f64,
    /// Errors of poses last so long, seconds, 0 to 3600, or from one pose to the next if that is longer: however
    /// many bearings are taken meanwhile, they are turned alike.
    pub pose_correlation_seconds: f64,
    /// Frames of several cameras are taken in by their stamps: a camera is waited for so long, seconds, 0 to 60,
    /// and a frame that comes later does not count.
    pub fusion_window_seconds: f64,
}

/// How the vehicle gets to a cell: by a plan of the lattice, or by a navigation stack of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum MotionTable {
    /// By paths of [`dragnet_lattice`].
    Lattice {
        /// A file of SBPL's motion primitives, which the caller reads. Excludes the five keys after it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        primitives: Option<String>,
        /// The tightest turn, meters, above 0.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        turning_radius_meters: Option<f64>,
        /// Headings of the lattice: 8, 16 or 32.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        headings: Option<u32>,
        /// If it drives backwards: how often a way counts then, 1 to 1000.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        reverse_cost: Option<u32>,
        /// If it turns on the spot: how often that counts, 1 to 1000.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        turn_in_place_cost: Option<u32>,
        /// A plan looks at so many states before it is taken as it is, 1000 to 10^8.
        #[serde(default = "max_expansions")]
        max_expansions: u64,
        /// Farther beside its path than this it plans anew, meters, above 0.
        #[serde(default = "replan_beyond_meters")]
        replan_beyond_meters: f64,
    },
    /// By goal poses for a stack that drives by itself and says how it went.
    Goal {},
}

/// The ground that the vehicle covers: a disc or a rectangle around its reference point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "snake_case", deny_unknown_fields)]
pub enum FootprintTable {
    /// A disc.
    Disc {
        /// Meters, 0 or more.
        radius_meters: f64,
    },
    /// A rectangle, its middle at the reference point.
    Rectangle {
        /// From front to back, meters, above 0.
        length_meters: f64,
        /// From side to side, meters, above 0.
        width_meters: f64,
    },
}

/// The response to a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultResponse {
    /// The vehicle stands until the fault is over.
    Stop,
    /// The vehicle drives on; untrusted data is not used.
    Continue,
}

/// When to stand still.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SafetyTable {
    /// What to do, by what is missing or wrong.
    pub on_fault: OnFault,
    /// Without a good pose for longer than this the robot does not know where it is, seconds, above 0.
    pub pose_timeout_seconds: f64,
    /// A camera without a good frame for longer than this has stopped, seconds, above 0.
    pub camera_timeout_seconds: f64,
    /// A pose with a larger standard deviation is none, meters, above 0.
    pub max_position_std_meters: f64,
    /// After a jump poses, or a clock, are believed again once they have agreed with each other for so long,
    /// seconds, above 0.
    pub recovery_seconds: f64,
}

/// What to do, by what is missing or wrong.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OnFault {
    /// No pose, or none that can be.
    pub pose: FaultResponse,
    /// A camera stops, or gives what cannot be.
    pub camera: FaultResponse,
    /// The clock runs backwards.
    pub clock: FaultResponse,
    /// No way leads to the next cells, or the drive there failed; going on means to the cells after them.
    pub path: FaultResponse,
    /// A new map cannot be used; going on means by the old one.
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
            width_pixels: 2660,
            height_pixels: 1516,
            field_of_view_degrees,
            x_meters: 0.0,
            y_meters: 0.0,
            yaw_degrees: 0.0,
            z_meters: 0.0,
            pitch_degrees: 0.0,
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
    /// Who does not see or know where it is stands still; who finds no way tries the next one.
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
