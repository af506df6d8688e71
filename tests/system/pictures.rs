//! Pictures of finds, from a vehicle's camera to the coordinator's recording.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use dragnet_coordinator::fold::MissionFold;
use dragnet_coordinator::mission::Record;
use dragnet_coordinator::playback::Playback;
use dragnet_keys::folder::{Folder, SETTINGS};
use dragnet_keys::name::Name;
use dragnet_keys::register::Topology;
use dragnet_proto::picture::Picture;
use dragnet_ros2::cdr;
use dragnet_ros2::input::{Input, InputKind};
use dragnet_ros2::wire::robot::{CompressedImage, Image};
use dragnet_ros2::wire::vision::Detection2DArray;
use dragnet_runtime::session::{Endpoints, Mode, free_endpoints, open};
use dragnet_search::cell::Position;
use serde_json::Value;
use time::OffsetDateTime;
use zenoh::Session;

use crate::field::{DRAGNET, Process};
use crate::test_site::{SPEED_METERS_PER_SECOND, TestSite, Vehicle, cameras, settings};

const YARD: TestSite = TestSite { side: 4, cell_meters: 20.0, policy: "'path'" };
/// Half as many columns and rows as boxes refer to.
const SIZE: [u32; 2] = [500, 300];

/// A gray image with a red object in the box of a camera's only detection.
fn image(seen: &Detection2DArray) -> Image {
    let center = seen.detections[0].bbox.center.position;
    let [width, height] = SIZE;
    let is_near = |pixel: u32, center: f64, half: f64| (2.0 * f64::from(pixel) + 1.0 - center).abs() < half;
    let pixel = |number: u32| {
        let is_object = is_near(number % width, center.x, 5.0) && is_near(number / width, center.y, 15.0);
        if is_object { [250, 20, 20] } else { [120, 120, 120] }
    };
    Image {
        header: seen.header.clone(),
        width,
        height,
        encoding: "rgb8".to_owned(),
        step: 3 * width,
        data: (0..width * height).flat_map(pixel).collect(),
        ..Image::default()
    }
}

/// Drives the vehicle by the robot's paths, with an image of the camera that sees the object every fifth time, until this
/// text is in the coordinator's log.
async fn drive(session: &Session, log: &Path, until: &str) {
    let paths = session.declare_subscriber("dragnet/path").await.unwrap();
    let (mut vehicle, cameras) = (Vehicle::new(YARD), cameras());
    let tick = Duration::from_millis(50);
    let mut ticks = tokio::time::interval(tick);
    for elapsed in 0.. {
        ticks.tick().await;
        if let Ok(Some(path)) = paths.try_recv() {
            vehicle.follow(&path.payload().to_bytes());
        }
        vehicle.drive(SPEED_METERS_PER_SECOND * tick.as_secs_f64());
        for (key, bytes) in vehicle.messages(&cameras) {
            if let Some(camera) = key.strip_suffix("/detections").filter(|_| elapsed % 5 == 0) {
                let seen: Detection2DArray = cdr::decode(&bytes).unwrap();
                if !seen.detections.is_empty() {
                    session.put(format!("{camera}/image"), cdr::encode(&image(&seen))).await.unwrap();
                }
            }
            session.put(key, bytes).await.unwrap();
        }
        let said = fs::read_to_string(log).unwrap();
        if said.contains(until) {
            return;
        }
        assert!(elapsed < 20 * 120, "no picture arrives: {said}");
    }
}

/// The red pixels of a picture by their distance from its middle, pixels, and its size.
fn reds(picture: &Picture) -> (Vec<f64>, [u32; 2]) {
    let message = CompressedImage { data: picture.jpeg.to_vec(), ..CompressedImage::default() };
    let Ok(Input::Image(shown)) = InputKind::CompressedImage.understand(&cdr::encode(&message)) else {
        panic!("no JPEG")
    };
    let [width, height] = [shown.width_pixels, shown.height_pixels];
    let middle = |pixel: usize, size: u32| pixel as f64 + 0.5 - f64::from(size) / 2.0;
    let pixels = shown.rgb.chunks_exact(3).enumerate().filter(|(_, rgb)| rgb[0] > 180 && rgb[1] < 90);
    let offset = |(number, _): (usize, &[u8])| {
        let (row, column) = (number / width as usize, number % width as usize);
        middle(column, width).hypot(middle(row, height))
    };
    (pixels.map(offset).collect(), [width, height])
}

/// The coordinator knows where the object is, to a fraction of a cell, and has said so.
fn check_position(playback: &Playback, said: &str) {
    let mut fold = MissionFold::of(playback);
    for (_, record) in &playback.records {
        fold.take(record);
    }
    let cell = playback.terrain.grid().cell(Position { row: 3, column: 3 }).unwrap();
    let position = fold.position(cell).unwrap_or_else(|| panic!("no position is recorded; {said}"));
    let ((east, north), accuracy_meters) = (position.meters(), position.accuracy_meters());
    let off = (east - YARD.object_meters()).hypot(north - YARD.object_meters());
    // Poses and boxes count as exact: half a meter is the motion between a pose and a frame.
    assert!(off < accuracy_meters + 1.0 && accuracy_meters < YARD.cell_meters / 2.0, "{off} m: {position:?}");
    let declared = said.lines().find(|line| line.contains("declared: an object at [3, 3] at "));
    let declared = declared.unwrap_or_else(|| panic!("{said}"));
    assert!(declared.contains(" m east, ") && declared.contains(" m with 95 % probability), "), "{declared}");
}

