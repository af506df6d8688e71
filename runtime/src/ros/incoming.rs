//! Messages that a node receives, checked.

use std::sync::Arc;

use dragnet_ros2::input::{
    Battery, CameraInfo, Detections, Fix, GoalStatus, Image, Input, Occupancy, Odometry, PoseEstimate,
    Transforms,
};
use dragnet_ros2::name::TopicName;

use super::settings::{Checked, Subscription};

/// A message that a node receives.
#[derive(Clone, Debug, PartialEq)]
pub enum Incoming {
    /// The robot's pose by odometry, and its velocity.
    Odometry(Odometry),
    /// The robot's pose on the map.
    Pose(PoseEstimate),
    /// The robot's position on the earth.
    Fix(Fix),
    /// Traversable cells.
    Map(Occupancy),
    /// A detector's boxes in an image.
    Detections {
        /// Name of the camera.
        camera: Arc<str>,
        /// All boxes of one image.
        detections: Detections,
    },
    /// An image of a camera.
    Image {
        /// Name of the camera.
        camera: Arc<str>,
        /// The image.
        image: Image,
    },
    /// The states of Nav2's goals, for [`dragnet_ros2::navigation_goal::NavigationGoal`].
    Goals(Vec<GoalStatus>),
    /// Where frames are at a time.
    Transforms(Transforms),
    /// Where frames are at all times.
    StaticTransforms(Transforms),
    /// A camera's calibration.
    CameraInfo {
        /// Name of the camera.
        camera: Arc<str>,
        /// The calibration.
        info: CameraInfo,
    },
    /// Whether the robot is stopped.
    Stop(bool),
    /// The charge of the battery.
    Battery(Battery),
    /// An invalid message, which does not count.
    Rejected {
        /// The topic.
        topic: TopicName,
        /// The reason, with the allowed values.
        reason: String,
    },
}

impl Checked {
    /// Decodes the bytes of a message that arrived on a subscribed topic.
    pub(crate) fn understand(&self, subscription: &Subscription, bytes: &[u8]) -> Incoming {
        let refused = |reason| Incoming::Rejected { topic: subscription.topic.clone(), reason };
        match subscription.kind.understand(bytes) {
            Ok(input) => self.place(subscription, input).unwrap_or_else(refused),
            Err(error) => refused(error.to_string()),
        }
    }

    /// Checks that positions are in the expected frame.
    fn place(&self, subscription: &Subscription, input: Input) -> Result<Incoming, String> {
        let camera = || Arc::clone(&subscription.camera);
        let (map, odometry) = (&self.map_frame, &self.odometry_frame);
        Ok(match input {
            Input::Odometry(received) => {
                in_frame(&received.place.frame, odometry, "odometry_frame")?;
                Incoming::Odometry(received)
            }
            Input::Pose(received) => {
                in_frame(&received.frame, map, "map_frame")?;
                Incoming::Pose(received)
            }
            Input::Map(received) => {
                in_frame(&received.frame, map, "map_frame")?;
                Incoming::Map(received)
            }
            Input::Fix(received) => Incoming::Fix(received),
            Input::Detections(detections) => Incoming::Detections { camera: camera(), detections },
            Input::Image(image) => Incoming::Image { camera: camera(), image },
            Input::Goals(received) => Incoming::Goals(received),
            Input::Transforms(received) => Incoming::Transforms(received),
            Input::StaticTransforms(received) => Incoming::StaticTransforms(received),
            Input::CameraInfo(info) => Incoming::CameraInfo { camera: camera(), info },
            Input::Stop(is_stopped) => Incoming::Stop(is_stopped),
            Input::Battery(received) => Incoming::Battery(received),
        })
    }
}

/// Positions have a meaning in their frame only. A leading slash in the name is from ROS 1.
fn in_frame(found: &str, expected: &str, key: &str) -> Result<(), String> {
    if found.trim_start_matches('/') == expected.trim_start_matches('/') {
        Ok(())
    } else {
        Err(format!("frame_id is {found:?}; allowed is {expected:?}, the {key} of the settings"))
    }
}
