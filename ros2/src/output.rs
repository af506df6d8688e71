//! Messages that Dragnet publishes on a robot's own network.

mod object;

use super::input::PlanarPose;
use super::qos::Qos;
use crate::cdr;
use crate::schema::MessageType;
use crate::wire::robot::{DiagnosticArray, DiagnosticStatus, KeyValue};
use crate::wire::standard::{
    Header, MapMetaData, OccupancyGrid, Path, Point, Pose, PoseStamped, Quaternion, Time,
};
use crate::wire::vision::Detection3DArray;

pub use object::{ObjectEstimate, PlanarEstimate};

/// The content of a message.
#[derive(Clone, Debug, PartialEq)]
pub enum Output {
    /// `geometry_msgs/PoseStamped`: the next goal.
    Goal(PlanarPose),
    /// `nav_msgs/Path`: the goals after it, in order; empty when the robot rests.
    Path(Vec<PlanarPose>),
    /// `nav_msgs/OccupancyGrid`: the belief in percent, as returned by [`crate::viewer::Viewer::belief`], and the pose
    /// of its south-western corner.
    Belief(OccupancyGrid, PlanarPose),
    /// `vision_msgs/Detection3DArray`: declared objects, with the probability and the position covariance of each,
    /// which a `PoseArray` cannot hold.
    Objects(Vec<ObjectEstimate>),
    /// `vision_msgs/Detection3DArray`: the confirmed tracks of this robot, declared or not.
    Tracks(Vec<ObjectEstimate>),
    /// `diagnostic_msgs/DiagnosticArray`: the state of this program.
    Diagnostics(Vec<Diagnostic>),
}

/// The state of a part of this program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// The level.
    pub level: Level,
    /// The part, such as `dragnet: localization`.
    pub name: String,
    /// A short description.
    pub message: String,
    /// Names and values of counters.
    pub values: Vec<(String, String)>,
}

/// The level of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// No fault.
    Ok,
    /// It works, with a fault that needs attention.
    Warning,
    /// It does not work.
    Error,
    /// No data have arrived for a long time.
    Stale,
}

/// The purpose of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum OutputKind {
    /// [`Output::Goal`].
    Goal,
    /// [`Output::Path`].
    Path,
    /// [`Output::Belief`].
    Belief,
    /// [`Output::Objects`].
    Objects,
    /// [`Output::Tracks`].
    Tracks,
    /// [`Output::Diagnostics`].
    Diagnostics,
}

impl OutputKind {
    /// Its type on the network.
    #[must_use]
    pub fn message(self) -> MessageType {
        match self {
            Self::Goal => MessageType::of::<PoseStamped>(),
            Self::Path => MessageType::of::<Path>(),
            Self::Belief => MessageType::of::<OccupancyGrid>(),
            Self::Objects | Self::Tracks => MessageType::of::<Detection3DArray>(),
            Self::Diagnostics => MessageType::of::<DiagnosticArray>(),
        }
    }

    /// The quality of service of the publisher. A goal is not latched: a subscriber that joins late must not drive to
    /// an old goal.
    #[must_use]
    pub const fn qos(self) -> Qos {
        match self {
            Self::Goal | Self::Path | Self::Tracks | Self::Diagnostics => Qos::RELIABLE,
            Self::Belief | Self::Objects => Qos::LATCHED,
        }
    }
}

impl Output {
    /// The purpose of the message.
    #[must_use]
    pub const fn kind(&self) -> OutputKind {
        match self {
            Self::Goal(_) => OutputKind::Goal,
            Self::Path(_) => OutputKind::Path,
            Self::Belief(..) => OutputKind::Belief,
            Self::Objects(_) => OutputKind::Objects,
            Self::Tracks(_) => OutputKind::Tracks,
            Self::Diagnostics(_) => OutputKind::Diagnostics,
        }
    }

