//! Conversion of the tables as written to the types of this crate.

use std::collections::BTreeMap;
use std::fmt::Display;

use super::cameras::{self, Cameras, Measured, MeasuredCamera};
use super::{FootprintTable, MotionTable, OnFault, Settings, TrackerTable};
use crate::camera::{Camera, CameraError};
use crate::tracker::settings::{Settings as TrackerSettings, SettingsError as TrackerError};
use dragnet_lattice::footprint::Footprint;
use dragnet_lattice::maneuvers::{Headings, Maneuvers};
use dragnet_lattice::mprim::{self, MprimError};
use dragnet_lattice::primitives::{MAX_COST_MULTIPLIER, PrimitiveSet};

/// Default turning radius, meters.
const TURNING_RADIUS_METERS: f64 = 3.0;

/// Checked settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Checked {
    /// Cameras that the settings describe, each with the standard deviation of a column, pixels.
    pub cameras: Vec<(Camera, f64)>,
    /// Cameras that the vehicle's network describes, at least in part.
    pub measured_cameras: Vec<MeasuredCamera>,
    /// Settings of the tracker.
    pub tracker: TrackerSettings,
    /// Time that a slower camera is waited for, nanoseconds.
    pub fusion_window_ns: u64,
    /// How the vehicle gets to a cell.
    pub motion: Motion,
    /// Full speed, m/s.
    pub speed_meters_per_second: f64,
    /// Duration of the first observation, nanoseconds.
    pub initial_scan_ns: u64,
    /// The responses to faults.
    pub on_fault: OnFault,
    /// Time without a valid pose after which the position is unknown, nanoseconds.
    pub pose_timeout_ns: u64,
    /// Time without a valid frame after which a camera has stopped, nanoseconds.
    pub camera_timeout_ns: u64,
    /// Largest standard deviation of a valid pose, meters.
    pub max_position_std_meters: f64,
    /// Time for which poses must agree after a jump before they are accepted again, nanoseconds.
    pub recovery_ns: u64,
}

/// How a vehicle gets to a cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// It drives along paths that are planned on the lattice.
    Lattice {
        /// The source of the motion primitives.
        source: Source,
        /// The ground that it covers.
        footprint: Footprint,
        /// Maximum number of states that a plan expands.
        max_expansions: u64,
        /// Distance from its path beyond which the vehicle plans anew, meters.
        replan_beyond_meters: f64,
    },
    /// It sends goal poses to a navigation stack.
    Goal,
}

/// The source of a lattice's motion primitives.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// From a file.
    Read(PrimitiveSet),
    /// Generated for the resolution of the cost map.
    Made {
        /// Headings of the lattice.
        headings: Headings,
        /// The turning radius, meters.
        turning_radius_meters: f64,
        /// Cost factor of driving backward; `None`: it does not.
        reverse: Option<u32>,
        /// Cost factor of turning on the spot; `None`: it does not.
        turn_in_place: Option<u32>,
    },
}

