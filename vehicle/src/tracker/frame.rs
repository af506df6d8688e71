//! What one camera saw at one time, on the map.

use std::collections::BTreeSet;

use nalgebra::Vector2;

use super::cubature::Sight;
use super::mixture::Reach;
use super::pose_error::PoseError;
use crate::assignment::AssignmentError;
use crate::camera::{Camera, Detections, View};
use dragnet_lattice::plane::{Pose, wrapped_radians};

/// What one camera saw at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// When, nanoseconds of mission time.
    pub time_ns: u64,
    /// Which camera: a number of its own.
    pub camera: u16,
    /// What it could see, from where.
    pub view: View,
    /// What it saw: radians on the map, counter-clockwise from east. All within the view, none twice.
    pub bearings_radians: Vec<f64>,
    /// Standard deviation of a bearing, radians, `1e-6..=0.5`, that each has of its own: of the detector's
    /// boxes.
    pub bearing_deviation_radians: f64,
    /// How far off the vehicle's pose may be, which all bearings around that time share.
    pub pose_error: PoseError,
}

/// A frame that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FrameError {
    /// Older than the latest.
    #[error("a frame of {time_ns} ns after one of {latest_ns} ns: time runs backwards")]
    Backwards {
        /// Of the frame.
        time_ns: u64,
        /// Of the latest one.
        latest_ns: u64,
    },
    /// Told twice.
    #[error("camera {camera} has a second frame of {time_ns} ns")]
    Repeated {
        /// Of the frame.
        time_ns: u64,
        /// Whose frame.
        camera: u16,
    },
    /// A detector at fault.
    #[error("{0} bearings in a frame: allowed are {max}", max = Camera::MAX_BOXES)]
    TooMany(usize),
    /// A bearing is missing.
    #[error("bearing {index} is {value}: not a number")]
    NotANumber {
        /// Its place in the frame.
        index: usize,
        /// As given.
        value: f64,
    },
    /// A bearing in another frame of reference, or of another camera.
    #[error("bearing {index}, {value} radians, is outside of the camera's view")]
    OutOfView {
        /// Its place in the frame.
        index: usize,
        /// As given.
        value: f64,
    },
    /// A bearing told twice.
    #[error("bearing {index}, {value} radians, is in the frame twice")]
    SameBearing {
        /// Its second place in the frame.
        index: usize,
        /// As given.
        value: f64,
    },
    /// A noise that no camera has.
    #[error("a bearing's standard deviation of {0} radians: allowed are 1e-6 to 0.5")]
    Deviation(f64),
    /// Not an error of a pose.
    #[error("the error of a pose is no number of at least 0: {0:?}")]
    PoseError(PoseError),
    /// A track's bearing could not be told.
    #[error(transparent)]
    Assignment(#[from] AssignmentError),
}

/// Bearings at the very edge of the image may miss the view by rounding, radians.
const EDGE_RADIANS: f64 = 1e-6;

/// A detector's ranges may be off by this factor.
const RANGE_TOLERANCE: f64 = 1.25;

impl Frame {
    /// What a camera on a vehicle detected.
    ///
    /// # Errors
    /// If the vehicle's pose is no number.
    pub fn of_camera(
        camera: &Camera,
        number: u16,
        vehicle: &Pose,
        detections: &Detections,
        time_ns: u64,
        bearing_deviation_radians: f64,
        pose_error: PoseError,
    ) -> Result<Self, crate::camera::ViewError> {
        let on_map = |bearing: &f64| wrapped_radians(vehicle.heading_radians + bearing);
        Ok(Self {
            time_ns,
            camera: number,
            view: camera.view(vehicle)?,
            bearings_radians: detections.bearings_radians.iter().map(on_map).collect(),
            bearing_deviation_radians,
            pose_error,
        })
    }

    pub(super) fn position_meters(&self) -> Vector2<f64> {
        self.view.camera().position_meters()
    }

    pub(super) fn sight(&self, bearing: usize) -> Sight {
        Sight {
            from_meters: self.position_meters(),
            bearing_radians: self.bearings_radians[bearing],
            deviation_radians: self.bearing_deviation_radians,
        }
    }

    /// Where something can be that was seen: most things are seen first from as far as a detector can, so that
    /// the ranges must not end there.
    pub(super) fn reach(&self) -> Reach {
        let widest = self.widest_view(0.0);
        Reach { min_range_meters: widest.min_range_meters(), max_range_meters: widest.max_range_meters() }
    }

    /// What can be seen at most: views end less sharply than the settings say.
    pub(super) fn widest_view(&self, beyond_radians: f64) -> View {
        self.view.widened(beyond_radians, RANGE_TOLERANCE)
    }

    /// How often something at a place is detected, of what is detected at best: it falls off toward the ends of
    /// the detector's ranges.
    pub(super) fn visibility(&self, point_meters: Vector2<f64>) -> f64 {
        let is_in = |view: View| view.contains(point_meters);
        match () {
            () if is_in(self.surest_view(0.0)) => 1.0,
            () if is_in(self.view) => 0.5,
            () if is_in(self.widest_view(0.0)) => 0.2,
            () => 0.0,
        }
    }

    /// What is seen at least.
    pub(super) fn surest_view(&self, beyond_radians: f64) -> View {
        self.view.widened(-beyond_radians, 1.0 / RANGE_TOLERANCE)
    }

    pub(super) fn check(&self) -> Result<(), FrameError> {
        if self.bearings_radians.len() > Camera::MAX_BOXES {
            return Err(FrameError::TooMany(self.bearings_radians.len()));
        }
        // Written so that NaN fails as well.
        if !(1e-6..=0.5).contains(&self.bearing_deviation_radians) {
            return Err(FrameError::Deviation(self.bearing_deviation_radians));
        }
        if !self.pose_error.is_sound() {
            return Err(FrameError::PoseError(self.pose_error));
        }
        let mut known = BTreeSet::new();
        for (index, &value) in self.bearings_radians.iter().enumerate() {
            if !value.is_finite() {
                return Err(FrameError::NotANumber { index, value });
            }
            if self.view.radians_beyond(value) > EDGE_RADIANS {
                return Err(FrameError::OutOfView { index, value });
            }
            if !known.insert(wrapped_radians(value).to_bits()) {
                return Err(FrameError::SameBearing { index, value });
            }
        }
        Ok(())
    }
}
