//! Settings of a robot's ROS 2 network, and the resulting subscriptions and publishers.

mod cameras;
mod interlocks;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use dragnet_ros2::input::InputKind;
use dragnet_ros2::name::{Namespace, NodeName, TopicName};
use dragnet_ros2::output::OutputKind;
use dragnet_vehicle::settings::Measured;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::RuntimeError;
pub use cameras::{Camera, Mounting};
pub use interlocks::{Battery, EmergencyStop, LowBattery};

/// The highest domain of ROS 2.
const MAX_DOMAIN: u32 = 232;
/// The most cameras of one robot.
const MAX_CAMERAS: usize = 16;

/// The table `[ros]`; only `transport` is required. Topic names are as in ROS: absolute with a leading slash, private with
/// `~/`, else relative to the namespace. An empty name is neither subscribed to nor published.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Transport of the ROS 2 network.
    #[schemars(extend("examples" = ["rmw_zenoh"]))]
    pub transport: Transport,
    /// ROS domain of `rmw_zenoh`, 0 to 232; behind a bridge it is the bridge's.
    #[serde(default)]
    pub domain: u32,
    /// Namespace of relative names, such as `/robot1`; the root if empty.
    #[serde(default)]
    pub namespace: String,
    /// Name of the node.
    #[serde(default = "node")]
    pub node: String,
    /// Frame of maps, poses and everything that is published.
    #[serde(default = "map")]
    pub map_frame: String,
    /// Frame of odometry; `map` only if the robot corrects its odometry against the map.
    #[serde(default = "odom")]
    pub odometry_frame: String,
    /// The vehicle's own frame, whose origin is its reference point, on the ground: of `localization = "tf"`, and of cameras
    /// whose mounting comes from `tf`.
    #[serde(default = "base_link")]
    pub robot_frame: String,
    /// Source of the pose.
    #[serde(default)]
    pub localization: Localization,
    /// Time without a pose or fix after which the pose is lost, seconds, if the vehicle has meanwhile moved farther than
    /// the next two keys allow. (AMCL publishes only while the vehicle moves.)
    #[serde(default = "localization_timeout_seconds")]
    pub localization_timeout_seconds: f64,
    /// Distance that it may move by odometry alone after that time, meters, above 0.
    #[serde(default = "max_uncorrected_meters")]
    pub max_uncorrected_meters: f64,
    /// Angle that it may turn by odometry alone after that time, degrees, above 0.
    #[serde(default = "max_uncorrected_degrees")]
    pub max_uncorrected_degrees: f64,
    /// Standard deviation of a position whose message has none, such as a transform, meters, above 0 to 1000; the default is 2
    /// for a fix, and else 0.1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_std_meters: Option<f64>,
    /// Standard deviation of a heading whose message has none, degrees, above 0 to 90.
    #[serde(default = "heading_std_degrees")]
    pub heading_std_degrees: f64,
    /// Meaning of the stamps of messages.
    #[serde(default)]
    pub stamps: Stamps,
    /// The session with the ROS 2 network.
    #[serde(default)]
    pub zenoh: Network,
    /// Topics that the robot subscribes to.
    #[serde(default)]
    pub subscribe: Subscribe,
    /// Topics that the robot publishes, in `map_frame`.
    #[serde(default)]
    pub publish: Publish,
    /// Topics of cameras and of external detectors.
    #[serde(default)]
    pub cameras: Vec<Camera>,
    /// A topic that stops the robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub emergency_stop: Option<EmergencyStop>,
    /// The charge of the battery.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub battery: Option<Battery>,
}

/// Transport of a ROS 2 network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Transport {
    /// Nodes whose middleware is `rmw_zenoh_cpp`, of ROS 2 Jazzy.
    RmwZenoh,
    /// Nodes of another middleware, behind a `zenoh-bridge-ros2dds`.
    Bridge,
}

