//! A node of Dragnet's and one of hiroz, an independent ROS 2 client, on one network: a router between them, as
//! `rmw_zenohd` is, and each in a separate process. They agree on all hashes, and each receives the other's messages.
#![expect(clippy::unwrap_used, reason = "a test fails by panic")]

use std::collections::BTreeMap;
use std::env;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use dragnet_ros2::input::{GoalId, GoalState, Hypothesis, PlanarPose};
use dragnet_ros2::output::{Diagnostic, Level, ObjectEstimate, Output, OutputKind, PlanarEstimate};
use dragnet_ros2::schema::type_hash;
use dragnet_ros2::wire::standard::{MapMetaData, OccupancyGrid};
use dragnet_runtime::ros::incoming::Incoming;
use dragnet_runtime::ros::node::Node;
use dragnet_runtime::ros::settings::Settings;
use dragnet_runtime::session::{Endpoints, Mode, free_endpoints, open};
use serde_json::{Value, json};
use tokio::sync::mpsc;
use zenoh::Session;

const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// Without the other client the test fails: skipping it would look like success.
fn program() -> PathBuf {
    let given = env::var_os("DRAGNET_ROS_PEER").map(PathBuf::from);
    let program = given.unwrap_or_else(|| Path::new(WORKSPACE).join("target/ros_peer/debug/ros_peer"));
    assert!(
        program.exists(),
        "{} is missing; make it with\n  \
         cargo build --locked --manifest-path tests/ros_peer/Cargo.toml --target-dir target/ros_peer\n\
         at the workspace root, or name another one in DRAGNET_ROS_PEER",
        program.display()
    );
    program
}

/// The other client, and its output.
struct Peer {
    child: Child,
    reported: mpsc::UnboundedReceiver<Value>,
}

