//! `dragnet agent --dry-run`: a robot replays a recording made by an independent writer.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use dragnet_ros2::schema::RosMessage;
use dragnet_ros2::wire::vision::Detection2DArray;
use tempfile::TempDir;

use crate::field::DRAGNET;
use crate::interpreter::interpreter;
use crate::mentions::assert_mentions;
use crate::test_site::{TestSite, camera_tables};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// That of `tests/python/write_bag.py`.
const YARD: TestSite = TestSite { side: 4, cell_meters: 20.0, policy: "'path'" };

/// The robot of the recording, with this name of its cameras' topics.
fn settings(topic: &str, more: &str) -> String {
    let cameras = camera_tables([192, 128], "column_std_pixels = 1.0\n", topic);
    format!(
        "robot = 1\n{more}[common]\nmission = \"test_site\"\nscenario = \"test_site.toml\"\n[vehicle]\n\
         speed_meters_per_second = 20.0\nfootprint = {{ shape = \"disc\", radius_meters = 0.5 }}\n[ros]\n\
         transport = \"rmw_zenoh\"\nlocalization = \"odometry\"\nodometry_frame = \"map\"\n{cameras}"
    )
}

/// A folder with the recording and the robot's settings.
struct Place {
    folder: TempDir,
}

impl Place {
    fn new(settings: &str, options: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("test_site.toml"), YARD.scenario()).unwrap();
        fs::write(folder.path().join("vehicle.toml"), settings).unwrap();
        let script = Path::new(ROOT).join("tests/python/write_bag.py");
        let mut python = Command::new(interpreter(Path::new(ROOT)))
            .arg(script)
            .arg(folder.path().join("drive"))
            .args(options)
            .stdin(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let schemas = BTreeMap::from([(Detection2DArray::NAME, Detection2DArray::schema())]);
        python.stdin.take().unwrap().write_all(&serde_json::to_vec(&schemas).unwrap()).unwrap();
        let made = python.wait_with_output().unwrap();
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        Self { folder }
    }

    fn bag(&self) -> PathBuf {
        self.folder.path().join("drive/drive.mcap")
    }

    fn dry_run(&self, recording: &Path) -> Output {
        let config = self.folder.path().join("vehicle.toml");
        Command::new(DRAGNET)
            .args(["agent", "--config"])
            .arg(config)
            .arg("--dry-run")
            .arg(recording)
            .output()
            .unwrap()
    }

    fn succeed(&self) -> String {
        let output = self.dry_run(&self.bag());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }
}

/// Of a robot with a detector.
#[cfg(feature = "eyes")]
impl Place {
    /// The one object is found in the images, and where it is.
    fn check_images(&self) {
        let reported = self.succeed();
        assert_eq!(lines(&reported, "finds").len(), 1, "{reported}");
        let found = where_found(lines(&reported, "finds")[0]);
        assert!(found.iter().all(|meters| (meters - YARD.object_meters()).abs() < 5.0), "{reported}");
        assert!(reported.contains("/camera_2/image"), "{reported}");
    }
}

/// The lines of a kind, without their times and durations.
fn lines<'a>(reported: &'a str, kind: &str) -> Vec<&'a str> {
    let of_kind = |line: &'a str| line.split_once(" s  ")?.1.strip_prefix(kind);
    reported.lines().filter_map(of_kind).map(|line| line.split(", in ").next().unwrap().trim()).collect()
}

/// Meters east and north of what is found in the north-eastern cell.
fn where_found(reported: &str) -> [f64; 2] {
    let place = reported.split_once("[3, 3] at (").unwrap().1;
    let (place, std) = place.split_once(") m, std ").unwrap();
    assert!(std.ends_with(" m"), "{reported}");
    let (x, y) = place.split_once(", ").unwrap();
    [x, y].map(|meters| meters.parse().unwrap())
}