/// Source of a pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Localization {
    /// Poses in `map_frame`, with odometry in between.
    #[default]
    Pose,
    /// Odometry alone, in a frame that coincides with `map_frame`.
    Odometry,
    /// GNSS fixes, with odometry in between whose x axis points east. The map must be georeferenced.
    Fix,
    /// Transforms from `map_frame` to `robot_frame`, by way of any others, such as odometry's.
    Tf,
}

/// Limits of a vehicle's motion by odometry alone, after which it is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Uncorrected {
    /// Time within which it may move freely, nanoseconds.
    pub(crate) timeout_ns: u64,
    pub(crate) meters: f64,
    pub(crate) radians: f64,
}

/// Standard deviations of a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PoseStd {
    /// Of each coordinate.
    pub(crate) meters: f64,
    /// Of the heading.
    pub(crate) radians: f64,
}

/// Meaning of the stamps of messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stamps {
    /// Time by this computer's clock, as on robots with synchronized clocks.
    #[default]
    Clock,
    /// Ignored: the time of arrival counts. For robots with another or a simulated clock.
    Arrival,
}

/// A Zenoh session with a ROS 2 network. Scouting is off.
#[derive(Clone, Debug, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Network {
    /// Zenoh endpoints to connect to: of `rmw_zenohd`, or of the bridge. Those that do not answer are tried again.
    pub connect: Vec<String>,
    /// Zenoh endpoints to listen on; of peers only.
    pub listen: Vec<String>,
    /// Role of the session.
    pub mode: Mode,
    /// Further settings of Zenoh, a JSON5 file, relative to the file that names it.
    pub config: Option<PathBuf>,
}

impl Default for Network {
    /// The router of `rmw_zenoh` on this computer.
    fn default() -> Self {
        Self {
            connect: vec!["tcp/localhost:7447".to_owned()],
            listen: Vec::new(),
            mode: Mode::Client,
            config: None,
        }
    }
}

/// The role of a session in a ROS 2 network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Communicates through one router or bridge.
    #[default]
    Client,
    /// Communicates with direct connections only.
    Peer,
}

/// Topics that the robot subscribes to.
#[derive(Clone, Debug, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Subscribe {
    /// Topic of `nav_msgs/Odometry`, in `odometry_frame`.
    pub odometry: String,
    /// `geometry_msgs/PoseWithCovarianceStamped`, in `map_frame`: of AMCL or another localization.
    pub pose: String,
    /// `sensor_msgs/NavSatFix`.
    pub fix: String,
    /// `nav_msgs/OccupancyGrid`, in `map_frame`.
    pub map: String,
    /// `action_msgs/GoalStatusArray`, the states of Nav2's goals.
    pub goals: String,
    /// `tf2_msgs/TFMessage`: transforms, if the pose or the mounting of a camera comes from them.
    pub tf: String,
    /// `tf2_msgs/TFMessage`, latched: transforms that hold at all times.
    pub tf_static: String,
}

impl Default for Subscribe {
    fn default() -> Self {
        let [odometry, pose, fix, map, goals, tf, tf_static] =
            ["odom", "amcl_pose", "fix", "map", "navigate_to_pose/_action/status", "/tf", "/tf_static"]
                .map(str::to_owned);
        Self { odometry, pose, fix, map, goals, tf, tf_static }
    }
}

/// Topics that the robot publishes, all in `map_frame`.
#[derive(Clone, Debug, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Publish {
    /// `geometry_msgs/PoseStamped`: the goal of Nav2's `bt_navigator`.
    pub goal: String,
    /// `nav_msgs/Path`.
    pub path: String,
    /// `nav_msgs/OccupancyGrid`, percent.
    pub belief: String,
    /// `vision_msgs/Detection3DArray`: the declared objects.
    pub objects: String,
    /// `vision_msgs/Detection3DArray`: the confirmed tracks of this robot.
    pub tracks: String,
    /// `diagnostic_msgs/DiagnosticArray`.
    pub diagnostics: String,
}

