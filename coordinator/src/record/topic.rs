//! The topics of a recording.

use std::collections::BTreeMap;
use std::fmt;

use dragnet_search::observation::Source;

/// The topic of a message in a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Topic {
    /// The ground, `nav_msgs/msg/OccupancyGrid`.
    Map,
    /// The belief in percent, `nav_msgs/msg/OccupancyGrid`.
    Belief,
    /// The belief, `foxglove_msgs/msg/Grid`.
    BeliefProbability,
    /// Poses of robots, `tf2_msgs/msg/TFMessage`.
    Transforms,
    /// The areas drawn on the map, `foxglove_msgs/msg/GeoJSON`; if the map lies on the earth and has any.
    Areas,
    /// All declared objects, `visualization_msgs/msg/Marker`, when they change.
    Marker,
    /// All declared objects, `foxglove_msgs/msg/GeoJSON`, when they change; if the map lies on the earth.
    Places,
    /// The best picture of each find, `sensor_msgs/msg/CompressedImage`, when one arrives.
    Pictures,
    /// Each declaration of an object, `dragnet_msgs/msg/Detection`.
    Objects,
    /// `dragnet_msgs/msg/MissionStatus`.
    MissionStatus,
    /// A topic of one robot, or of the operator.
    Robot(Source, RobotTopic),
}

/// The topics of each robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RobotTopic {
    /// `geometry_msgs/msg/PoseStamped`.
    Pose,
    /// `sensor_msgs/msg/NavSatFix`, if the map lies on the earth.
    Fix,
    /// The plan, `nav_msgs/msg/Path`.
    Path,
    /// `dragnet_msgs/msg/Observation`.
    Observation,
    /// `dragnet_msgs/msg/Intent`.
    Intent,
    /// `dragnet_msgs/msg/Heartbeat`.
    Heartbeat,
    /// `dragnet_msgs/msg/Verdicts`.
    Verdicts,
    /// `dragnet_msgs/msg/Orders`.
    Orders,
    /// `dragnet_msgs/msg/Zones`.
    Zones,
    /// `dragnet_msgs/msg/Marks`.
    Marks,
    /// Pictures of finds, `dragnet_msgs/msg/Picture`.
    Picture,
}

impl Topic {
    const ROBOTS: &str = "/robots/";
    pub(crate) const MISSION_STATUS: &str = "/mission/status";

    /// Whether its messages report events; those of all other topics are the state of something, which the next one
    /// replaces.
    pub(crate) const fn is_of_events(self) -> bool {
        matches!(self, Self::Objects | Self::Robot(_, RobotTopic::Observation | RobotTopic::Picture))
    }

    /// Metadata of the channel: the quality of service with which `ros2 bag play` offers it.
    pub(crate) fn metadata(self) -> BTreeMap<String, String> {
        let durability = match self {
            Self::Map
            | Self::Belief
            | Self::BeliefProbability
            | Self::MissionStatus
            | Self::Areas
            | Self::Marker
            | Self::Places => TRANSIENT_LOCAL,
            Self::Transforms | Self::Objects | Self::Pictures | Self::Robot(..) => VOLATILE,
        };
        BTreeMap::from([("offered_qos_profiles".to_owned(), quality_of_service(durability))])
    }
}

impl fmt::Display for Topic {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Map => formatter.write_str("/map"),
            Self::Belief => formatter.write_str("/belief"),
            Self::BeliefProbability => formatter.write_str("/belief/probability"),
            Self::Transforms => formatter.write_str("/tf"),
            Self::Areas => formatter.write_str("/areas/geojson"),
            Self::Marker => formatter.write_str("/objects/marker"),
            Self::Places => formatter.write_str("/objects/geojson"),
            Self::Pictures => formatter.write_str("/objects/picture"),
            Self::Objects => formatter.write_str("/objects"),
            Self::MissionStatus => formatter.write_str(Self::MISSION_STATUS),
            Self::Robot(source, topic) => {
                write!(formatter, "{}{}/{}", Self::ROBOTS, source.number(), topic.name())
            }
        }
    }
}

impl RobotTopic {
    const ALL: [Self; 11] = [
        Self::Pose,
        Self::Fix,
        Self::Path,
        Self::Observation,
        Self::Intent,
        Self::Heartbeat,
        Self::Verdicts,
        Self::Orders,
        Self::Zones,
        Self::Marks,
        Self::Picture,
    ];

    const fn name(self) -> &'static str {
        match self {
            Self::Pose => "pose",
            Self::Fix => "fix",
            Self::Path => "path",
            Self::Observation => "observation",
            Self::Intent => "intent",
            Self::Heartbeat => "heartbeat",
            Self::Verdicts => "verdicts",
            Self::Orders => "orders",
            Self::Zones => "zones",
            Self::Marks => "marks",
            Self::Picture => "picture",
        }
    }

    /// The source and the subject of a topic, if it belongs to a robot or the operator.
    pub(crate) fn parse(topic: &str) -> Option<(Source, Self)> {
        let (number, name) = topic.strip_prefix(Topic::ROBOTS)?.split_once('/')?;
        let topic = Self::ALL.into_iter().find(|topic| topic.name() == name)?;
        Some((Source::numbered(number.parse().ok()?), topic))
    }
}

const TRANSIENT_LOCAL: u8 = 1;
const VOLATILE: u8 = 2;

/// In the numbers of rosbag2's metadata up to version 8, which later versions read too: keep the last of history,
/// reliable, no deadline, automatic liveliness.
fn quality_of_service(durability: u8) -> String {
    let depth = if durability == TRANSIENT_LOCAL { 1 } else { 10 };
    let forever = "\n    sec: 9223372036\n    nsec: 854775807";
    format!(
        "- history: 1\n  depth: {depth}\n  reliability: 1\n  durability: {durability}\n  deadline:{forever}\n  \
         lifespan:{forever}\n  liveliness: 1\n  liveliness_lease_duration:{forever}\n  \
         avoid_ros_namespace_conventions: false"
    )
}

#[cfg(test)]
mod tests {
    use dragnet_search::observation::RobotId;

    use super::*;

    #[test]
    fn a_robots_topic_contains_its_number() {
        for source in [Source::Operator, RobotId::new(12).unwrap().into()] {
            for topic in RobotTopic::ALL {
                let text = Topic::Robot(source, topic).to_string();
                assert_eq!(RobotTopic::parse(&text), Some((source, topic)), "{text}");
            }
        }
        for none in ["/belief", "/robots/1", "/robots/x/pose", "/robots/1/pose/x", "robots/1/pose"] {
            assert_eq!(RobotTopic::parse(none), None, "{none}");
        }
    }
}