fn without_computing(reported: &str) -> String {
    let line =
        |line: &str| line.split(", in ").next().unwrap().split(", the slowest").next().unwrap().to_owned();
    reported.lines().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_robot_replays_a_recording_and_prints_its_actions() {
    let place = Place::new(&settings("detections", ""), &[]);
    let reported = place.succeed();
    // It drove along the southern edge, where odometry is missing from 50 to 80 m, and then north.
    let observations: Vec<&str> =
        lines(&reported, "observes").iter().map(|line| &line["from ".len()..][.."[0, 0]".len()]).collect();
    assert_eq!(observations[..2], ["[0, 0]", "[0, 1]"], "{reported}");
    assert!(observations.contains(&"[1, 3]") && observations.contains(&"[2, 3]"), "{reported}");
    let found = where_found(lines(&reported, "finds")[0]);
    assert_eq!(lines(&reported, "finds").len(), 1, "{reported}");
    assert!(found.iter().all(|meters| (meters - YARD.object_meters()).abs() < 5.0), "{reported}");
    let silent = "pose: no pose arrives: /odom: no message arrives";
    assert_eq!(
        lines(&reported, "error")
            .iter()
            .chain(&lines(&reported, "warning"))
            .filter(|line| **line == silent)
            .count(),
        1,
        "{reported}"
    );
    assert!(lines(&reported, "decides").first().is_some_and(|line| line.contains(" to [")), "{reported}");
    let rows: Vec<String> =
        reported.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    // 23.6 s at 20 Hz, less three; and an observation every other second. In those three seconds, in which it turned,
    // the vehicle's pose is unknown.
    for row in [
        "/odom nav_msgs/msg/Odometry 412 0",
        "/fix sensor_msgs/msg/NavSatFix 24 24",
        "/camera_0/detections vision_msgs/msg/Detection2DArray 236 30",
    ] {
        assert!(rows.contains(&row.to_owned()), "{reported}");
    }
    let fix = reported.lines().find(|line| line.contains("rejected on /fix")).unwrap();
    assert_mentions(fix, "/fix .. std_msgs/msg/String .. sensor_msgs/msg/NavSatFix");
    let last = where_found(reported.split_once("found: ").unwrap().1.lines().next().unwrap());
    assert!(last.iter().all(|meters| (meters - YARD.object_meters()).abs() < 1.0), "{reported}");
    assert!(reported.contains("/dragnet/belief "), "{reported}");

    assert_eq!(without_computing(&reported), without_computing(&place.succeed()));
    let mut left: Vec<_> = fs::read_dir(place.folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    left.sort();
    assert_eq!(left, ["drive", "test_site.toml", "vehicle.toml"], "nothing is written");
}

/// The same drive, of which transforms and calibrations say what the settings do not.
#[test]
fn a_robot_replays_transforms_and_calibrations() {
    let cameras = [0, 1, 2].map(|number| {
        format!(
            "[[vehicle.cameras]]\nname = \"camera_{number}\"\nmin_range_meters = 0.5\nmax_range_meters = 80.0\n\
             column_std_pixels = 1.0\n[[ros.cameras]]\nname = \"camera_{number}\"\n\
             detections = \"camera_{number}/detections\"\ncamera_info = \"camera_{number}/camera_info\"\n"
        )
    });
    let by_hand = settings("detections", "");
    let (begin, _) = by_hand.split_once("[[vehicle.cameras]]").unwrap();
    let tf = "localization = \"tf\"\n";
    let begin = begin.replace("localization = \"odometry\"\nodometry_frame = \"map\"\n", tf);
    assert!(begin.contains(tf), "{begin}");
    let reported = Place::new(&format!("{begin}{}", cameras.concat()), &["tf"]).succeed();
    let found = where_found(lines(&reported, "finds")[0]);
    assert_eq!(lines(&reported, "finds").len(), 1, "{reported}");
    assert!(found.iter().all(|meters| (meters - YARD.object_meters()).abs() < 5.0), "{reported}");
    let silent = "pose: no pose arrives: /tf: the newest transform from \"map\" to \"odom\" is 1.1 s old";
    let silent = lines(&reported, "error").into_iter().filter(|line| *line == silent).count();
    assert_eq!(silent, 1, "{reported}");
    let rows: Vec<String> =
        reported.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    for row in [
        "/tf tf2_msgs/msg/TFMessage 412 0",
        "/tf_static tf2_msgs/msg/TFMessage 1 0",
        "/camera_0/camera_info sensor_msgs/msg/CameraInfo 236 0",
        "/camera_0/detections vision_msgs/msg/Detection2DArray 236 30",
    ] {
        assert!(rows.contains(&row.to_owned()), "{row}: {reported}");
    }
}

/// Messages rejected late in the chain are counted with their topic.
#[test]
fn invalid_frames_are_counted_for_any_reason() {
    let reported = Place::new(&settings("detections", ""), &["stamps"]).succeed();
    let row = |topic: &str| -> Vec<u32> {
        let row = reported.lines().find(|line| line.trim_start().starts_with(topic)).unwrap();
        row.split_whitespace().filter_map(|word| word.parse().ok()).collect()
    };
    // Without poses for three seconds.
    assert_eq!(row("/camera_0/detections"), [236, 30], "{reported}");
    for camera in ["camera_1", "camera_2"] {
        // Those of the first seconds are not too old yet.
        let [messages, refused] = row(&format!("/{camera}/detections"))[..] else { panic!("{reported}") };
        assert!(messages == 236 && refused > 180, "{reported}");
    }
    for (topic, reason) in
        [("/camera_1/detections", "20.0 s before"), ("/camera_2/detections", "stamps stand still")]
    {
        let refused = reported.lines().find(|line| line.contains(&format!("rejected on {topic}"))).unwrap();
        assert_mentions(refused, &format!("{topic} .. {reason} .. `stamps = \"arrival\"`"));
    }
    // Each is one fault, reported once; so is that no frame of it is valid.
    for (camera, level) in [("camera_1", "error"), ("camera_2", "error")] {
        let silence = format!("silence of {camera}: no frame comes that can be used");
        assert_eq!(lines(&reported, level).iter().filter(|line| **line == silence).count(), 1, "{reported}");
        let count = lines(&reported, "warning")
            .iter()
            .filter(|line| line.starts_with(&format!("camera {camera}: ")))
            .count();
        assert!((1..=2).contains(&count), "{reported}");
    }
}

#[test]
fn a_truncated_or_invalid_recording_is_reported() {
    let place = Place::new(&settings("detections", ""), &[]);
    let bytes = fs::read(place.bag()).unwrap();
    let cut = place.folder.path().join("cut.mcap");
    // Intact parts count: all of the first chunk.
    fs::write(&cut, &bytes[..bytes.len() - 40]).unwrap();
    let output = place.dry_run(&cut);
    let reported = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && reported.contains("the recording was cut off"), "{reported}");
    assert!(reported.contains("found: [3, 3] at ("), "{reported}");

    // A bag is a folder with its recording.
    assert!(place.dry_run(&place.folder.path().join("drive")).status.success());
    fs::create_dir(place.folder.path().join("empty")).unwrap();
    let refuse = |recording: &Path, reason: &str| {
        let output = place.dry_run(recording);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(reason), "{said}");
    };
    refuse(&place.folder.path().join("absent.mcap"), "absent.mcap: cannot read");
    refuse(&place.folder.path().join("test_site.toml"), "test_site.toml: not a recording");
    refuse(&place.folder.path().join("empty"), "empty: not a recording");
    let bare = "robot = 1\n[common]\nmission = \"test_site\"\nscenario = \"test_site.toml\"\n";
    fs::write(place.folder.path().join("vehicle.toml"), bare).unwrap();
    refuse(&place.bag(), "[vehicle] and [ros]");
}