impl Default for Publish {
    fn default() -> Self {
        let [goal, path, belief, objects, tracks, diagnostics] =
            ["goal_pose", "~/path", "~/belief", "~/objects", "~/tracks", "/diagnostics"].map(str::to_owned);
        Self { goal, path, belief, objects, tracks, diagnostics }
    }
}

fn node() -> String {
    "dragnet".to_owned()
}

fn map() -> String {
    "map".to_owned()
}

fn base_link() -> String {
    "base_link".to_owned()
}

fn odom() -> String {
    "odom".to_owned()
}

const fn localization_timeout_seconds() -> f64 {
    5.0
}

/// Four times the distance after which AMCL publishes.
const fn max_uncorrected_meters() -> f64 {
    1.0
}

/// Four times the angle after which AMCL publishes.
const fn max_uncorrected_degrees() -> f64 {
    45.0
}

const fn heading_std_degrees() -> f64 {
    1.0
}

/// Settings that have been checked.
#[derive(Clone, Debug)]
pub struct Checked {
    pub(super) transport: Transport,
    pub(super) domain: u32,
    pub(super) namespace: Namespace,
    pub(super) node: NodeName,
    localization: Localization,
    pub(crate) uncorrected: Uncorrected,
    pub(crate) unstated: PoseStd,
    stamps: Stamps,
    pub(crate) map_frame: String,
    pub(super) odometry_frame: String,
    pub(crate) robot_frame: String,
    pub(crate) emergency_stop: Option<EmergencyStop>,
    pub(crate) battery: Option<Battery>,
    pub(super) network: Network,
    pub(crate) subscriptions: Vec<Subscription>,
    pub(crate) publications: BTreeMap<OutputKind, TopicName>,
}

impl Checked {
    /// The source of the robot's pose.
    #[must_use]
    pub const fn localization(&self) -> Localization {
        self.localization
    }

    /// The meaning of stamps.
    #[must_use]
    pub const fn stamps(&self) -> Stamps {
        self.stamps
    }

    /// Cameras whose images are subscribed to.
    pub(crate) fn cameras_with_images(&self) -> impl Iterator<Item = &Arc<str>> {
        let is_image = |kind| matches!(kind, InputKind::Image | InputKind::CompressedImage);
        self.subscriptions.iter().filter(move |one| is_image(one.kind)).map(|one| &one.camera)
    }

    /// Cameras with images whose boxes come from another program.
    pub(crate) fn cameras_with_pictures(&self) -> BTreeSet<Arc<str>> {
        self.cameras_with_images().filter(|camera| self.is_detected_elsewhere(camera)).cloned().collect()
    }

    /// Whether a camera's boxes come from another program.
    pub(crate) fn is_detected_elsewhere(&self, camera: &str) -> bool {
        self.subscriptions.iter().any(|one| one.kind == InputKind::Detections && *one.camera == *camera)
    }
}

/// A value of a key, above 0 and at most so much.
fn positive(key: &str, value: f64, most: f64) -> Result<f64, String> {
    let is_allowed = value > 0.0 && value <= most;
    is_allowed
        .then_some(value)
        .ok_or_else(|| format!("ros.{key} is {value}; allowed is above 0, at most {most}"))
}

/// A subscribed topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Subscription {
    pub(crate) topic: TopicName,
    pub(crate) kind: InputKind,
    /// The camera; empty for other topics.
    pub(crate) camera: Arc<str>,
}

impl Settings {
    /// Checks the settings of a file.
    ///
    /// # Errors
    /// If a value is invalid: with its key and the allowed values.
    pub fn check(&self, file: &Path) -> Result<Checked, RuntimeError> {
        self.checked(file).map_err(|reason| RuntimeError::Settings { file: file.to_owned(), reason })
    }

