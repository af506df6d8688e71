//! The robot's own ROS 2 network: is anybody there, which topics are alive, and do its stamps make sense?

use std::collections::BTreeMap;
use std::time::Duration;

use dragnet_proto::ros::name::TopicName;
use dragnet_proto::ros::output::OutputKind;
use tokio::time::Instant;

use super::Finding;
use crate::config::Body;
use crate::ros::heard::Heard;
use crate::ros::node::Node;
use crate::ros::settings::Stamps;
use crate::unix_time;

/// Stamps that are farther from this computer's clock are of another clock, seconds.
const MOST_SKEW_SECONDS: f64 = 1.0;

/// What came on one topic.
#[derive(Default)]
struct Traffic {
    messages: u32,
    /// By how much the stamp that was farthest off was behind this computer's clock, seconds.
    behind_seconds: f64,
    refused: Option<String>,
}

pub(super) async fn examine(body: Body, listen: Duration, tell: &mut dyn FnMut(Finding)) {
    let stamps = body.ros.stamps();
    let Ok(opened) = tokio::time::timeout(listen.max(Duration::from_secs(3)), Node::open(body.ros)).await
    else {
        let advice = "start rmw_zenohd or zenoh-bridge-ros2dds, and see that ros.zenoh.connect names it";
        return tell(Finding::fail("vehicle", "no router and no bridge answers", advice));
    };
    let node = match opened {
        Ok(node) => node,
        Err(error) => return tell(Finding::fail("vehicle", error.to_string(), "")),
    };
    let mut traffic: BTreeMap<TopicName, Traffic> =
        node.topics().map(|topic| (topic.clone(), Traffic::default())).collect();
    let end = Instant::now() + listen;
    while let Ok((topic, heard)) = tokio::time::timeout_at(end, node.hear_on()).await {
        traffic.entry(topic).or_default().take(&heard);
    }
    let neighbors = node.neighbors().await;
    if neighbors == 0 {
        let advice = "the connection was lost: see that the router or bridge runs on";
        tell(Finding::fail("vehicle", "nobody is connected", advice));
    }
    for (topic, traffic) in &traffic {
        tell(traffic.finding(topic, listen, stamps));
    }
    tell(listened_to(&node, body.moved_by).await);
}

async fn listened_to(node: &Node, kind: OutputKind) -> Finding {
    let subject = format!("{kind:?}").to_lowercase();
    match node.is_heard(kind).await {
        Ok(true) => Finding::pass(subject, "somebody listens to it"),
        Ok(false) => Finding::fail(
            subject,
            "nobody listens to it, so that the vehicle will not move",
            "start Nav2 or the path follower, and see that its topic is the one under ros.say",
        ),
        Err(error) => Finding::fail(subject, error.to_string(), ""),
    }
}

impl Traffic {
    fn take(&mut self, heard: &Heard) {
        let stamp_unix_ns = match heard {
            Heard::Refused { reason, .. } => {
                self.refused = Some(reason.clone());
                return;
            }
            Heard::Odometry(odometry) => Some(odometry.place.stamp_unix_ns),
            Heard::Pose(pose) => Some(pose.stamp_unix_ns),
            Heard::Fix(fix) => Some(fix.stamp_unix_ns),
            Heard::Detections { detections, .. } => Some(detections.stamp_unix_ns),
            Heard::Map(_) | Heard::Image { .. } | Heard::Goals(_) => None,
        };
        self.messages += 1;
        if let Some(stamp) = stamp_unix_ns {
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
                "name a topic of the right type under ros.hear or ros.cameras, or mend who publishes it";
            return Finding::fail(subject, format!("{found}, and others were refused: {reason}"), advice);
        }
        if self.messages == 0 {
            let advice =
                "start who publishes it; or set its name under ros.hear or ros.cameras to \"\" to do without";
            return Finding::fail(subject, found, advice);
        }
        if stamps == Stamps::Clock && self.behind_seconds.abs() > MOST_SKEW_SECONDS {
            let found = format!("{found}, stamped {:.1} s before this computer's clock", self.behind_seconds);
            return Finding::fail(subject, found, "set the clocks (chrony), or ros.stamps = \"arrival\"");
        }
        Finding::pass(subject, found)
    }
}