/// Why settings are invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// A quantity out of its range.
    #[error("vehicle.{key} = {found}: allowed is {allowed}")]
    Value {
        /// The key under `[vehicle]`.
        key: String,
        /// The given value.
        found: String,
        /// The allowed values.
        allowed: String,
    },
    /// An invalid camera.
    #[error("vehicle.cameras: {0}")]
    Camera(#[from] CameraError),
    /// Invalid settings of the tracker.
    #[error("vehicle.tracker: {0}")]
    Tracker(#[from] TrackerError),
    /// An invalid file of motion primitives.
    #[error("vehicle.motion.primitives: {0}")]
    Primitives(#[from] MprimError),
}

pub(super) fn value(key: &str, found: &dyn Display, allowed: impl Into<String>) -> SettingsError {
    SettingsError::Value { key: key.to_owned(), found: found.to_string(), allowed: allowed.into() }
}

/// A number above 0, at most `most`; written so that NaN fails as well.
pub(super) fn positive(key: &str, number: f64, most: f64) -> Result<f64, SettingsError> {
    if number > 0.0 && number <= most {
        return Ok(number);
    }
    Err(value(key, &number, format!("above 0, at most {most}")))
}

/// A day: the maximum of a timeout.
const MOST_SECONDS: f64 = 86_400.0;

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 0, and `as` saturates")]
pub(crate) fn nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}

impl Settings {
    /// Checks all settings. `primitives` is the text of the file that [`MotionTable::Lattice`] names, if it does.
    ///
    /// # Errors
    /// The first invalid value, with its key and the allowed values.
    pub fn check(&self, primitives: Option<&str>) -> Result<Checked, SettingsError> {
        self.check_measured(primitives, &BTreeMap::new())
    }

    /// The same of a vehicle whose network says something of its cameras, by their names.
    ///
    /// # Errors
    /// The first invalid value, with its key and the allowed values.
    pub fn check_measured(
        &self,
        primitives: Option<&str>,
        measured: &BTreeMap<String, Measured>,
    ) -> Result<Checked, SettingsError> {
        let Cameras { described, measured: measured_cameras } = cameras::check(&self.cameras, measured)?;
        let safety = &self.safety;
        let seconds = |key: &str, seconds| positive(key, seconds, MOST_SECONDS).map(nanoseconds);
        if !(0.0..=3600.0).contains(&self.initial_scan_seconds) {
            return Err(value("initial_scan_seconds", &self.initial_scan_seconds, "0 to 3600"));
        }
        let max_std = safety.max_position_std_meters;
        Ok(Checked {
            cameras: described,
            measured_cameras,
            tracker: tracker(&self.tracker)?,
            fusion_window_ns: fusion_window_ns(self.tracker.fusion_window_seconds)?,
            motion: motion(&self.motion, footprint(self.footprint)?, primitives)?,
            speed_meters_per_second: positive(
                "speed_meters_per_second",
                self.speed_meters_per_second,
                1000.0,
            )?,
            initial_scan_ns: nanoseconds(self.initial_scan_seconds),
            on_fault: safety.on_fault.clone(),
            pose_timeout_ns: seconds("safety.pose_timeout_seconds", safety.pose_timeout_seconds)?,
            camera_timeout_ns: seconds("safety.camera_timeout_seconds", safety.camera_timeout_seconds)?,
            max_position_std_meters: positive("safety.max_position_std_meters", max_std, 1e6)?,
            recovery_ns: seconds("safety.recovery_seconds", safety.recovery_seconds)?,
        })
    }
}

fn tracker(table: &TrackerTable) -> Result<TrackerSettings, SettingsError> {
    let acceleration = table.acceleration_std_meters_per_second;
    if !(0.0..=1000.0).contains(&acceleration) {
        let key = "tracker.acceleration_std_meters_per_second";
        return Err(value(key, &acceleration, "0 to 1000"));
    }
    let settings = TrackerSettings {
        range_hypotheses: table.range_hypotheses,
        velocity_std: table.velocity_std_meters_per_second,
        acceleration_density: acceleration * acceleration,
        gate_radians: table.gate_degrees.to_radians(),
        confirm_hits: table.confirm_hits,
        initial_frames: table.initial_frames,
        max_misses: table.max_misses,
        track_timeout_seconds: table.track_timeout_seconds,
        miss_probability: table.miss_probability,
        false_alarms_per_frame: table.false_alarms_per_frame,
        pose_correlation_seconds: table.pose_correlation_seconds,
    };
    settings.check()?;
    Ok(settings)
}

fn fusion_window_ns(window_seconds: f64) -> Result<u64, SettingsError> {
    if !(0.0..=60.0).contains(&window_seconds) {
        return Err(value("tracker.fusion_window_seconds", &window_seconds, "0 to 60"));
    }
    Ok(nanoseconds(window_seconds))
}

fn footprint(table: FootprintTable) -> Result<Footprint, SettingsError> {
    // Its maximum size depends on the map: the planner checks that.
    match table {
        FootprintTable::Disc { radius_meters } if (0.0..=1e3).contains(&radius_meters) => {
            Ok(Footprint::Circle { radius_meters })
        }
        FootprintTable::Disc { radius_meters } => {
            Err(value("footprint.radius_meters", &radius_meters, "0 to 1000"))
        }
        FootprintTable::Rectangle { length_meters, width_meters } => Ok(Footprint::rectangle(
            positive("footprint.length_meters", length_meters, 1e3)?,
            positive("footprint.width_meters", width_meters, 1e3)?,
        )),
    }
}

fn motion(table: &MotionTable, footprint: Footprint, text: Option<&str>) -> Result<Motion, SettingsError> {
    let MotionTable::Lattice { max_expansions, replan_beyond_meters, .. } = *table else {
        return Ok(Motion::Goal);
    };
    if !(1000..=100_000_000).contains(&max_expansions) {
        return Err(value("motion.max_expansions", &max_expansions, "1000 to 100000000"));
    }
    let replan_beyond_meters = positive("motion.replan_beyond_meters", replan_beyond_meters, 1e6)?;
    let source = source(table, text)?;
    Ok(Motion::Lattice { source, footprint, max_expansions, replan_beyond_meters })
}

fn source(table: &MotionTable, text: Option<&str>) -> Result<Source, SettingsError> {
    let MotionTable::Lattice {
        primitives,
        turning_radius_meters,
        headings,
        reverse_cost,
        turn_in_place_cost,
        ..
    } = table
    else {
        return Err(value("motion.kind", &"goal", "lattice, where motions are asked for"));
    };
    if let Some(file) = primitives {
        let is_made = turning_radius_meters.is_some()
            || [headings, reverse_cost, turn_in_place_cost].iter().any(|key| key.is_some());
        if is_made {
            let allowed = "either a file, or turning_radius_meters, headings, reverse_cost and \
                           turn_in_place_cost to make motions of";
            return Err(value("motion.primitives", &format!("{file:?}"), allowed));
        }
        let text =
            text.ok_or_else(|| value("motion.primitives", &format!("{file:?}"), "a file that was read"))?;
        return Ok(Source::Read(mprim::read(text)?));
    }
    let multiplier = |key: &str, cost: Option<u32>| match cost {
        Some(cost) if !(1..=MAX_COST_MULTIPLIER).contains(&cost) => {
            Err(value(key, &cost, format!("1 to {MAX_COST_MULTIPLIER}")))
        }
        cost => Ok(cost),
    };
    Ok(Source::Made {
        headings: match headings.unwrap_or(16) {
            8 => Headings::Eight,
            16 => Headings::Sixteen,
            32 => Headings::ThirtyTwo,
            other => return Err(value("motion.headings", &other, "8, 16 or 32")),
        },
        turning_radius_meters: positive(
            "motion.turning_radius_meters",
            turning_radius_meters.unwrap_or(TURNING_RADIUS_METERS),
            1e4,
        )?,
        reverse: multiplier("motion.reverse_cost", *reverse_cost)?,
        turn_in_place: multiplier("motion.turn_in_place_cost", *turn_in_place_cost)?,
    })
}

impl Source {
    /// The motion primitives for a map of this resolution, meters.
    ///
    /// # Errors
    /// If no primitive of that radius fits the resolution.
    pub fn primitives(
        &self,
        resolution_meters: f64,
    ) -> Result<PrimitiveSet, dragnet_lattice::maneuvers::ManeuversError> {
        match *self {
            Self::Read(ref set) => Ok(set.clone()),
            Self::Made { headings, turning_radius_meters, reverse, turn_in_place } => {
                let maneuvers =
                    Maneuvers { resolution_meters, headings, turning_radius_meters, reverse, turn_in_place };
                maneuvers.primitives()
            }
        }
    }
}