impl Peer {
    fn start(endpoint: &str) -> Self {
        let mut command = Command::new(program());
        command.args([endpoint, "7", "/bot"]).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let (sender, reported) = mpsc::unbounded_channel();
        std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                let _ = sender.send(serde_json::from_str(&line).unwrap());
            }
        });
        Self { child, reported }
    }

    /// Its next output about a topic; that about others is skipped.
    async fn tells_of(&mut self, topic: &str) -> Value {
        loop {
            let reported = in_time(self.reported.recv()).await.unwrap();
            if reported["topic"] == topic {
                return reported;
            }
        }
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A generous time limit for a busy computer.
async fn in_time<T>(what: impl Future<Output = T>) -> T {
    tokio::time::timeout(Duration::from_mins(2), what).await.unwrap()
}

/// A router, and Dragnet's node on it.
async fn network() -> (Session, String, Node) {
    let endpoint = free_endpoints(1).unwrap().remove(0);
    let endpoints =
        Endpoints { listen: vec![endpoint.clone()], mode: Some(Mode::Router), ..Endpoints::default() };
    let router = open(&endpoints).await.unwrap();
    let settings = format!(
        "transport = 'rmw_zenoh'\n\
         domain = 7\n\
         namespace = '/bot'\n\
         zenoh.connect = [{endpoint:?}]\n\
         cameras = [\n\
             {{ name = 'front', detections = 'front/detections', image = 'front/image_raw' }},\n\
             {{ name = 'rear', image = 'rear/image_raw' }},\n\
         ]"
    );
    let settings: Settings = toml::from_str(&settings).unwrap();
    let node = Node::open(settings.check(Path::new("robot.toml")).unwrap()).await.unwrap();
    (router, endpoint, node)
}

#[tokio::test(flavor = "multi_thread")]
async fn both_have_the_same_hashes() {
    let mut peer = Peer::start(&network().await.1);
    let reported = in_time(peer.reported.recv()).await.unwrap();
    let hashes = reported["hashes"].as_object().unwrap();
    assert_eq!(hashes.len(), 12);
    for (name, hash) in hashes {
        assert_eq!(hash, &type_hash(name, &[]), "{name}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn messages_of_the_other_client_are_received() {
    let (_router, endpoint, node) = network().await;
    let _peer = Peer::start(&endpoint);
    let mut received = BTreeMap::new();
    while received.len() < 8 {
        let next = in_time(node.receive()).await;
        let name = match &next {
            Incoming::Odometry(_) => "odometry",
            Incoming::Pose(_) => "pose",
            Incoming::Fix(_) => "fix",
            Incoming::Map(_) => "map",
            Incoming::Detections { .. } => "detections",
            Incoming::Image { .. } => "image",
            Incoming::Goals(_) => "goals",
            Incoming::Rejected { .. } => "refused",
            other => panic!("{other:?}"),
        };
        received.insert(name, next);
    }
    for received in received.into_values() {
        check(received);
    }
}

/// The messages of `tests/ros_peer`, value by value.
fn check(received: Incoming) {
    let stamp = 12_000_000_034;
    match received {
        Incoming::Odometry(received) => {
            let pose = PlanarPose { x_meters: 1.25, ..PlanarPose::default() };
            let covariance = Some([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.5]]);
            assert_eq!((received.place.pose, received.place.covariance), (pose, covariance));
            assert_eq!((received.place.stamp_unix_ns, received.robot_frame.as_str()), (stamp, "base_link"));
            assert!((received.velocity.forward_meters_per_second - 0.75).abs() < 1e-12);
        }
        Incoming::Pose(received) => {
            assert_eq!(
                (received.pose.y_meters, received.covariance, received.frame.as_str()),
                (-3.5, None, "map")
            );
            assert!((received.pose.yaw_radians.abs() - std::f64::consts::PI).abs() < 1e-12);
        }
        Incoming::Fix(received) => {
            let place = (received.point.latitude_degrees, received.point.longitude_degrees);
            assert_eq!((place, received.altitude_meters), ((49.25, -2.125), Some(12.5)));
        }
        Incoming::Map(received) => {
            assert_eq!((received.grid.columns(), received.grid.rows(), received.cell_meters), (3, 2, 0.5));
            assert_eq!(received.cells, [0, 100, -1, 0, 0, 50]);
        }
        Incoming::Detections { camera, detections } => {
            let seen = &detections.boxes[0];
            let edges = [seen.left, seen.top, seen.right, seen.bottom];
            assert_eq!((&*camera, edges), ("front", [300.0, 200.0, 340.0, 280.0]));
            assert_eq!(seen.hypothesis, Some(Hypothesis { class: "person".into(), score: 0.875 }));
        }
        Incoming::Image { camera, image } => {
            assert_eq!((&*camera, image.width_pixels, image.stamp_unix_ns), ("front", 2, stamp));
            assert_eq!(image.rgb, [30, 20, 10, 60, 50, 40]);
        }
        Incoming::Goals(goals) => {
            assert_eq!((goals[0].goal, goals[0].state), (GoalId([7; 16]), GoalState::Succeeded));
        }
        Incoming::Transforms(_)
        | Incoming::StaticTransforms(_)
        | Incoming::CameraInfo { .. }
        | Incoming::Stop(_)
        | Incoming::Battery(_) => panic!("{received:?}"),
        Incoming::Rejected { topic, reason } => {
            let expected =
                "node /bot/robot publishes it as std_msgs/msg/String; allowed is sensor_msgs/msg/Image";
            assert_eq!((topic.to_string().as_str(), reason.as_str()), ("/bot/rear/image_raw", expected));
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn published_messages_are_received() {
    let (_router, endpoint, mut node) = network().await;
    let now = 1_700_000_000_000_000_000;
    let info = MapMetaData { resolution: 1.0, width: 2, height: 1, ..MapMetaData::default() };
    let belief = OccupancyGrid { info, data: vec![3, -1], ..OccupancyGrid::default() };
    let object = ObjectEstimate {
        id: "5".into(),
        class: "person".into(),
        place: PlanarEstimate {
            x_meters: 16.5,
            y_meters: 45.0,
            covariance_square_meters: [[4.0, 0.0], [0.0, 2.25]],
        },
        box_center: PlanarPose { x_meters: 15.0, y_meters: 45.0, yaw_radians: 0.0 },
        box_edges_meters: [30.0; 2],
        probability: 0.9375,
    };
    // Before the other is there: it receives latched messages all the same.
    node.publish(now, Output::Belief(belief, PlanarPose::default())).await.unwrap();
    node.publish(now, Output::Objects(vec![object])).await.unwrap();
    let mut peer = Peer::start(&endpoint);
    let objects = json!([[15.0, 30.0, "person", 0.9375, "5", 16.5, 2.25]]);
    // They arrive in either order.
    for _ in 0..2 {
        let reported = loop {
            let reported = in_time(peer.reported.recv()).await.unwrap();
            if reported["topic"].is_string() {
                break reported;
            }
        };
        match reported["topic"].as_str() {
            Some("belief") => {
                assert_eq!((&reported["data"], &reported["sec"]), (&json!([3, -1]), &json!(1_700_000_000)));
            }
            _ => assert_eq!(reported["objects"], objects, "{reported}"),
        }
    }
    for kind in [OutputKind::Goal, OutputKind::Path, OutputKind::Diagnostics] {
        in_time(async {
            while !node.has_subscriber(kind).await.unwrap() {
                tokio::task::yield_now().await;
            }
        })
        .await;
    }
    let place = PlanarPose { x_meters: 4.5, y_meters: -2.0, yaw_radians: std::f64::consts::PI };
    node.publish(now, Output::Goal(place)).await.unwrap();
    let reported = peer.tells_of("goal").await;
    assert_eq!(
        (&reported["x"], &reported["y"], &reported["frame"]),
        (&json!(4.5), &json!(-2.0), &json!("map"))
    );
    assert!((reported["z"].as_f64().unwrap() - 1.0).abs() < 1e-12);
    node.publish(now, Output::Path(vec![place, PlanarPose::default()])).await.unwrap();
    assert_eq!(peer.tells_of("path").await["places"], json!([[4.5, -2.0], [0.0, 0.0]]));
    let values = vec![("age".to_owned(), "3".to_owned())];
    let diagnostic =
        Diagnostic { level: Level::Warning, name: "dragnet: pose".into(), message: "old".into(), values };
    node.publish(now, Output::Diagnostics(vec![diagnostic])).await.unwrap();
    let reported = peer.tells_of("diagnostics").await;
    assert_eq!(
        (&reported["level"], &reported["name"], &reported["value"]),
        (&json!(1), &json!("dragnet: pose"), &json!("3"))
    );
}