/// The position is in what is made of the recording.
fn check_files(recording: &Path) {
    let dragnet = |arguments: &[&str]| {
        let output = Command::new(DRAGNET).args(arguments).arg(recording).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    for told in [dragnet(&["inspect"]), dragnet(&["replay"])] {
        assert!(told.contains("[3, 3] at ") && told.contains(" m with 95 % probability"), "{told}");
    }
    let file = recording.with_extension("geojson");
    dragnet(&["export", "--origin", "0,0", "--to", &file.display().to_string()]);
    let text: Value = serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap();
    let mut features = text["features"].as_array().unwrap().iter();
    let found = features.find(|feature| feature["properties"]["kind"] == "found").unwrap();
    let accuracy = found["properties"]["accuracy_meters"].as_f64().unwrap();
    // A degree has 111 km at the equator.
    let meters = |axis: usize| found["geometry"]["coordinates"][axis].as_f64().unwrap() * 111e3;
    let off = (meters(0) - YARD.object_meters()).hypot(meters(1) - YARD.object_meters());
    assert!(off < accuracy + 1.5, "{found}");
}

/// A team of one robot and the coordinator, whose parts of the settings of Zenoh these are; returns the picture in the recording.
async fn pictured(folder: &Path, scenario: &str, [robot, coordinator]: [String; 2]) -> Picture {
    fs::write(folder.join("test_site.toml"), scenario).unwrap();
    let bridge_at = free_endpoints(1).unwrap().remove(0);
    let robots = settings("none", &bridge_at)
        .replace("zenoh = { listen = [\"none\"] }", &format!("zenoh = {{ {robot} }}"))
        .replace("detections = \"camera", "image = \"CAMERA");
    // Both topics of each camera.
    let both = |line: &str| match line.strip_prefix("image = \"CAMERA_") {
        Some(rest) => {
            let number = &rest[..1];
            format!("detections = \"camera_{number}/detections\"\nimage = \"camera_{number}/image\"\n")
        }
        None => format!("{line}\n"),
    };
    let robots: String = robots.lines().map(both).collect();
    let (agent, center) = (folder.join("robot.toml"), folder.join("coordinator.toml"));
    fs::write(&agent, robots).unwrap();
    let recording = folder.join("mission.mcap");
    let common = "[common]\nmission = \"test_site\"\nscenario = \"test_site.toml\"\n";
    let text =
        format!("recording = {:?}\n{common}zenoh = {{ {coordinator} }}\n", recording.display().to_string());
    fs::write(&center, text).unwrap();
    let bridge = Endpoints { listen: vec![bridge_at], mode: Some(Mode::Router), ..Endpoints::default() };
    let session = open(&bridge).await.unwrap();
    let log = folder.join("coordinator.log");
    let center =
        Process::start_logged(Command::new(DRAGNET).args(["coordinator", "--config"]).arg(&center), &log);
    let agent = Process::start(Command::new(DRAGNET).args(["agent", "--config"]).arg(&agent));
    drive(&session, &log, "the coordinator has a picture of the object at [3, 3]").await;
    let said = fs::read_to_string(&log).unwrap();
    agent.terminate();
    center.terminate();
    let playback = Playback::read(&recording).unwrap();
    check_position(&playback, &said);
    check_files(&recording);
    let pictures = playback.records.into_iter().filter_map(|(_, record)| match record {
        Record::Picture(picture) => Some(picture),
        _ => None,
    });
    let picture = (*pictures.last().unwrap_or_else(|| panic!("none is recorded; {said}"))).clone();
    let grid = playback.terrain.grid();
    assert_eq!(grid.position(picture.facts.cell), Position { row: 3, column: 3 });
    assert!(picture.facts.camera.starts_with("camera_") && picture.facts.robot.number() == 1, "{picture:?}");
    let (reds, size) = reds(&picture);
    // The box has 5 x 15 pixels of the image; around it is half its size.
    assert!(size[0].abs_diff(10) <= 2 && size[1].abs_diff(30) <= 2, "{size:?}");
    assert!(reds.len() > 30 && reds.iter().all(|&offset| offset < 10.0), "{reds:?}");
    picture
}

#[tokio::test(flavor = "multi_thread")]
async fn a_thin_link_brings_a_picture_of_a_find_in_parts() {
    let folder = tempfile::tempdir().unwrap();
    let at = free_endpoints(2).unwrap();
    let zenoh =
        [format!("listen = [{:?}]", at[0]), format!("listen = [{:?}], connect = [{:?}]", at[1], at[0])];
    let scenario = format!("{}[network]\nbytes_per_second = 1200\n", YARD.scenario());
    let picture = pictured(folder.path(), &scenario, zenoh).await;
    assert!(picture.jpeg.len() > 300, "of several parts: {}", picture.jpeg.len());
}

#[tokio::test(flavor = "multi_thread")]
async fn over_mutual_tls_a_picture_arrives_too() {
    let folder = tempfile::tempdir().unwrap();
    let now = OffsetDateTime::now_utc();
    let mission = "test_site".parse().unwrap();
    let mut keys = Folder::init(&folder.path().join("keys"), mission, Topology::Mesh, now).unwrap();
    let names = [Name::robot(1).unwrap(), Name::COORDINATOR];
    keys.add(&names, &[], 1, now).unwrap();
    let at: Vec<String> =
        free_endpoints(2).unwrap().iter().map(|endpoint| endpoint.replace("tcp/", "tls/")).collect();
    let [robot, coordinator] = names.map(|name| keys.home(name).join(SETTINGS).display().to_string());
    let zenoh = [
        format!("listen = [{:?}], config = {robot:?}", at[0]),
        format!("listen = [{:?}], connect = [{:?}], config = {coordinator:?}", at[1], at[0]),
    ];
    pictured(folder.path(), &YARD.scenario(), zenoh).await;
}
