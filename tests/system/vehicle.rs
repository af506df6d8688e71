//! A robot deployed on a vehicle: `dragnet agent` as a process, and a vehicle that speaks as ROS 2 behind a bridge does.

use std::os::unix::net::UnixDatagram;
use std::path::PathBuf;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use dragnet_link::session::{Endpoints, Mode, free_endpoints, open};
use dragnet_proto::cdr;
use dragnet_proto::wire::robot::{DiagnosticArray, Odometry};
use dragnet_proto::wire::standard::{Header, Path, Pose, Time};
use dragnet_proto::wire::vision::{
    BoundingBox2D, Detection2D, Detection2DArray, Detection3DArray, Point2D, Pose2D,
};
use dragnet_vehicle::camera::{Camera, CameraSettings};
use dragnet_vehicle::plane;

use crate::field::{DRAGNET, Process};

/// Cells of 20 m; one object, in the north-eastern one.
const SCENARIO: &str = "name = \"yard\"\n[map]\nshape = \"all_traversable\"\nrows = 4\ncolumns = 4\ncell_meters = 20.0\n\
                        [objects]\ncount = 1\n[sensor]\nradius = 2\n[robots]\ncount = 1\npolicy = \"path\"\n\
                        [mission]\nbudget_seconds = 3600.0\nspeed_meters_per_second = 20.0\n";
const OBJECT_METERS: [f64; 2] = [70.0, 70.0];
const SPEED_METERS_PER_SECOND: f64 = 10.0;
const WIDTH_PIXELS: u32 = 1000;
/// Each looks a third of the way around.
const YAWS_DEGREES: [f64; 3] = [0.0, 120.0, -120.0];

/// A vehicle that drives along the last path that it heard, and sees well.
struct Vehicle {
    /// What it is asked to drive, from where it is.
    way: Vec<plane::Pose>,
    here: plane::Pose,
}

impl Vehicle {
    fn drive(&mut self, mut meters: f64) {
        while let Some(&next) = self.way.first() {
            let offset = next.position_meters() - self.here.position_meters();
            if offset.norm() > meters {
                let reached = self.here.position_meters() + offset * (meters / offset.norm());
                self.here = plane::Pose::new(reached.x, reached.y, next.heading_radians);
                return;
            }
            meters -= offset.norm();
            self.here = self.way.remove(0);
        }
    }

    fn odometry(&self) -> Odometry {
        let mut odometry = Odometry { header: header(), ..Odometry::default() };
        "base_link".clone_into(&mut odometry.child_frame_id);
        odometry.pose.pose = posed(self.here);
        odometry
    }

    fn sees(&self, camera: &Camera) -> Detection2DArray {
        let eye = self.here.of_part(&camera.settings().mounting);
        let object = plane::Pose::new(OBJECT_METERS[0], OBJECT_METERS[1], 0.0);
        let bearing = plane::bearing_radians(eye.position_meters(), object.position_meters());
        let column = camera.column_pixels(plane::turn_radians(eye.heading_radians, bearing));
        let found = column.map(|x| {
            let center = Pose2D { position: Point2D { x, y: 300.0 }, theta: 0.0 };
            let bbox = BoundingBox2D { center, size_x: 10.0, size_y: 30.0 };
            Detection2D { header: header(), bbox, ..Detection2D::default() }
        });
        Detection2DArray { header: header(), detections: found.into_iter().collect() }
    }
}

fn header() -> Header {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    Header { stamp: Time::at_unix_ns(i128::try_from(now.as_nanos()).unwrap()), frame_id: "map".to_owned() }
}

fn posed(pose: plane::Pose) -> Pose {
    let mut posed = Pose::default();
    (posed.position.x, posed.position.y) = (pose.x_meters, pose.y_meters);
    (posed.orientation.z, posed.orientation.w) = (pose.heading_radians / 2.0).sin_cos();
    posed
}

fn plane_pose(pose: &Pose) -> plane::Pose {
    let heading = 2.0 * pose.orientation.z.atan2(pose.orientation.w);
    plane::Pose::new(pose.position.x, pose.position.y, heading)
}

fn cameras() -> [Camera; 3] {
    [0, 1, 2].map(|number| {
        let settings = CameraSettings {
            name: format!("camera_{number}"),
            width_pixels: WIDTH_PIXELS,
            height_pixels: 600,
            field_of_view_radians: 125.0_f64.to_radians(),
            mounting: plane::Pose::new(0.0, 0.0, YAWS_DEGREES[number].to_radians()),
            nearest_meters: 0.5,
            farthest_meters: 80.0,
        };
        Camera::new(settings).unwrap()
    })
}