    /// Encodes the message, published at a Unix time in nanoseconds, with poses in a frame.
    #[must_use]
    pub fn encode(self, frame: &str, unix_ns: i64) -> Vec<u8> {
        let header = Header { stamp: Time::at_unix_ns(unix_ns.into()), frame_id: frame.to_owned() };
        match self {
            Self::Goal(goal) => cdr::encode(&PoseStamped { pose: pose(goal), header }),
            Self::Path(places) => {
                let stamped = |place| PoseStamped { header: header.clone(), pose: pose(place) };
                cdr::encode(&Path { poses: places.into_iter().map(stamped).collect(), header })
            }
            Self::Belief(belief, corner) => {
                let info = MapMetaData { origin: pose(corner), ..belief.info };
                cdr::encode(&OccupancyGrid { header, info, ..belief })
            }
            Self::Objects(objects) | Self::Tracks(objects) => {
                let detections =
                    objects.into_iter().map(|object| object::detection(object, &header)).collect();
                cdr::encode(&Detection3DArray { header, detections })
            }
            Self::Diagnostics(diagnostics) => {
                let status = diagnostics.into_iter().map(diagnostic_status).collect();
                cdr::encode(&DiagnosticArray { header, status })
            }
        }
    }
}

fn pose(place: PlanarPose) -> Pose {
    let (sine, cosine) = (place.yaw_radians / 2.0).sin_cos();
    Pose {
        position: Point { x: place.x_meters, y: place.y_meters, z: 0.0 },
        orientation: Quaternion { x: 0.0, y: 0.0, z: sine, w: cosine },
    }
}

fn diagnostic_status(diagnostic: Diagnostic) -> DiagnosticStatus {
    let level = match diagnostic.level {
        Level::Ok => 0,
        Level::Warning => 1,
        Level::Error => 2,
        Level::Stale => 3,
    };
    let values = diagnostic.values.into_iter().map(|(key, value)| KeyValue { key, value }).collect();
    DiagnosticStatus {
        level,
        name: diagnostic.name,
        message: diagnostic.message,
        hardware_id: String::new(),
        values,
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::wire::vision::ObjectHypothesis;

    #[test]
    fn a_goal_to_the_north_faces_north() {
        let goal = Output::Goal(PlanarPose { x_meters: 1.0, y_meters: -2.0, yaw_radians: FRAC_PI_2 });
        let bytes = goal.encode("map", 1_500_000_000);
        let decoded: PoseStamped = cdr::decode(&bytes).unwrap();
        assert_eq!(
            decoded.header,
            Header { stamp: Time { sec: 1, nanosec: 500_000_000 }, frame_id: "map".into() }
        );
        assert_eq!(decoded.pose.position, Point { x: 1.0, y: -2.0, z: 0.0 });
        let Quaternion { x, y, z, w } = decoded.pose.orientation;
        let half = 0.5_f64.sqrt();
        assert!(x == 0.0 && y == 0.0 && (z - half).abs() < 1e-12 && (w - half).abs() < 1e-12);
    }

    #[test]
    fn an_object_is_published_with_position_covariance_and_probability() {
        let object = ObjectEstimate {
            id: "7".into(),
            class: "person".into(),
            place: PlanarEstimate {
                x_meters: 29.0,
                y_meters: 46.0,
                covariance_square_meters: [[4.0, 1.0], [1.0, 9.0]],
            },
            box_center: PlanarPose { x_meters: 15.0, y_meters: 45.0, yaw_radians: FRAC_PI_2 },
            box_edges_meters: [30.0, 20.0],
            probability: 0.97,
        };
        let bytes = Output::Objects(vec![object]).encode("map", 0);
        let decoded: Detection3DArray = cdr::decode(&bytes).unwrap();
        let found = &decoded.detections[0];
        let place = &found.results[0].pose;
        assert_eq!((place.pose.position.x, place.pose.position.y), (29.0, 46.0));
        let reported: Vec<f64> = place.covariance.into_iter().flatten().collect();
        // x and y of ROS's six coordinates, row by row, and no others.
        let mut expected = vec![0.0; 36];
        for (place, value) in [(0, 4.0), (1, 1.0), (6, 1.0), (7, 9.0)] {
            expected[place] = value;
        }
        assert_eq!(reported, expected);
        assert_eq!((found.bbox.center.position.x, found.bbox.center.position.y), (15.0, 45.0));
        assert_eq!((found.bbox.size.x, found.bbox.size.y), (30.0, 20.0));
        assert!((found.bbox.center.orientation.z - 0.5_f64.sqrt()).abs() < 1e-12);
        let hypothesis = ObjectHypothesis { class_id: "person".into(), score: 0.97 };
        assert_eq!((&found.results[0].hypothesis, found.id.as_str()), (&hypothesis, "7"));
    }
}