/// A robot with its own detector processes the images themselves.
#[cfg(feature = "detector")]
#[test]
fn a_detector_processes_recorded_images() {
    let detector = "detector = { module = \"modules/red.torchscript\" }\n";
    let place = Place::new(&settings("image", detector), &["images"]);
    let modules = place.folder.path().join("modules");
    fs::create_dir(&modules).unwrap();
    let script = Path::new(ROOT).join("tests/python/modules.py");
    let made = Command::new(interpreter(Path::new(ROOT))).arg(script).arg(&modules).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    place.check_images();

    // In images of another size than the camera's the boxes would have another meaning.
    let wrong = settings("image", detector).replace("width_pixels = 192", "width_pixels = 384");
    fs::write(place.folder.path().join("vehicle.toml"), wrong).unwrap();
    let reported = place.succeed();
    let warnings = lines(&reported, "warning");
    let image = warnings.iter().find(|line| line.starts_with("image, camera_0: ")).unwrap();
    assert_mentions(image, "192 x 128 .. 384 x 128 .. vehicle.cameras");
    assert!(lines(&reported, "finds").is_empty(), "{reported}");
}

/// So does one with the network that comes with the repository.
#[cfg(feature = "onnx")]
#[test]
fn the_example_network_processes_recorded_images() {
    let network = Path::new(ROOT).join("vehicle/detector/example/figures.onnx");
    let detector =
        format!("detector = {{ module = {:?}, classes = [\"post\"] }}\n", network.display().to_string());
    Place::new(&settings("image", &detector), &["images"]).check_images();
}

#[test]
fn each_camera_has_one_detector() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("test_site.toml"), YARD.scenario()).unwrap();
    let refuse = |settings: &str, reason: &str| {
        let file = folder.path().join("vehicle.toml");
        fs::write(&file, settings).unwrap();
        let output = Command::new(DRAGNET).args(["agent", "--config"]).arg(file).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(reason), "{said}");
    };
    let detector = "detector = { module = \"red.torchscript\" }\n";
    refuse(&settings("image", ""), "ros.cameras");
    refuse(&settings("detections", detector), "[detector] has no images");
    let both = settings("image", detector).replace("image = ", "detections = \"seen\"\nimage = ");
    refuse(&both, "a camera of ros.cameras that has no detections");
    let absent = if cfg!(feature = "eyes") { "red.torchscript: cannot read it" } else { "built without" };
    refuse(&settings("image", detector), absent);
}