fn settings(team: &str, bridge: &str) -> String {
    let cameras = [0, 1, 2].map(|number| {
        format!(
            "[[vehicle.cameras]]\nname = \"camera_{number}\"\nwidth_pixels = {WIDTH_PIXELS}\nheight_pixels = 600\n\
             field_of_view_degrees = 125.0\nyaw_degrees = {:?}\nnearest_meters = 0.5\nfarthest_meters = 80.0\n\
             [[ros.cameras]]\nname = \"camera_{number}\"\ndetections = \"camera_{number}/detections\"\n",
            YAWS_DEGREES[number]
        )
    });
    let cameras = cameras.concat();
    format!(
        "robot = 1\n[common]\nmission = \"yard\"\nscenario = \"yard.toml\"\nzenoh = {{ listen = [{team:?}] }}\n\
         [vehicle]\nspeed_meters_per_second = 20.0\nfootprint = {{ shape = \"disc\", radius_meters = 0.5 }}\n\
         [ros]\ntransport = \"bridge\"\nlocalization = \"odometry\"\nodometry_frame = \"map\"\n\
         zenoh = {{ connect = [{bridge:?}] }}\n{cameras}"
    )
}

/// What the robot said last.
#[derive(Default)]
struct Said {
    path: Option<Path>,
    objects: Detection3DArray,
    diagnostics: DiagnosticArray,
}

#[tokio::test(flavor = "multi_thread")]
async fn a_robot_on_a_vehicle_searches_and_finds_what_its_cameras_see() {
    let folder = tempfile::tempdir().unwrap();
    let endpoints = free_endpoints(2).unwrap();
    std::fs::write(folder.path().join("yard.toml"), SCENARIO).unwrap();
    let file: PathBuf = folder.path().join("vehicle.toml");
    std::fs::write(&file, settings(&endpoints[0], &endpoints[1])).unwrap();
    let bridge =
        Endpoints { listen: vec![endpoints[1].clone()], mode: Some(Mode::Router), ..Endpoints::default() };
    let session = open(&bridge).await.unwrap();
    let said = Arc::new(Mutex::new(Said::default()));
    let heard = Arc::clone(&said);
    let hear = move |key: &str, bytes: &[u8]| {
        let mut heard = heard.lock().unwrap();
        match key {
            "dragnet/path" => heard.path = Some(cdr::decode(bytes).unwrap()),
            "dragnet/objects" => heard.objects = cdr::decode(bytes).unwrap(),
            "diagnostics" => heard.diagnostics = cdr::decode(bytes).unwrap(),
            _ => {}
        }
    };
    session
        .declare_subscriber("**")
        .callback(move |sample| hear(sample.key_expr().as_str(), &sample.payload().to_bytes()))
        .background()
        .await
        .unwrap();
    let robot = Process::start(Command::new(DRAGNET).args(["agent", "--config"]).arg(&file));
    let mut vehicle = Vehicle { way: Vec::new(), here: plane::Pose::new(10.0, 10.0, 0.3) };
    let cameras = cameras();
    let tick = Duration::from_millis(50);
    let mut ticks = tokio::time::interval(tick);
    for elapsed in 0.. {
        ticks.tick().await;
        if let Some(path) = said.lock().unwrap().path.take() {
            vehicle.way = path.poses.iter().map(|stamped| plane_pose(&stamped.pose)).collect();
        }
        vehicle.drive(SPEED_METERS_PER_SECOND * tick.as_secs_f64());
        session.put("odom", cdr::encode(&vehicle.odometry())).await.unwrap();
        for camera in &cameras {
            let key = format!("{}/detections", camera.settings().name);
            session.put(key, cdr::encode(&vehicle.sees(camera))).await.unwrap();
        }
        let said = said.lock().unwrap();
        if !said.objects.detections.is_empty() {
            break;
        }
        assert!(elapsed < 20 * 120, "nothing is found; {:?}", said.diagnostics.status);
    }
    let found = said.lock().unwrap().objects.clone();
    let places: Vec<[f64; 2]> = found
        .detections
        .iter()
        .map(|object| [object.bbox.center.position.x, object.bbox.center.position.y])
        .collect();
    assert_eq!(places, [OBJECT_METERS]);
    robot.terminate();
    // It was told to stand still.
    let last = said.lock().unwrap().path.take();
    assert_eq!(last.map(|path| path.poses.len()), Some(0));
}

#[test]
fn a_robot_whose_vehicle_never_comes_stops_when_it_is_told_to() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("yard.toml"), SCENARIO).unwrap();
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
fn settings_of_a_vehicle_that_cannot_be_are_told_with_their_key() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("yard.toml"), SCENARIO).unwrap();
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
    check(
        "name = \"camera_1\"\ndet",
        "name = \"camera_9\"\ndet",
        "\"camera_9\"; allowed are those of vehicle",
    );
    check("localization = \"odometry\"", "localization = \"fix\"", "needs a map with an origin");
    check("[ros]\ntransport = \"bridge\"", "[ros]\ntransport = \"dds\"", "ros.transport");
    check(
        "[vehicle]\n",
        "[vehicle]\nmotion = { kind = \"lattice\", primitives = \"none.mprim\" }\n",
        "none.mprim",
    );
}
