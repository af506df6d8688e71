//! One image of one camera, on the map.

use std::collections::BTreeSet;

use nalgebra::Vector2;

use super::cubature::BearingMeasurement;
use super::mixture::Reach;
use super::pose_error::PoseError;
use crate::assignment::AssignmentError;
use crate::camera::{Camera, Detections, View};
use dragnet_lattice::plane::{Pose, wrapped_radians};

/// The detections of one camera at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Nanoseconds of mission time.
    pub time_ns: u64,
    /// The number of the camera.
    pub camera: u16,
    /// The camera's view.
    pub view: View,
    /// The detected bearings: radians on the map, counter-clockwise from east. All within the view, none twice.
    pub bearings_radians: Vec<f64>,
    /// Independent standard deviation of each bearing, radians, `1e-6..=0.5`: that of the detector's boxes.
    pub bearing_deviation_radians: f64,
    /// The error of the vehicle's pose, which all bearings around that time share.
    pub pose_error: PoseError,
}

/// Why a frame is invalid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FrameError {
    /// Older than the latest.
    #[error("a frame of {time_ns} ns after one of {latest_ns} ns: time runs backwards")]
    Backwards {
        /// Time of the frame.
        time_ns: u64,
        /// Time of the latest one.
        latest_ns: u64,
    },
    /// A repeated frame.
    #[error("camera {camera} has a second frame of {time_ns} ns")]
    Repeated {
        /// Time of the frame.
        time_ns: u64,
        /// The camera.
        camera: u16,
    },
    /// Too many bearings: a faulty detector.
    #[error("{0} bearings in a frame: allowed are {max}", max = Camera::MAX_BOXES)]
    TooMany(usize),
    /// A bearing is not finite.
    #[error("bearing {index} is {value}: not a number")]
    NotANumber {
        /// Its index in the frame.
        index: usize,
        /// The given value.
        value: f64,
    },
    /// A bearing in another frame of reference, or of another camera.
    #[error("bearing {index}, {value} radians, is outside of the camera's view")]
    OutOfView {
        /// Its index in the frame.
        index: usize,
        /// The given value.
        value: f64,
    },
    /// A repeated bearing.
    #[error("bearing {index}, {value} radians, is in the frame twice")]
    SameBearing {
        /// Its second index in the frame.
        index: usize,
        /// The given value.
        value: f64,
    },
    /// An impossible standard deviation.
    #[error("a bearing's standard deviation of {0} radians: allowed are 1e-6 to 0.5")]
    Deviation(f64),
    /// An invalid error of the pose.
    #[error("the error of a pose is no number of at least 0: {0:?}")]
    PoseError(PoseError),
    /// The assignment of bearings failed.
    #[error(transparent)]
    Assignment(#[from] AssignmentError),
}

/// Tolerance for rounding of bearings at the edge of the image, radians.
const EDGE_RADIANS: f64 = 1e-6;

/// Tolerance factor of a detector's ranges.
const RANGE_TOLERANCE: f64 = 1.25;

impl Frame {
    /// The detections of a camera on a vehicle.
    ///
    /// # Errors
    /// If the vehicle's pose is not finite.
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

    pub(super) fn measurement(&self, bearing: usize) -> BearingMeasurement {
        BearingMeasurement {
            from_meters: self.position_meters(),
            bearing_radians: self.bearings_radians[bearing],
            deviation_radians: self.bearing_deviation_radians,
        }
    }

    /// The ranges of a new track: most objects are first detected at the detector's maximum range, so the ranges must
    /// not end there.
    pub(super) fn reach(&self) -> Reach {
        let widest = self.widest_view(0.0);
        Reach { min_range_meters: widest.min_range_meters(), max_range_meters: widest.max_range_meters() }
    }

    /// The largest possible view: views end less sharply than the settings say.
    pub(super) fn widest_view(&self, beyond_radians: f64) -> View {
        self.view.widened(beyond_radians, RANGE_TOLERANCE)
    }

    /// The relative detection probability at a position: it falls off toward the ends of the detector's ranges.
    pub(super) fn visibility(&self, point_meters: Vector2<f64>) -> f64 {
        let is_in = |view: View| view.contains(point_meters);
        match () {
            () if is_in(self.surest_view(0.0)) => 1.0,
            () if is_in(self.view) => 0.5,
            () if is_in(self.widest_view(0.0)) => 0.2,
            () => 0.0,
        }
    }

    /// The smallest certain view.
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
