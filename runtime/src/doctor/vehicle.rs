//! Checks of the robot's own ROS 2 network: connections, the topics that its settings use, stamps, and the map.

use std::collections::BTreeMap;
use std::time::Duration;

use dragnet_lattice::plane::Pose;
use dragnet_ros2::input::{InputKind, Occupancy};
use dragnet_ros2::name::TopicName;
use dragnet_ros2::output::OutputKind;
use dragnet_scenario::Scenario;
use dragnet_vehicle::evidence::standing_cell;
use tokio::time::Instant;

use super::Finding;
use super::frames::HeardFrames;
use crate::config::Body;
use crate::ros::incoming::Incoming;
use crate::ros::node::Node;
use crate::ros::settings::{Localization, Stamps};
use crate::unix_time;
use crate::vehicle::ground::Likeness;
use crate::vehicle::place::posed;

/// Clock skew above which stamps are those of another clock, seconds.
const MOST_SKEW_SECONDS: f64 = 1.0;

/// The importance of a topic to the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Use {
    /// Without it the robot does not search.
    Needed,
    /// It is used; the text describes the restriction without it.
    Welcome(&'static str),
    /// These settings do not use it.
    None,
}

/// The messages received on one topic.
struct Traffic {
    is: Use,
    /// Whether late subscribers receive old messages, with old stamps.
    is_latched: bool,
    messages: u32,
    /// The largest difference between this computer's clock and a stamp, seconds.
    behind_seconds: f64,
    refused: Option<String>,
}

/// The last messages of these kinds.
#[derive(Default)]
struct Last {
    map: Option<Occupancy>,
    /// The vehicle's pose, in the network's frame.
    pose: Option<Pose>,
}

/// Checks the cameras: the settings must name a topic for each, since the pilot waits for it.
pub(super) fn cameras(body: &Body) -> Vec<Finding> {
    let absent = body
        .pilot
        .cameras()
        .filter(|camera| body.ros.subscriptions.iter().all(|one| *one.camera != **camera));
    let advice = "name its detections or its images under ros.cameras, or leave it out of vehicle.cameras";
    let fail = |camera: &str| {
        let found = "ros.cameras has no topic for it: its frames are missing";
        Finding::fail(format!("camera {camera}"), found, advice)
    };
    absent.map(fail).collect()
}

pub(super) async fn examine(
    body: Body,
    scenario: &Scenario,
    listen: Duration,
    tell: &mut dyn FnMut(Finding),
) {
    let Body { ros, moved_by, pilot, .. } = body;
    let mut frames = HeardFrames::new(&ros, pilot.measured_cameras());
    let (stamps, localization) = (ros.stamps(), ros.localization());
    let mut traffic: BTreeMap<TopicName, Traffic> = ros
        .subscriptions
        .iter()
        .map(|one| (one.topic.clone(), Traffic::none(one.kind, localization, moved_by)))
        .collect();
    let Ok(opened) = tokio::time::timeout(listen.max(Duration::from_secs(3)), Node::open(ros)).await else {
        let advice = "start rmw_zenohd or zenoh-bridge-ros2dds, and see that ros.zenoh.connect names it";
        return tell(Finding::fail("vehicle", "no router and no bridge answers", advice));
    };
    let node = match opened {
        Ok(node) => node,
        Err(error) => return tell(Finding::fail("vehicle", error.to_string(), "")),
    };
    let mut last = Last::default();
    let end = Instant::now() + listen;
    while let Ok((topic, received)) = tokio::time::timeout_at(end, node.receive_on()).await {
        if let Some(traffic) = traffic.get_mut(&topic) {
            traffic.take(&received);
        }
        frames.take(&received);
        last.take(received, localization);
    }
    let neighbors = node.neighbors().await;
    if neighbors == 0 {
        let advice = "the connection was lost: see that the router or bridge runs on";
        tell(Finding::fail("vehicle", "no router, bridge or peer is connected", advice));
    }
    for (topic, traffic) in traffic.iter().filter(|(_, traffic)| traffic.is != Use::None) {
        tell(traffic.finding(topic, listen, stamps));
    }
    frames.findings(listen).into_iter().for_each(&mut *tell);
    last.findings(scenario).into_iter().for_each(&mut *tell);
    tell(listened_to(&node, moved_by).await);
}

async fn listened_to(node: &Node, kind: OutputKind) -> Finding {
    let subject = format!("{kind:?}").to_lowercase();
    match node.has_subscriber(kind).await {
        Ok(true) => Finding::pass(subject, "it has a subscriber"),
        Ok(false) => Finding::fail(
            subject,
            "it has no subscriber, so that the vehicle will not move",
            "start Nav2 or the path follower, and see that its topic is the one under ros.publish",
        ),
        Err(error) => Finding::fail(subject, error.to_string(), ""),
    }
}

impl Use {
    const fn of(kind: InputKind, localization: Localization, moved_by: OutputKind) -> Self {
        match (kind, localization, moved_by) {
            (InputKind::Odometry, Localization::Tf, _) => Self::None,
            (
                InputKind::Odometry
                | InputKind::Detections
                | InputKind::Image
                | InputKind::CompressedImage
                | InputKind::Transforms
                | InputKind::CameraInfo
                | InputKind::Stop,
                ..,
            )
            | (InputKind::Pose, Localization::Pose, _)
            | (InputKind::Fix, Localization::Fix, _) => Self::Needed,
            (InputKind::Map, _, OutputKind::Path) => {
                Self::Welcome("paths are planned on the scenario's map until one comes")
            }
            (InputKind::Map, ..) => Self::Welcome("it cannot be held against the scenario's map"),
            (InputKind::StaticTransforms, ..) => Self::Welcome("no frame is fixed to another"),
            (InputKind::Battery, ..) => Self::Welcome("the charge of the battery is unknown"),
            (InputKind::Goals, _, OutputKind::Goal) => Self::Welcome("no goal was given yet"),
            (InputKind::Pose | InputKind::Fix | InputKind::Goals, ..) => Self::None,
        }
    }
}

