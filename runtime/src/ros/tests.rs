//! A node among plain Zenoh sessions, with the keys, tokens and bytes of ROS 2. A router connects them as `rmw_zenohd`
//! does.

use std::future::Future;
use std::path::Path;
use std::time::Duration;

use dragnet_ros2::cdr;
use dragnet_ros2::input::{GoalState, PlanarPose};
use dragnet_ros2::navigation_goal::{NavigationGoal, Progress};
use dragnet_ros2::output::{Diagnostic, Level, Output, OutputKind};
use dragnet_ros2::wire::robot::{
    GoalInfo, GoalStatus, GoalStatusArray, Odometry, PoseWithCovarianceStamped, Uuid,
};
use dragnet_ros2::wire::standard::{Header, MapMetaData, OccupancyGrid, PoseStamped, Time};
use dragnet_ros2::wire::vision::{Detection2D, Detection2DArray};
use tokio::sync::mpsc;
use zenoh::Session;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh::sample::Sample;
use zenoh_ext::{AdvancedPublisherBuilderExt, AdvancedSubscriberBuilderExt, CacheConfig, HistoryConfig};

use super::incoming::Incoming;
use super::node::Node;
use super::settings::{Checked, Settings};
use crate::mentions::assert_mentions;
use crate::session::{Endpoints, Mode, free_endpoints, open};

const ODOMETRY: &str =
    "nav_msgs::msg::dds_::Odometry_/RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0";
const GRID: &str = "nav_msgs::msg::dds_::OccupancyGrid_/RIHS01_8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7";
const GOAL: &str = "geometry_msgs::msg::dds_::PoseStamped_/RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8";

/// A router, and a robot's own session on it.
struct Network {
    _router: Session,
    robot: Session,
    endpoint: String,
}

impl Network {
    async fn start() -> Self {
        let endpoint = free_endpoints(1).unwrap().remove(0);
        let listen = vec![endpoint.clone()];
        let router = Endpoints { listen: listen.clone(), mode: Some(Mode::Router), ..Endpoints::default() };
        let robot = Endpoints { connect: listen, mode: Some(Mode::Router), ..Endpoints::default() };
        Self { _router: open(&router).await.unwrap(), robot: open(&robot).await.unwrap(), endpoint }
    }

    fn settings(&self, text: &str) -> Checked {
        let text = format!("zenoh.connect = [{:?}]\n{text}", self.endpoint);
        let settings: Settings = toml::from_str(&text).unwrap();
        settings.check(Path::new("robot.toml")).unwrap()
    }

    /// A publisher with a subscriber.
    async fn publisher(&self, key: String) -> Publisher<'static> {
        // No message is dropped, as happens by default if the network is slow.
        let publisher = self.robot.declare_publisher(key).congestion_control(CongestionControl::Block);
        let publisher = publisher.await.unwrap();
        until(async || publisher.matching_status().await.unwrap().matching()).await;
        publisher
    }

    async fn subscribe(&self, key: &str) -> mpsc::UnboundedReceiver<Sample> {
        let (sender, receiver) = mpsc::unbounded_channel();
        let callback = move |sample| drop(sender.send(sample));
        self.robot.declare_subscriber(key.to_owned()).callback(callback).background().await.unwrap();
        receiver
    }
}

/// A generous time limit for a busy computer.
async fn in_time<T>(what: impl Future<Output = T>) -> T {
    tokio::time::timeout(Duration::from_mins(1), what).await.unwrap()
}

async fn until(mut is_so: impl AsyncFnMut() -> bool) {
    in_time(async {
        while !is_so().await {
            tokio::task::yield_now().await;
        }
    })
    .await;
}

fn odometry(x: f64, frame: &str) -> Vec<u8> {
    let header = Header { stamp: Time { sec: 5, nanosec: 6 }, frame_id: frame.into() };
    let mut odometry = Odometry { header, ..Odometry::default() };
    odometry.pose.pose.position.x = x;
    cdr::encode(&odometry)
}

