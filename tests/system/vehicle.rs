//! A robot deployed on a vehicle: `dragnet agent` as a process, and a vehicle that communicates like ROS 2 behind a
//! bridge.

use std::os::unix::net::UnixDatagram;
use std::path::PathBuf;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use dragnet_ros2::cdr;
use dragnet_ros2::wire::robot::{DiagnosticArray, PoseWithCovariance};
use dragnet_ros2::wire::standard::OccupancyGrid;
use dragnet_ros2::wire::vision::Detection3DArray;
use dragnet_runtime::session::{Endpoints, Mode, free_endpoints, open};

use crate::field::{DRAGNET, Process};
use crate::test_site::{SPEED_METERS_PER_SECOND, TestSite, Vehicle, cameras, settings};

const YARD: TestSite = TestSite { side: 4, cell_meters: 20.0, policy: "'path'" };

/// The robot's last messages.
#[derive(Default)]
struct Said {
    path: Option<Vec<u8>>,
    belief: OccupancyGrid,
    objects: Detection3DArray,
    tracks: Detection3DArray,
    diagnostics: DiagnosticArray,
}

#[tokio::test(flavor = "multi_thread")]
async fn a_robot_on_a_vehicle_finds_the_object_with_its_cameras() {
    let folder = tempfile::tempdir().unwrap();
    let endpoints = free_endpoints(2).unwrap();
    std::fs::write(folder.path().join("test_site.toml"), YARD.scenario()).unwrap();
    let file: PathBuf = folder.path().join("vehicle.toml");
    std::fs::write(&file, settings(&endpoints[0], &endpoints[1])).unwrap();
    let bridge =
        Endpoints { listen: vec![endpoints[1].clone()], mode: Some(Mode::Router), ..Endpoints::default() };
    let session = open(&bridge).await.unwrap();
    let said = Arc::new(Mutex::new(Said::default()));
    let received = Arc::clone(&said);
    let receive = move |key: &str, bytes: &[u8]| {
        let mut received = received.lock().unwrap();
        match key {
            "dragnet/path" => received.path = Some(bytes.to_vec()),
            "dragnet/belief" => received.belief = cdr::decode(bytes).unwrap(),
            "dragnet/objects" => received.objects = cdr::decode(bytes).unwrap(),
            "dragnet/tracks" => received.tracks = cdr::decode(bytes).unwrap(),
            "diagnostics" => received.diagnostics = cdr::decode(bytes).unwrap(),
            _ => {}
        }
    };
    session
        .declare_subscriber("**")
        .callback(move |sample| receive(sample.key_expr().as_str(), &sample.payload().to_bytes()))
        .background()
        .await
        .unwrap();
    let robot = Process::start(Command::new(DRAGNET).args(["agent", "--config"]).arg(&file));
    let mut vehicle = Vehicle::new(YARD);
    let cameras = cameras();
    let tick = Duration::from_millis(50);
    let mut ticks = tokio::time::interval(tick);
    for elapsed in 0.. {
        ticks.tick().await;
        if let Some(path) = said.lock().unwrap().path.take() {
            vehicle.follow(&path);
        }
        vehicle.drive(SPEED_METERS_PER_SECOND * tick.as_secs_f64());
        for (key, bytes) in vehicle.messages(&cameras) {
            session.put(key, bytes).await.unwrap();
        }
        let said = said.lock().unwrap();
        if !said.objects.detections.is_empty() && !said.tracks.detections.is_empty() {
            break;
        }
        let (belief, status) = (&said.belief.data, &said.diagnostics.status);
        assert!(elapsed < 20 * 120, "nothing is found; {:?}, {belief:?}, {status:?}", vehicle.here);
    }
    let (found, followed) = {
        let said = said.lock().unwrap();
        (said.objects.clone(), said.tracks.clone())
    };
    let places: Vec<[f64; 2]> = found
        .detections
        .iter()
        .map(|object| [object.bbox.center.position.x, object.bbox.center.position.y])
        .collect();
    assert_eq!(places, [[YARD.object_meters(); 2]]);
    // Poses and boxes count as exact: three standard deviations, and the motion between a pose and a frame.
    for object in found.detections.iter().chain(&followed.detections) {
        let PoseWithCovariance { pose, covariance } = object.results[0].pose;
        for (axis, place) in [pose.position.x, pose.position.y].into_iter().enumerate() {
            let std_meters = covariance[axis][axis].sqrt();
            let off = (place - YARD.object_meters()).abs();
            assert!(std_meters > 0.0 && off < 3.0 * std_meters + 1.0, "{object:?}");
        }
    }
    robot.terminate();
    // It was told to stop.
    let last = said.lock().unwrap().path.take();
    vehicle.follow(&last.unwrap());
    assert!(vehicle.way.is_empty());
}

#[test]
fn a_robot_whose_vehicle_never_comes_stops_on_request() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("test_site.toml"), YARD.scenario()).unwrap();
    let endpoints = free_endpoints(2).unwrap();
    let file = folder.path().join("vehicle.toml");
    std::fs::write(&file, settings(&endpoints[0], &endpoints[1])).unwrap();
    let path = folder.path().join("manager");
    let manager = UnixDatagram::bind(&path).unwrap();
    let robot = Process::start(
        Command::new(DRAGNET).args(["agent", "--config"]).arg(&file).env("NOTIFY_SOCKET", path),
    );
    let mut words = [0; 256];
    let length = manager.recv(&mut words).unwrap();
    assert_eq!(&words[..length], b"READY=1\n");
    robot.terminate();
}

#[test]
fn invalid_settings_of_a_vehicle_are_reported_with_their_key() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("test_site.toml"), YARD.scenario()).unwrap();
    let file = folder.path().join("vehicle.toml");
    let good = settings("tcp/127.0.0.1:0", "tcp/127.0.0.1:7447");
    let check = |from: &str, to: &str, reason: &str| {
        assert!(good.contains(from), "{from}");
        std::fs::write(&file, good.replace(from, to)).unwrap();
        let output = Command::new(DRAGNET).args(["agent", "--config"]).arg(&file).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && said.contains("vehicle.toml") && said.contains(reason), "{said}");
    };
    check(
        "speed_meters_per_second = 20.0\nfoot",
        "speed_meters_per_second = -1.0\nfoot",
        "vehicle.speed_meters_per_second",
    );
    check("field_of_view_degrees = 125.0", "field_of_view_degrees = 190.0", "vehicle.cameras");
    check("radius_meters = 0.5", "radius_meters = 0.5, motion = 1", "unknown field");
    check("name = \"camera_1\"\ndet", "name = \"camera_9\"\ndet", "\"camera_9\"; allowed are");
    check("localization = \"odometry\"", "localization = \"fix\"", "needs a map with an origin");
    check("[ros]\ntransport = \"bridge\"", "[ros]\ntransport = \"dds\"", "ros.transport");
    check(
        "[vehicle]\n",
        "[vehicle]\nmotion = { kind = \"lattice\", primitives = \"none.mprim\" }\n",
        "none.mprim",
    );
}
