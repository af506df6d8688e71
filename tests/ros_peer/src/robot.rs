//! The robot's published and received messages.

use hiroz::msg::ZMessage;
use hiroz::node::ZNode;
use hiroz::pubsub::{ZPub, ZSub};
use hiroz::qos::{QosDurability, QosHistory, QosProfile, QosReliability};
use hiroz::{Builder, MessageTypeInfo, Result};
use hiroz_msgs::action_msgs::{GoalStatus, GoalStatusArray};
use hiroz_msgs::diagnostic_msgs::DiagnosticArray;
use hiroz_msgs::geometry_msgs::{PoseStamped, PoseWithCovarianceStamped};
use hiroz_msgs::nav_msgs::{OccupancyGrid, Odometry, Path};
use hiroz_msgs::sensor_msgs::{CompressedImage, Image, NavSatFix};
use hiroz_msgs::std_msgs::{Header, String as Text};
use serde_json::{Value, json};

use crate::vision::{Detection2D, Detection2DArray, Detection3DArray, ObjectHypothesisWithPose};

fn sensor() -> QosProfile {
    QosProfile {
        reliability: QosReliability::BestEffort,
        history: QosHistory::from_depth(5),
        ..QosProfile::default()
    }
}

fn latched() -> QosProfile {
    QosProfile {
        durability: QosDurability::TransientLocal,
        history: QosHistory::from_depth(1),
        ..QosProfile::default()
    }
}

/// Type hashes as computed by hiroz.
pub fn hashes() -> Value {
    fn entry<T: MessageTypeInfo>() -> (String, Value) {
        let name = T::type_name().replace("::dds_::", "::").replace("::", "/");
        (name.trim_end_matches('_').to_owned(), T::type_hash().to_string().into())
    }
    let hashes: serde_json::Map<String, Value> = [
        entry::<Odometry>(),
        entry::<PoseWithCovarianceStamped>(),
        entry::<NavSatFix>(),
        entry::<OccupancyGrid>(),
        entry::<Image>(),
        entry::<CompressedImage>(),
        entry::<GoalStatusArray>(),
        entry::<PoseStamped>(),
        entry::<Path>(),
        entry::<DiagnosticArray>(),
        entry::<Detection2DArray>(),
        entry::<Detection3DArray>(),
    ]
    .into_iter()
    .collect();
    json!({ "hashes": hashes })
}

/// A subscriber of each topic that Dragnet publishes. It lives as long as it is held.
pub fn listen(node: &ZNode) -> Result<Vec<Box<dyn std::any::Any>>> {
    Ok(vec![
        Box::new(receive::<PoseStamped>(node, "goal_pose", QosProfile::default(), |goal| {
            let place = &goal.pose.position;
            json!({"topic": "goal", "x": place.x, "y": place.y, "z": goal.pose.orientation.z, "frame": goal.header.frame_id})
        })?),
        Box::new(receive::<Path>(node, "dragnet/path", QosProfile::default(), |path| {
            let places = path.poses.iter().map(|pose| json!([pose.pose.position.x, pose.pose.position.y]));
            json!({"topic": "path", "places": places.collect::<Value>()})
        })?),
        Box::new(receive::<OccupancyGrid>(
            node,
            "dragnet/belief",
            latched(),
            |belief| json!({"topic": "belief", "width": belief.info.width, "data": belief.data, "sec": belief.header.stamp.sec}),
        )?),
        Box::new(receive::<Detection3DArray>(node, "dragnet/objects", latched(), |objects| {
            let objects = objects.detections.iter().map(|object| {
                let result = &object.results[0].hypothesis;
                let place = &object.results[0].pose;
                json!([
                    object.bbox.center.position.x,
                    object.bbox.size.y,
                    result.class_id,
                    result.score,
                    object.id,
                    place.pose.position.x,
                    place.covariance[7]
                ])
            });
            json!({"topic": "objects", "objects": objects.collect::<Value>()})
        })?),
        Box::new(receive::<DiagnosticArray>(node, "/diagnostics", QosProfile::default(), |array| {
            let status = &array.status[0];
            json!({"topic": "diagnostics", "level": status.level, "name": status.name, "value": status.values[0].value})
        })?),
    ])
}

fn receive<T>(
    node: &ZNode,
    topic: &str,
    qos: QosProfile,
    tell: fn(&T) -> Value,
) -> Result<impl std::any::Any + use<T>>
where
    T: ZMessage + MessageTypeInfo + hiroz::WithTypeInfo + Send + Sync + 'static,
    T::Serdes: for<'a> hiroz::msg::ZDeserializer<Input<'a> = &'a [u8], Output = T> + 'static,
{
    let subscriber: ZSub<T, (), T::Serdes> = node
        .create_sub::<T>(topic)
        .with_qos(qos)
        .build_with_callback(move |received: T| println!("{}", tell(&received)))?;
    Ok(subscriber)
}

