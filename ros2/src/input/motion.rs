//! A robot's pose and velocity, reduced to the plane.

use dragnet_scenario::map_file::{GeoPoint, Georeference};

use super::InputError;
use super::check::Check;
use crate::schema::RosMessage;
use crate::wire::{robot, standard};

/// The first entry by which drivers mark an unknown covariance.
const UNKNOWN: f64 = -1.0;
/// Rounding tolerance of a covariance, as a share of the variances.
const COVARIANCE_TOLERANCE: f64 = 1e-3;
/// Indices of x, y and yaw among x, y, z and the rotations about them.
const PLANE: [usize; 3] = [0, 1, 5];

/// A position and a direction on the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanarPose {
    /// Meters along the frame's first axis; east on a map.
    pub x_meters: f64,
    /// Meters along its second axis; north on a map.
    pub y_meters: f64,
    /// Counter-clockwise from the first axis, radians, `-pi..=pi`.
    pub yaw_radians: f64,
}

/// Covariance of x, y (meters) and yaw (radians), row-major, shape `[3, 3]`: symmetric, with a diagonal of at least 0.
pub type PlanarCovariance = [[f64; 3]; 3];

/// A robot's pose, as estimated by localization.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseEstimate {
    /// When, Unix nanoseconds.
    pub stamp_unix_ns: i64,
    /// The frame of the pose, such as `map`; at most 256 bytes.
    pub frame: String,
    /// The pose.
    pub pose: PlanarPose,
    /// Its covariance; `None` if its publisher left it 0 or put -1 first, as for unknown.
    pub covariance: Option<PlanarCovariance>,
}

/// A robot's velocity, in its own frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Velocity {
    /// Meters per second.
    pub forward_meters_per_second: f64,
    /// Meters per second.
    pub left_meters_per_second: f64,
    /// Counter-clockwise, radians a second.
    pub yaw_radians_per_second: f64,
}

/// A robot's pose by dead reckoning, and its velocity.
#[derive(Clone, Debug, PartialEq)]
pub struct Odometry {
    /// The pose, in a frame that may drift, such as `odom`.
    pub place: PoseEstimate,
    /// The robot's own frame, such as `base_link`.
    pub robot_frame: String,
    /// The velocity.
    pub velocity: Velocity,
}

/// A position by satellites.
#[derive(Clone, Debug, PartialEq)]
pub struct Fix {
    /// When, Unix nanoseconds.
    pub stamp_unix_ns: i64,
    /// The frame of the antenna.
    pub frame: String,
    /// The position.
    pub point: GeoPoint,
    /// Above the ellipsoid, meters, if known.
    pub altitude_meters: Option<f64>,
    /// Covariance of east and north, square meters, row-major, if known.
    pub covariance_square_meters: Option<[[f64; 2]; 2]>,
}

impl Fix {
    /// Meters east and north of the origin of a map's frame.
    #[must_use]
    pub fn meters(&self, frame: &Georeference) -> (f64, f64) {
        frame.meters(self.point)
    }

    pub(super) fn check(fix: &robot::NavSatFix) -> Result<Self, InputError> {
        let check = Check { message: robot::NavSatFix::NAME };
        let (stamp_unix_ns, frame) = check.header(&fix.header)?;
        if fix.status.status < 0 {
            return check.refused("status.status", fix.status.status, "0 or more, a fix");
        }
        let point = GeoPoint {
            latitude_degrees: check.within("latitude", fix.latitude, &(-90.0..=90.0))?,
            longitude_degrees: check.within("longitude", fix.longitude, &(-180.0..=180.0))?,
        };
        let altitude_meters =
            if fix.altitude.is_nan() { None } else { Some(check.finite("altitude", fix.altitude)?) };
        let covariance_square_meters = match fix.position_covariance_type {
            0 => None,
            _ => Some(check.covariance("position_covariance", &fix.position_covariance, [0, 1])?),
        };
        Ok(Self { stamp_unix_ns, frame, point, altitude_meters, covariance_square_meters })
    }
}

impl PoseEstimate {
    pub(super) fn check(pose: &robot::PoseWithCovarianceStamped) -> Result<Self, InputError> {
        let check = Check { message: robot::PoseWithCovarianceStamped::NAME };
        check.estimate(&pose.header, &pose.pose)
    }
}

impl Odometry {
    pub(super) fn check(odometry: &robot::Odometry) -> Result<Self, InputError> {
        let check = Check { message: robot::Odometry::NAME };
        let place = check.estimate(&odometry.header, &odometry.pose)?;
        let robot_frame = check.text("child_frame_id", &odometry.child_frame_id)?.to_owned();
        let twist = &odometry.twist.twist;
        let velocity = Velocity {
            forward_meters_per_second: check.finite("twist.twist.linear.x", twist.linear.x)?,
            left_meters_per_second: check.finite("twist.twist.linear.y", twist.linear.y)?,
            yaw_radians_per_second: check.finite("twist.twist.angular.z", twist.angular.z)?,
        };
        Ok(Self { place, robot_frame, velocity })
    }
}

impl Check {
    fn estimate(
        self,
        header: &standard::Header,
        pose: &robot::PoseWithCovariance,
    ) -> Result<PoseEstimate, InputError> {
        let (stamp_unix_ns, frame) = self.header(header)?;
        let is_unknown = pose.covariance[0][0].to_bits() == UNKNOWN.to_bits()
            || pose.covariance.iter().flatten().all(|&entry| entry == 0.0);
        let covariance = if is_unknown {
            None
        } else {
            Some(self.covariance("pose.covariance", &pose.covariance, PLANE)?)
        };
        Ok(PoseEstimate { stamp_unix_ns, frame, pose: self.pose("pose.pose", &pose.pose)?, covariance })
    }

    pub(super) fn pose(self, field: &str, pose: &standard::Pose) -> Result<PlanarPose, InputError> {
        Ok(PlanarPose {
            x_meters: self.finite(&format!("{field}.position.x"), pose.position.x)?,
            y_meters: self.finite(&format!("{field}.position.y"), pose.position.y)?,
            yaw_radians: self.yaw_radians(&format!("{field}.orientation"), pose.orientation)?,
        })
    }

    /// The yaw of a quaternion in the decomposition into yaw, pitch and roll.
    fn yaw_radians(self, field: &str, quaternion: standard::Quaternion) -> Result<f64, InputError> {
        let standard::Quaternion { x, y, z, w } = self.rotation(field, quaternion)?;
        Ok((2.0 * (w * z + x * y)).atan2(w * w + x * x - y * y - z * z))
    }

    /// A submatrix of a covariance.
    fn covariance<const SIZE: usize, const PART: usize>(
        self,
        field: &str,
        covariance: &[[f64; SIZE]; SIZE],
        part: [usize; PART],
    ) -> Result<[[f64; PART]; PART], InputError> {
        let part = part.map(|row| part.map(|column| covariance[row][column]));
        let allowed =
            "a covariance: finite, symmetric, no variance below 0, no covariance above its variances";
        for row in 0..PART {
            for column in 0..PART {
                let (entry, mirrored) = (part[row][column], part[column][row]);
                let bound = (part[row][row] * part[column][column]).sqrt() * (1.0 + COVARIANCE_TOLERANCE);
                let differs = (entry - mirrored).abs() > COVARIANCE_TOLERANCE * bound;
                if !entry.is_finite() || part[row][row] < 0.0 || entry.abs() > bound || differs {
                    return self.refused(field, format!("{part:?}"), allowed);
                }
            }
        }
        Ok(part)
    }
}