    fn checked(&self, file: &Path) -> Result<Checked, String> {
        let Self { domain, zenoh, .. } = self;
        if *domain > MAX_DOMAIN {
            return Err(format!("ros.domain is {domain}; allowed is 0 to {MAX_DOMAIN}"));
        }
        for (key, frame) in [
            ("map_frame", &self.map_frame),
            ("odometry_frame", &self.odometry_frame),
            ("robot_frame", &self.robot_frame),
        ] {
            if frame.is_empty() {
                return Err(format!("ros.{key} is empty; allowed is the name of a frame, such as map"));
            }
        }
        if zenoh.mode == Mode::Client && !(zenoh.listen.is_empty() && zenoh.connect.len() == 1) {
            let allowed = "a client calls one endpoint in ros.zenoh.connect and listens on none";
            return Err(format!("ros.zenoh: {allowed}; others are of mode = \"peer\""));
        }
        self.emergency_stop.as_ref().map_or(Ok(()), EmergencyStop::check)?;
        self.battery.as_ref().map_or(Ok(()), Battery::check)?;
        let names = Names {
            namespace: self.namespace.parse().map_err(|error| format!("ros.namespace: {error}"))?,
            node: self.node.parse().map_err(|error| format!("ros.node: {error}"))?,
        };
        let (subscriptions, publications) = (self.subscriptions(&names)?, self.publications(&names)?);
        let mut topics = BTreeSet::new();
        for topic in subscriptions.iter().map(|subscription| &subscription.topic).chain(publications.values())
        {
            if !topics.insert(topic) {
                return Err(format!("ros: topic {topic} is named twice; allowed is one use of each"));
            }
        }
        let folder = file.parent().unwrap_or(Path::new(""));
        let config = zenoh.config.as_ref().map(|config| folder.join(config));
        Ok(Checked {
            transport: self.transport,
            domain: *domain,
            localization: self.localization,
            uncorrected: self.uncorrected()?,
            unstated: self.unstated()?,
            stamps: self.stamps,
            map_frame: self.map_frame.clone(),
            odometry_frame: self.odometry_frame.clone(),
            robot_frame: self.robot_frame.clone(),
            emergency_stop: self.emergency_stop.clone(),
            battery: self.battery.clone(),
            network: Network { config, ..zenoh.clone() },
            subscriptions,
            publications,
            namespace: names.namespace,
            node: names.node,
        })
    }

    /// What the network says of each camera.
    #[must_use]
    pub fn measured(&self) -> BTreeMap<String, Measured> {
        let measured = self.cameras.iter().map(|camera| (camera.name.clone(), camera.measured()));
        measured.filter_map(|(name, measured)| Some((name, measured?))).collect()
    }

    /// The topics of transforms, if they are used.
    fn transforms(&self) -> Result<Vec<(&'static str, InputKind, &str)>, String> {
        let has_camera = self.cameras.iter().any(|camera| camera.mounting() == Mounting::Tf);
        if self.localization != Localization::Tf && !has_camera {
            return Ok(Vec::new());
        }
        let Subscribe { tf, tf_static, .. } = &self.subscribe;
        if tf.is_empty() {
            let users = "localization = \"tf\", and cameras whose mounting is that of tf";
            return Err(format!("ros.subscribe.tf is empty; needed is its topic, for {users}"));
        }
        Ok(vec![
            ("subscribe.tf", InputKind::Transforms, tf),
            ("subscribe.tf_static", InputKind::StaticTransforms, tf_static),
        ])
    }

    fn uncorrected(&self) -> Result<Uncorrected, String> {
        let seconds = positive("localization_timeout_seconds", self.localization_timeout_seconds, 3600.0)?;
        let degrees = positive("max_uncorrected_degrees", self.max_uncorrected_degrees, 180.0)?;
        Ok(Uncorrected {
            timeout_ns: u64::try_from(Duration::from_secs_f64(seconds).as_nanos()).unwrap_or(u64::MAX),
            meters: positive("max_uncorrected_meters", self.max_uncorrected_meters, 1e6)?,
            radians: degrees.to_radians(),
        })
    }