type Voice<T> = ZPub<T, <T as ZMessage>::Serdes>;

/// A publisher of each topic that Dragnet subscribes to.
pub struct Voices {
    odometry: Voice<Odometry>,
    pose: Voice<PoseWithCovarianceStamped>,
    fix: Voice<NavSatFix>,
    goals: Voice<GoalStatusArray>,
    detections: Voice<Detection2DArray>,
    image: Voice<Image>,
    /// Published once: late subscribers receive it all the same.
    _map: Voice<OccupancyGrid>,
    /// On a topic where images are expected.
    _wrong: Voice<Text>,
}

impl Voices {
    pub fn new(node: &ZNode) -> Result<Self> {
        let map = node.create_pub::<OccupancyGrid>("map").with_qos(latched()).build()?;
        map.publish(&the_map())?;
        Ok(Self {
            odometry: node.create_pub::<Odometry>("odom").build()?,
            pose: node.create_pub::<PoseWithCovarianceStamped>("amcl_pose").with_qos(latched()).build()?,
            fix: node.create_pub::<NavSatFix>("fix").with_qos(sensor()).build()?,
            goals: node
                .create_pub::<GoalStatusArray>("navigate_to_pose/_action/status")
                .with_qos(latched())
                .build()?,
            detections: node.create_pub::<Detection2DArray>("front/detections").with_qos(sensor()).build()?,
            image: node.create_pub::<Image>("front/image_raw").with_qos(sensor()).build()?,
            _map: map,
            _wrong: node.create_pub::<Text>("rear/image_raw").build()?,
        })
    }

    pub fn say(&self) -> Result<()> {
        let mut odometry =
            Odometry { header: header("odom"), child_frame_id: "base_link".into(), ..Odometry::default() };
        odometry.pose.pose.position.x = 1.25;
        odometry.pose.pose.orientation.w = 1.0;
        odometry.pose.covariance[35] = 0.5;
        odometry.twist.twist.linear.x = 0.75;
        self.odometry.publish(&odometry)?;

        let mut pose =
            PoseWithCovarianceStamped { header: header("map"), ..PoseWithCovarianceStamped::default() };
        pose.pose.pose.position.y = -3.5;
        pose.pose.pose.orientation.w = 0.0;
        pose.pose.pose.orientation.z = 1.0;
        self.pose.publish(&pose)?;

        let mut fix =
            NavSatFix { header: header("gps"), latitude: 49.25, longitude: -2.125, ..NavSatFix::default() };
        fix.altitude = 12.5;
        self.fix.publish(&fix)?;

        let mut goals = GoalStatusArray::default();
        goals.status_list.push(GoalStatus { status: GoalStatus::STATUS_SUCCEEDED, ..GoalStatus::default() });
        goals.status_list[0].goal_info.goal_id.uuid = [7; 16];
        self.goals.publish(&goals)?;

        let mut seen = Detection2D { id: "a".into(), ..Detection2D::default() };
        (seen.bbox.center.position.x, seen.bbox.center.position.y) = (320.0, 240.0);
        (seen.bbox.size_x, seen.bbox.size_y) = (40.0, 80.0);
        let mut result = ObjectHypothesisWithPose::default();
        (result.hypothesis.class_id, result.hypothesis.score) = ("person".into(), 0.875);
        seen.results.push(result);
        self.detections.publish(&Detection2DArray { header: header("front"), detections: vec![seen] })?;

        let data = vec![10, 20, 30, 40, 50, 60];
        let image = Image {
            header: header("front"),
            height: 1,
            width: 2,
            encoding: "bgr8".into(),
            step: 6,
            data: data.into(),
            ..Image::default()
        };
        self.image.publish(&image)
    }
}

fn header(frame: &str) -> Header {
    let mut header = Header { frame_id: frame.into(), ..Header::default() };
    (header.stamp.sec, header.stamp.nanosec) = (12, 34);
    header
}

fn the_map() -> OccupancyGrid {
    let mut map =
        OccupancyGrid { header: header("map"), data: vec![0, 100, -1, 0, 0, 50], ..OccupancyGrid::default() };
    (map.info.width, map.info.height, map.info.resolution) = (3, 2, 0.5);
    map.info.origin.orientation.w = 1.0;
    map
}
