//! `dragnet agent --dry-run`: a robot that lives through a recording, which a writer made that is not ours.

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
use crate::test_site::{TestSite, camera_tables};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// That of `tests/python/write_bag.py`.
const YARD: TestSite = TestSite { side: 4, cell_meters: 20.0, policy: "'path'" };

/// The robot of the recording, whose cameras' topics are called so.
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

/// The lines of a kind, without their times and how long anything took.
fn lines<'a>(told: &'a str, kind: &str) -> Vec<&'a str> {
    let of_kind = |line: &'a str| line.split_once(" s  ")?.1.strip_prefix(kind);
    told.lines().filter_map(of_kind).map(|line| line.split(", in ").next().unwrap().trim()).collect()
}

/// Meters east and north of what is found in the north-eastern cell.
fn where_found(told: &str) -> [f64; 2] {
    let place = told.split_once("[3, 3] at (").unwrap().1;
    let (place, std) = place.split_once(") m, std ").unwrap();
    assert!(std.ends_with(" m"), "{told}");
    let (x, y) = place.split_once(", ").unwrap();
    [x, y].map(|meters| meters.parse().unwrap())
}

fn without_computing(told: &str) -> String {
    let line =
        |line: &str| line.split(", in ").next().unwrap().split(", the slowest").next().unwrap().to_owned();
    told.lines().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_robot_lives_through_a_recording_and_tells_what_it_would_have_done() {
    let place = Place::new(&settings("detections", ""), &[]);
    let told = place.succeed();
    // It drove there: along the southern edge, where odometry is missing from 50 to 80 m, and north.
    let looks: Vec<&str> =
        lines(&told, "looks").iter().map(|line| &line["from ".len()..][.."[0, 0]".len()]).collect();
    assert_eq!(looks[..2], ["[0, 0]", "[0, 1]"], "{told}");
    assert!(looks.contains(&"[1, 3]") && looks.contains(&"[2, 3]"), "{told}");
    let found = where_found(lines(&told, "finds")[0]);
    assert_eq!(lines(&told, "finds").len(), 1, "{told}");
    assert!(found.iter().all(|meters| (meters - YARD.object_meters()).abs() < 5.0), "{told}");
    let silent = "pose: no pose comes: /odom: nothing comes";
    assert_eq!(
        lines(&told, "error").iter().chain(&lines(&told, "warning")).filter(|line| **line == silent).count(),
        1,
        "{told}"
    );
    assert!(lines(&told, "decides").first().is_some_and(|line| line.contains(" to [")), "{told}");
    let rows: Vec<String> =
        told.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    // 23.6 s at 20 Hz, less three; and every second time a look. Where the vehicle was in those three seconds, in which it
    // turned, nobody knows.
    for row in [
        "/odom nav_msgs/msg/Odometry 412 0",
        "/fix sensor_msgs/msg/NavSatFix 24 24",
        "/camera_0/detections vision_msgs/msg/Detection2DArray 236 30",
    ] {
        assert!(rows.contains(&row.to_owned()), "{told}");
    }
    let fix = "refused on /fix, the last: recorded is std_msgs/msg/String as cdr; allowed is sensor_msgs/msg/NavSatFix as cdr";
    assert!(told.contains(fix), "{told}");
    let last = where_found(told.split_once("found: ").unwrap().1.lines().next().unwrap());
    assert!(last.iter().all(|meters| (meters - YARD.object_meters()).abs() < 1.0), "{told}");
    assert!(told.contains("/dragnet/belief "), "{told}");

    assert_eq!(without_computing(&told), without_computing(&place.succeed()));
    let mut left: Vec<_> = fs::read_dir(place.folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    left.sort();
    assert_eq!(left, ["drive", "test_site.toml", "vehicle.toml"], "nothing is written");
}

/// What is refused far behind the network is counted with the topic that it came on.
#[test]
fn frames_that_cannot_be_used_are_counted_whatever_the_reason() {
    let told = Place::new(&settings("detections", ""), &["stamps"]).succeed();
    let row = |topic: &str| -> Vec<u32> {
        let row = told.lines().find(|line| line.trim_start().starts_with(topic)).unwrap();
        row.split_whitespace().filter_map(|word| word.parse().ok()).collect()
    };
    // Without poses for three seconds.
    assert_eq!(row("/camera_0/detections"), [236, 30], "{told}");
    for camera in ["camera_1", "camera_2"] {
        // Those of the first seconds are not too old yet.
        let [messages, refused] = row(&format!("/{camera}/detections"))[..] else { panic!("{told}") };
        assert!(messages == 236 && refused > 180, "{told}");
    }
    let advice = "set `stamps = \"arrival\"` if this computer's clock should count";
    let refused = "refused on /camera_1/detections, the last: stamped 20.0 s before this computer's clock";
    assert!(told.contains(&format!("{refused}; {advice}\n")), "{told}");
    let refused = "refused on /camera_2/detections, the last: stamps stand still";
    assert!(told.contains(&format!("{refused}; {advice}\n")), "{told}");
    // Each is one fault, told once; so is that no frame of it can be used.
    for (camera, level) in [("camera_1", "error"), ("camera_2", "error")] {
        let silence = format!("silence of {camera}: no frame comes that can be used");
        assert_eq!(lines(&told, level).iter().filter(|line| **line == silence).count(), 1, "{told}");
        let count = lines(&told, "warning")
            .iter()
            .filter(|line| line.starts_with(&format!("camera {camera}: ")))
            .count();
        assert!((1..=2).contains(&count), "{told}");
    }
}

#[test]
fn a_recording_that_is_cut_off_or_none_is_told() {
    let place = Place::new(&settings("detections", ""), &[]);
    let bytes = fs::read(place.bag()).unwrap();
    let cut = place.folder.path().join("cut.mcap");
    // Whatever is whole counts: of the first chunk, all.
    fs::write(&cut, &bytes[..bytes.len() - 40]).unwrap();
    let output = place.dry_run(&cut);
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && told.contains("the recording was cut off"), "{told}");
    assert!(told.contains("found: [3, 3] at ("), "{told}");

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
    refuse(&place.folder.path().join("empty"), "empty: not a recording: a folder with 0 recordings");
    let bare = "robot = 1\n[common]\nmission = \"test_site\"\nscenario = \"test_site.toml\"\n";
    fs::write(place.folder.path().join("vehicle.toml"), bare).unwrap();
    refuse(&place.bag(), "[vehicle] and [ros]");
}

/// A robot with a detector of its own looks at the images themselves.
#[cfg(feature = "detector")]
#[test]
fn a_detector_looks_at_recorded_images() {
    let detector = "detector = { module = \"modules/red.torchscript\" }\n";
    let place = Place::new(&settings("image", detector), &["images"]);
    let modules = place.folder.path().join("modules");
    fs::create_dir(&modules).unwrap();
    let script = Path::new(ROOT).join("tests/python/modules.py");
    let made = Command::new(interpreter(Path::new(ROOT))).arg(script).arg(&modules).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let told = place.succeed();
    let found = where_found(lines(&told, "finds")[0]);
    assert_eq!(lines(&told, "finds").len(), 1, "{told}");
    assert!(found.iter().all(|meters| (meters - YARD.object_meters()).abs() < 5.0), "{told}");
    assert!(told.contains("/camera_2/image"), "{told}");

    // Of another size than the camera's the boxes would mean something else.
    let wrong = settings("image", detector).replace("width_pixels = 192", "width_pixels = 384");
    fs::write(place.folder.path().join("vehicle.toml"), wrong).unwrap();
    let told = place.succeed();
    let reason = "an image of 192 x 128 pixels; allowed is 384 x 128, as in vehicle.cameras";
    assert!(lines(&told, "warning").contains(&format!("image, camera_0: {reason}").as_str()), "{told}");
    assert!(lines(&told, "finds").is_empty(), "{told}");
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
    refuse(&settings("image", ""), "for which a [detector] is needed");
    refuse(&settings("detections", detector), "[detector] has nothing to look at");
    let both = settings("image", detector).replace("image = ", "detections = \"seen\"\nimage = ");
    refuse(&both, "allowed is one of the two");
    let absent = if cfg!(feature = "detector") { "red.torchscript: cannot read it" } else { "built without" };
    refuse(&settings("image", detector), absent);
}