impl Traffic {
    fn none(kind: InputKind, localization: Localization, moved_by: OutputKind) -> Self {
        let is_latched = kind == InputKind::Pose;
        let is = Use::of(kind, localization, moved_by);
        Self { is, is_latched, messages: 0, behind_seconds: 0.0, refused: None }
    }

    fn take(&mut self, received: &Incoming) {
        let stamp_unix_ns = match received {
            Incoming::Rejected { reason, .. } => {
                self.refused = Some(reason.clone());
                return;
            }
            Incoming::Odometry(odometry) => Some(odometry.place.stamp_unix_ns),
            Incoming::Pose(pose) => Some(pose.stamp_unix_ns),
            Incoming::Fix(fix) => Some(fix.stamp_unix_ns),
            Incoming::Detections { detections, .. } => Some(detections.stamp_unix_ns),
            Incoming::Image { image, .. } => Some(image.stamp_unix_ns),
            // Localization dates its transforms ahead, and the age of the pose is checked by itself.
            Incoming::Transforms(_)
            | Incoming::StaticTransforms(_)
            | Incoming::CameraInfo { .. }
            | Incoming::Stop(_)
            | Incoming::Battery(_)
            | Incoming::Map(_)
            | Incoming::Goals(_) => None,
        };
        self.messages += 1;
        if let Some(stamp) = stamp_unix_ns.filter(|_| self.messages > u32::from(self.is_latched)) {
            let behind = unix_time::now_ns().saturating_sub(stamp) as f64 / 1e9;
            if behind.abs() > self.behind_seconds.abs() {
                self.behind_seconds = behind;
            }
        }
    }

    fn finding(&self, topic: &TopicName, listen: Duration, stamps: Stamps) -> Finding {
        let (subject, seconds) = (topic.to_string(), listen.as_secs_f64());
        let found = format!("{} messages in {seconds:.0} s", self.messages);
        if let Some(reason) = &self.refused {
            let advice =
                "name a topic of the right type under ros.subscribe or ros.cameras, or correct its publisher";
            return Finding::fail(subject, format!("{found}, and others were rejected: {reason}"), advice);
        }
        match self.is {
            Use::Welcome(without) if self.messages == 0 => {
                return Finding::pass(subject, format!("{found}: {without}"));
            }
            _ if self.messages == 0 && self.is_latched => {
                let advice = "start the localization, and set the initial pose (RViz: 2D Pose Estimate)";
                return Finding::fail(subject, found, advice);
            }
            _ if self.messages == 0 => {
                let advice = "start its publisher; or set its name under ros.subscribe or ros.cameras to \"\" to do without";
                return Finding::fail(subject, found, advice);
            }
            _ => {}
        }
        if stamps == Stamps::Clock && self.behind_seconds.abs() > MOST_SKEW_SECONDS {
            let found = format!("{found}, stamped {:.1} s before this computer's clock", self.behind_seconds);
            return Finding::fail(subject, found, "set the clocks (chrony), or ros.stamps = \"arrival\"");
        }
        Finding::pass(subject, found)
    }
}

impl Last {
    fn take(&mut self, received: Incoming, localization: Localization) {
        match (received, localization) {
            (Incoming::Map(map), _) => self.map = Some(map),
            (Incoming::Pose(pose), Localization::Pose) => self.pose = Some(posed(pose.pose)),
            (Incoming::Odometry(odometry), Localization::Odometry) => {
                self.pose = Some(posed(odometry.place.pose));
            }
            _ => {}
        }
    }

    /// Compares map and pose with those of the search.
    fn findings(&self, scenario: &Scenario) -> Vec<Finding> {
        let (origin, terrain) = (scenario.origin(), scenario.terrain());
        let search = Pose::new(origin.x_meters, origin.y_meters, origin.yaw_radians);
        let advice = "give the scenario the map that the vehicle drives on, with its origin, or the vehicle that of the scenario";
        let map = self.map.as_ref().map(|map| match Likeness::of(&search, map, terrain) {
            Err(reason) => Finding::fail("map", reason, advice),
            Ok(likeness) => {
                let Likeness { free, outside, occupied } = likeness;
                let found = format!(
                    "of {free} cells that are free in the scenario {outside} lie outside of the vehicle's map, and \
                     {occupied} are occupied there"
                );
                if likeness.will_do() { Finding::pass("map", found) } else { Finding::fail("map", found, advice) }
            }
        });
        let place = self.pose.map(|pose| match standing_cell(terrain, &pose.seen_from(&search)) {
            Err(error) => Finding::fail(
                "place",
                error.to_string(),
                "drive it to where it is to search; and see the map's origin",
            ),
            Ok(cell) => {
                let position = terrain.grid().position(cell);
                Finding::pass("place", format!("it stands in cell [{}, {}]", position.row, position.column))
            }
        });
        map.into_iter().chain(place).collect()
    }
}
