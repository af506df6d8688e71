//! What a node hears, checked.

use std::sync::Arc;

use dragnet_ros2::input::{Detections, Fix, GoalStatus, Image, Input, Occupancy, Odometry, PoseEstimate};
use dragnet_ros2::name::TopicName;

use super::settings::{Checked, Subscription};

/// What a node hears.
#[derive(Clone, Debug, PartialEq)]
pub enum Incoming {
    /// Where the robot is by its own reckoning, and how it moves.
    Odometry(Odometry),
    /// Where the robot is on the map.
    Pose(PoseEstimate),
    /// Where on earth it is.
    Fix(Fix),
    /// Where robots can be.
    Map(Occupancy),
    /// What a detector sees in an image.
    Detections {
        /// Of the camera of this name.
        camera: Arc<str>,
        /// All of one image.
        detections: Detections,
    },
    /// What a camera sees.
    Image {
        /// The camera of this name.
        camera: Arc<str>,
        /// What it sees.
        image: Image,
    },
    /// How Nav2's goals stand, for [`dragnet_ros2::navigation_goal::NavigationGoal`].
    Goals(Vec<GoalStatus>),
    /// Something on a topic that cannot be heard: it counts as nothing.
    Rejected {
        /// The topic.
        topic: TopicName,
        /// What is wrong, and what is allowed.
        reason: String,
    },
}

impl Checked {
    /// What the bytes of a message say that came on a subscribed topic.
    pub(crate) fn understand(&self, subscription: &Subscription, bytes: &[u8]) -> Incoming {
        let refused = |reason| Incoming::Rejected { topic: subscription.topic.clone(), reason };
        match subscription.kind.understand(bytes) {
            Ok(input) => self.place(subscription, input).unwrap_or_else(refused),
            Err(error) => refused(error.to_string()),
        }
    }

    /// What was heard, if its places are in the frame that they should be in.
    fn place(&self, subscription: &Subscription, input: Input) -> Result<Incoming, String> {
        let camera = || Arc::clone(&subscription.camera);
        let (map, odometry) = (&self.map_frame, &self.odometry_frame);
        Ok(match input {
            Input::Odometry(heard) => {
                in_frame(&heard.place.frame, odometry, "odometry_frame")?;
                Incoming::Odometry(heard)
            }
            Input::Pose(heard) => {
                in_frame(&heard.frame, map, "map_frame")?;
                Incoming::Pose(heard)
            }
            Input::Map(heard) => {
                in_frame(&heard.frame, map, "map_frame")?;
                Incoming::Map(heard)
            }
            Input::Fix(heard) => Incoming::Fix(heard),
            Input::Detections(detections) => Incoming::Detections { camera: camera(), detections },
            Input::Image(image) => Incoming::Image { camera: camera(), image },
            Input::Goals(heard) => Incoming::Goals(heard),
        })
    }
}

/// A place means something in its frame only. A slash before the name is of ROS 1.
fn in_frame(found: &str, expected: &str, key: &str) -> Result<(), String> {
    if found.trim_start_matches('/') == expected.trim_start_matches('/') {
        Ok(())
    } else {
        Err(format!("frame_id is {found:?}; allowed is {expected:?}, the {key} of the settings"))
    }
}