fn grid() -> OccupancyGrid {
    let info = MapMetaData { resolution: 0.5, width: 3, height: 1, ..MapMetaData::default() };
    let header = Header { frame_id: "map".into(), ..Header::default() };
    OccupancyGrid { header, info, data: vec![0, 100, -1] }
}

async fn received_x(node: &Node) -> f64 {
    match in_time(node.receive()).await {
        Incoming::Odometry(received) => received.place.pose.x_meters,
        other => panic!("{other:?}"),
    }
}

async fn refusal(node: &Node, topic: &str) -> String {
    match in_time(node.receive()).await {
        Incoming::Rejected { topic: found, reason } => {
            assert_eq!(found.to_string(), topic);
            reason
        }
        other => panic!("{other:?}"),
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn odometry_of_rmw_zenoh_is_received_in_its_domain_and_namespace() {
    let network = Network::start().await;
    let node =
        Node::open(network.settings("transport = 'rmw_zenoh'\ndomain = 7\nnamespace = 'bot'")).await.unwrap();
    let publisher = network.publisher(format!("7/bot/odom/{ODOMETRY}")).await;
    publisher.put(odometry(1.5, "odom")).await.unwrap();
    assert!((received_x(&node).await - 1.5).abs() < 1e-12);
    assert_eq!(node.neighbors().await, 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn an_invalid_message_is_rejected_and_the_next_one_received() {
    let network = Network::start().await;
    let node = Node::open(network.settings("transport = 'bridge'")).await.unwrap();
    let publisher = network.publisher("odom".to_owned()).await;
    publisher.put(cdr::encode(&grid())).await.unwrap();
    assert_mentions(&refusal(&node, "/odom").await, "nav_msgs/msg/Odometry");
    publisher.put(odometry(f64::NAN, "odom")).await.unwrap();
    assert_mentions(&refusal(&node, "/odom").await, "pose.pose.position.x .. NaN");
    publisher.put(odometry(1.0, "map")).await.unwrap();
    assert_mentions(&refusal(&node, "/odom").await, "frame_id .. \"map\" .. \"odom\"");
    publisher.put(vec![0; 8193]).await.unwrap();
    assert_mentions(&refusal(&node, "/odom").await, "8193 bytes .. 8192");
    publisher.put(odometry(2.0, "/odom")).await.unwrap();
    assert!((received_x(&node).await - 2.0).abs() < 1e-12);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_publisher_of_another_type_is_reported_with_its_node() {
    let network = Network::start().await;
    let liveliness = network.robot.liveliness();
    let before = format!("@ros2_lv/0/ab/0/1/MP/%/%/driver/%odom/{GRID}/::,10:,:,:,,");
    let _before = liveliness.declare_token(before).await.unwrap();
    let node = Node::open(network.settings("transport = 'rmw_zenoh'")).await.unwrap();
    let reason = refusal(&node, "/odom").await;
    assert_mentions(&reason, "/driver .. nav_msgs/msg/OccupancyGrid .. nav_msgs/msg/Odometry");
    let after = "@ros2_lv/0/ab/0/2/MP/%/%bot/other/%odom/nav_msgs::msg::dds_::Odometry_/TypeHashNotSupported/::,10:,:,:,,";
    let _after = liveliness.declare_token(after).await.unwrap();
    assert_mentions(&refusal(&node, "/odom").await, "/bot/other .. another definition .. nav_msgs");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_map_that_was_published_before_is_received() {
    let network = Network::start().await;
    for (transport, key) in [("rmw_zenoh", format!("0/map/{GRID}")), ("bridge", "map".to_owned())] {
        let publisher = network.robot.declare_publisher(key).advanced().publisher_detection();
        let publisher = publisher
            .cache(CacheConfig::default().max_samples(1))
            .sample_miss_detection(zenoh_ext::MissDetectionConfig::default())
            .await
            .unwrap();
        publisher.put(cdr::encode(&grid())).await.unwrap();
        let node = Node::open(network.settings(&format!("transport = '{transport}'"))).await.unwrap();
        let Incoming::Map(received) = in_time(node.receive()).await else { panic!("{transport}") };
        assert_eq!((received.cells, received.grid.columns()), (vec![0, 100, -1], 3));
    }
}

/// AMCL's pose is latched, and published only when the vehicle moves; that of another localization may not be latched.
#[tokio::test(flavor = "multi_thread")]
async fn latched_and_volatile_poses_are_received() {
    let network = Network::start().await;
    let pose = |x: f64| {
        let mut pose = PoseWithCovarianceStamped { header: grid().header, ..Default::default() };
        (pose.pose.pose.position.x, pose.pose.pose.orientation.w) = (x, 1.0);
        cdr::encode(&pose)
    };
    let received_x = async |node: &Node| match in_time(node.receive()).await {
        Incoming::Pose(received) => received.pose.x_meters,
        other => panic!("{other:?}"),
    };
    let latched = network.robot.declare_publisher("amcl_pose").advanced().publisher_detection();
    let latched = latched.cache(CacheConfig::default().max_samples(1)).await.unwrap();
    latched.put(pose(1.0)).await.unwrap();
    let node = Node::open(network.settings("transport = 'bridge'")).await.unwrap();
    assert!((received_x(&node).await - 1.0).abs() < 1e-12);
    let plain = network.publisher("amcl_pose".to_owned()).await;
    plain.put(pose(2.0)).await.unwrap();
    assert!((received_x(&node).await - 2.0).abs() < 1e-12);
}

#[tokio::test(flavor = "multi_thread")]
async fn goals_are_published_with_the_attachments_of_rmw_zenoh() {
    let network = Network::start().await;
    let mut goals = network.subscribe(&format!("0/goal_pose/{GOAL}")).await;
    let mut node = Node::open(network.settings("transport = 'rmw_zenoh'")).await.unwrap();
    until(async || node.has_subscriber(OutputKind::Goal).await.unwrap()).await;
    assert!(!node.has_subscriber(OutputKind::Path).await.unwrap());
    for number in [1_u8, 2] {
        let goal = PlanarPose { x_meters: f64::from(number), ..PlanarPose::default() };
        node.publish(1_500_000_000, Output::Goal(goal)).await.unwrap();
        let received = in_time(goals.recv()).await.unwrap();
        let decoded: PoseStamped = cdr::decode(&received.payload().to_bytes()).unwrap();
        assert_eq!((decoded.pose.position.x, decoded.header.frame_id.as_str()), (f64::from(number), "map"));
        let attachment = received.attachment().unwrap().to_bytes();
        assert_eq!((attachment.len(), attachment[0], attachment[16]), (33, number, 16));
        assert_eq!(attachment[8..16], 1_500_000_000_i64.to_le_bytes());
    }
    let tokens = network.robot.liveliness().get("@ros2_lv/0/**").await.unwrap();
    let mut found = Vec::new();
    while let Ok(reply) = tokens.recv_async().await {
        let key = reply.result().unwrap().key_expr().to_string();
        found.push(key.split('/').skip(3).collect::<Vec<_>>().join("/"));
    }
    assert_eq!(found.len(), 1 + 5 + 6);
    assert!(found.contains(&"0/0/NN/%/%/dragnet".to_owned()), "{found:?}");
    assert!(found.contains(&format!("0/6/MP/%/%/dragnet/%goal_pose/{GOAL}/::,10:,:,:,,")), "{found:?}");
    assert!(found.contains(&format!("0/1/MS/%/%/dragnet/%odom/{ODOMETRY}/2::,5:,:,:,,")), "{found:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn late_subscribers_receive_the_belief_and_behind_a_bridge_without_attachments() {
    let network = Network::start().await;
    let mut goals = network.subscribe("bot/goal_pose").await;
    let mut node = Node::open(network.settings("transport = 'bridge'\nnamespace = 'bot'")).await.unwrap();
    until(async || node.has_subscriber(OutputKind::Goal).await.unwrap()).await;
    for value in [1, 2] {
        let belief = OccupancyGrid { data: vec![value; 3], ..grid() };
        node.publish(2_000_000_000, Output::Belief(belief, PlanarPose::default())).await.unwrap();
    }
    // Earlier messages have then passed the router, without a receiver.
    node.publish(0, Output::Goal(PlanarPose::default())).await.unwrap();
    in_time(goals.recv()).await.unwrap();
    let (sender, mut receiver) = mpsc::unbounded_channel();
    let _late = network
        .robot
        .declare_subscriber("bot/dragnet/belief")
        .callback(move |sample| drop(sender.send(sample)))
        .advanced()
        .history(HistoryConfig::default().detect_late_publishers().max_samples(1))
        .await
        .unwrap();
    let latched = in_time(receiver.recv()).await.unwrap();
    let decoded: OccupancyGrid = cdr::decode(&latched.payload().to_bytes()).unwrap();
    assert_eq!((decoded.data, decoded.header.stamp.sec), (vec![2; 3], 2));
    assert!(latched.attachment().is_none());
}

#[tokio::test(flavor = "multi_thread")]
async fn detections_are_received_with_the_name_of_their_camera_also_empty_ones() {
    let network = Network::start().await;
    let cameras =
        "[{ name = 'left', detections = 'left/seen' }, { name = 'right', detections = 'right/seen' }]";
    let settings = network.settings(&format!("transport = 'bridge'\ncameras = {cameras}"));
    let node = Node::open(settings).await.unwrap();
    let mut seen = Detection2DArray { detections: vec![Detection2D::default()], ..Default::default() };
    (seen.detections[0].bbox.size_x, seen.detections[0].bbox.size_y) = (2.0, 2.0);
    for (camera, count) in [("right", 1), ("left", 0)] {
        seen.detections.truncate(count);
        let publisher = network.publisher(format!("{camera}/seen")).await;
        publisher.put(cdr::encode(&seen)).await.unwrap();
        let Incoming::Detections { camera: found, detections } = in_time(node.receive()).await else {
            panic!()
        };
        assert_eq!((&*found, detections.boxes.len()), (camera, count));
    }
}

/// Nav2's topics: it accepts a goal, aborts it, accepts another, and reaches it.
#[tokio::test(flavor = "multi_thread")]
async fn a_waypoint_is_handed_to_nav2_and_followed() {
    let network = Network::start().await;
    let mut waypoints = network.subscribe("goal_pose").await;
    let mut node = Node::open(network.settings("transport = 'bridge'")).await.unwrap();
    until(async || node.has_subscriber(OutputKind::Goal).await.unwrap()).await;
    let status = network.publisher("navigate_to_pose/_action/status".to_owned()).await;
    let mut reported = GoalStatusArray::default();
    let mut known = Vec::new();
    for (name, end, expected) in [(1, 6, Progress::Failed), (2, 4, Progress::Reached)] {
        let mut sent_goal = NavigationGoal::begin(&known);
        node.publish(0, Output::Goal(PlanarPose::default())).await.unwrap();
        in_time(waypoints.recv()).await.unwrap();
        let stamp = Time { sec: name.into(), nanosec: 0 };
        let goal_info = GoalInfo { goal_id: Uuid { uuid: [name; 16] }, stamp };
        reported.status_list.push(GoalStatus { goal_info, status: 2 });
        for (number, progress) in [(2, Progress::Underway), (end, expected)] {
            reported.status_list.last_mut().unwrap().status = number;
            status.put(cdr::encode(&reported)).await.unwrap();
            let Incoming::Goals(goals) = in_time(node.receive()).await else { panic!() };
            sent_goal.follow(&goals);
            assert_eq!(sent_goal.progress(), progress);
            known = goals;
        }
    }
    assert_eq!(known[0].state, GoalState::Aborted);
}

#[tokio::test(flavor = "multi_thread")]
async fn outputs_without_a_topic_are_not_published() {
    let network = Network::start().await;
    let mut node =
        Node::open(network.settings("transport = 'bridge'\npublish = { diagnostics = '' }")).await.unwrap();
    let diagnostic =
        Diagnostic { level: Level::Ok, name: "a".into(), message: "b".into(), values: Vec::new() };
    node.publish(0, Output::Diagnostics(vec![diagnostic])).await.unwrap();
    assert!(!node.has_subscriber(OutputKind::Diagnostics).await.unwrap());
}