    fn unstated(&self) -> Result<PoseStd, String> {
        let usual = if self.localization == Localization::Fix { 2.0 } else { 0.1 };
        let meters = self.position_std_meters.unwrap_or(usual);
        let degrees = positive("heading_std_degrees", self.heading_std_degrees, 90.0)?;
        Ok(PoseStd {
            meters: positive("position_std_meters", meters, 1000.0)?,
            radians: degrees.to_radians(),
        })
    }

    fn subscriptions(&self, names: &Names) -> Result<Vec<Subscription>, String> {
        let Subscribe { odometry, pose, fix, map, goals, .. } = &self.subscribe;
        let mut own: Vec<(&str, InputKind, &str)> = vec![
            ("subscribe.odometry", InputKind::Odometry, odometry),
            ("subscribe.pose", InputKind::Pose, pose),
            ("subscribe.fix", InputKind::Fix, fix),
            ("subscribe.map", InputKind::Map, map),
            ("subscribe.goals", InputKind::Goals, goals),
        ];
        own.extend(self.transforms()?);
        let stop = self.emergency_stop.as_ref();
        own.extend(stop.map(|stop| ("emergency_stop.topic", InputKind::Stop, stop.topic.as_str())));
        let battery = self.battery.as_ref();
        own.extend(battery.map(|battery| ("battery.topic", InputKind::Battery, battery.topic.as_str())));
        let mut received = Vec::new();
        for (key, kind, name) in own {
            received.extend(names.topic(key, name)?.map(|topic| Subscription {
                topic,
                kind,
                camera: "".into(),
            }));
        }
        let mut cameras = BTreeSet::new();
        for camera in &self.cameras {
            let name = &camera.name;
            if name.is_empty() || !cameras.insert(name) || cameras.len() > MAX_CAMERAS {
                let allowed = format!("up to {MAX_CAMERAS} cameras, each with a name of its own");
                return Err(format!("ros.cameras: {name:?}; allowed are {allowed}"));
            }
            let before = received.len();
            for (key, kind, topic) in [
                ("cameras.detections", InputKind::Detections, &camera.detections),
                ("cameras.image", InputKind::Image, &camera.image),
                ("cameras.compressed_image", InputKind::CompressedImage, &camera.compressed_image),
            ] {
                let topic = names.topic(key, topic)?;
                received.extend(topic.map(|topic| Subscription {
                    topic,
                    kind,
                    camera: name.as_str().into(),
                }));
            }
            if received.len() == before {
                let allowed = "detections, image or compressed_image, at least one";
                return Err(format!("ros.cameras: {name:?} has no topic; allowed are {allowed}"));
            }
            let info = names.topic("cameras.camera_info", &camera.camera_info)?;
            received.extend(info.map(|topic| Subscription {
                topic,
                kind: InputKind::CameraInfo,
                camera: name.as_str().into(),
            }));
        }
        Ok(received)
    }

    fn publications(&self, names: &Names) -> Result<BTreeMap<OutputKind, TopicName>, String> {
        let Publish { goal, path, belief, objects, tracks, diagnostics } = &self.publish;
        let mut published = BTreeMap::new();
        for (key, kind, name) in [
            ("publish.goal", OutputKind::Goal, goal),
            ("publish.path", OutputKind::Path, path),
            ("publish.belief", OutputKind::Belief, belief),
            ("publish.objects", OutputKind::Objects, objects),
            ("publish.tracks", OutputKind::Tracks, tracks),
            ("publish.diagnostics", OutputKind::Diagnostics, diagnostics),
        ] {
            published.extend(names.topic(key, name)?.map(|topic| (kind, topic)));
        }
        Ok(published)
    }
}

/// The namespace and node by which names are resolved.
struct Names {
    namespace: Namespace,
    node: NodeName,
}

impl Names {
    /// The topic of a key, unless it is left empty.
    fn topic(&self, key: &str, name: &str) -> Result<Option<TopicName>, String> {
        if name.is_empty() {
            return Ok(None);
        }
        let topic = TopicName::resolve(name, &self.namespace, &self.node);
        topic.map(Some).map_err(|error| format!("ros.{key}: {error}"))
    }
}

#[cfg(test)]
mod tests;
