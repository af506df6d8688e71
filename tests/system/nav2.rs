//! A robot on the network of one that drives with Nav2: its pose, its cameras' mounting and their optics are those that the
//! network says. The network is `tests/python/nav2_robot.py`, by eclipse-zenoh and rosbags.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use dragnet_runtime::session::{Endpoints, Mode, free_endpoints, open};
use serde_json::Value;

use crate::field::{DRAGNET, Process};
use crate::interpreter::interpreter;
use crate::mentions::assert_mentions;
use crate::test_site::TestSite;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const YARD: TestSite = TestSite { side: 4, cell_meters: 20.0, policy: "'path'" };
/// Longer than any of the steps takes.
const PATIENCE: Duration = Duration::from_mins(2);

/// Neither a topic of poses, nor mounting, nor optics.
fn settings(team: &str, router: &str) -> String {
    format!(
        "robot = 1\n[common]\nmission = \"test_site\"\nscenario = \"test_site.toml\"\nzenoh = {{ listen = [{team:?}] }}\n\
         [vehicle]\nspeed_meters_per_second = 20.0\nfootprint = {{ shape = \"disc\", radius_meters = 0.5 }}\n\
         motion = {{ kind = \"goal\" }}\n\
         cameras = [{{ name = \"front\", max_range_meters = 60.0 }}, {{ name = \"rear\", max_range_meters = 60.0 }}]\n\
         safety = {{ recovery_seconds = 1.0 }}\n\
         [ros]\ntransport = \"rmw_zenoh\"\nlocalization = \"tf\"\nzenoh = {{ connect = [{router:?}] }}\n\
         emergency_stop = {{ topic = \"e_stop\", timeout_seconds = 2.0 }}\nbattery = {{ topic = \"battery_state\", on_low = \"home\" }}\n\
         [[ros.cameras]]\nname = \"front\"\ndetections = \"front/detections\"\ncamera_info = \"front/camera_info\"\n\
         [[ros.cameras]]\nname = \"rear\"\ndetections = \"rear/detections\"\ncamera_info = \"rear/camera_info\"\n"
    )
}

/// The network of a robot, and the settings of Dragnet's.
struct Site {
    folder: tempfile::TempDir,
    peer: Child,
    input: ChildStdin,
    lines: Receiver<Value>,
    /// The last diagnostics, by subject: level and message.
    diagnostics: BTreeMap<String, (u64, String)>,
    _router: zenoh::Session,
}

impl Site {
    async fn new(options: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let endpoints = free_endpoints(2).unwrap();
        std::fs::write(folder.path().join("test_site.toml"), YARD.scenario()).unwrap();
        std::fs::write(folder.path().join("vehicle.toml"), settings(&endpoints[0], &endpoints[1])).unwrap();
        // In the place of `rmw_zenohd`.
        let router = Endpoints {
            listen: vec![endpoints[1].clone()],
            mode: Some(Mode::Router),
            ..Endpoints::default()
        };
        let router = open(&router).await.unwrap();
        let mut peer = Command::new(interpreter(Path::new(ROOT)))
            .arg(Path::new(ROOT).join("tests/python/nav2_robot.py"))
            .arg(&endpoints[1])
            .args(options)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (input, output) = (peer.stdin.take().unwrap(), peer.stdout.take().unwrap());
        let diagnostics = BTreeMap::new();
        let site = Self { folder, peer, input, lines: read(output), diagnostics, _router: router };
        let first = site.lines.recv_timeout(PATIENCE);
        assert!(first.as_ref().is_ok_and(|line| line["ready"] == true), "{first:?}: see tests/python");
        site
    }

    fn settings(&self) -> PathBuf {
        self.folder.path().join("vehicle.toml")
    }

    fn start_robot(&self) -> Process {
        let mut agent = Command::new(DRAGNET);
        Process::start_logged(agent.args(["agent", "--config"]).arg(self.settings()), &self.log())
    }

    fn log(&self) -> PathBuf {
        self.folder.path().join("agent.log")
    }

    fn wait_for_log(&self, words: &str) {
        let end = Instant::now() + PATIENCE;
        while !std::fs::read_to_string(self.log()).is_ok_and(|log| log.contains(words)) {
            assert!(Instant::now() < end, "in vain for {words}");
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    fn doctor(&self) -> String {
        let output = Command::new(DRAGNET)
            .args(["doctor", "--listen", "3", "--config"])
            .arg(self.settings())
            .output()
            .unwrap();
        String::from_utf8(output.stdout).unwrap()
    }

    fn order(&mut self, line: &str) {
        writeln!(self.input, "{line}").unwrap();
    }

    /// The next line of a kind for which this is so. Diagnostics are kept.
    fn wait(&mut self, kind: &str, is_so: impl Fn(&Value) -> bool) -> Value {
        let end = Instant::now() + PATIENCE;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let line = self.lines.recv_timeout(left);
            let Ok(line) = line else { panic!("in vain for {kind}: {:?}", self.diagnostics) };
            if let Some(Value::Object(status)) = line.get("diagnostics") {
                self.diagnostics = status
                    .iter()
                    .map(|(name, status)| {
                        let message = status[1].as_str().unwrap().to_owned();
                        (name.clone(), (status[0].as_u64().unwrap(), message))
                    })
                    .collect();
            }
            if let Some(value) = line.get(kind).filter(|value| is_so(value)) {
                return value.clone();
            }
        }
    }

    /// Waits for a diagnostic of a level, with these words.
    fn wait_for_diagnostic(&mut self, subject: &str, level: u64, words: &str) {
        let name = subject.to_owned();
        self.wait("diagnostics", |status| {
            let status = &status[&name];
            status[0] == level && status[1].as_str().is_some_and(|message| message.contains(words))
        });
    }

    /// The battery has these charges one after the other, percent.
    fn charge<const N: usize>(&mut self, percent: [u32; N]) {
        for percent in percent {
            self.order(&format!("charge {}", f64::from(percent) / 100.0));
            let shown = format!("{percent} %");
            self.wait("diagnostics", |status| status["charge"][1] == shown.as_str());
        }
    }

    fn wait_for_goal(&mut self) {
        self.wait("goal", |_| true);
    }

    /// Declared objects, at least one.
    fn wait_for_objects(&mut self) -> Value {
        self.wait("objects", |objects| objects.as_array().is_some_and(|found| !found.is_empty()))
    }
}

impl Drop for Site {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.peer.kill();
        let _ = self.peer.wait();
    }
}

fn read(output: ChildStdout) -> Receiver<Value> {
    let (sender, lines) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(output).lines().map_while(Result::ok) {
            if sender.send(serde_json::from_str(&line).unwrap()).is_err() {
                break;
            }
        }
    });
    lines
}

#[tokio::test(flavor = "multi_thread")]
async fn a_robot_on_the_network_of_nav2_finds_the_object() {
    let mut site = Site::new(&[]).await;
    let said = site.doctor();
    for finding in [
        "pass  /tf: ",
        "pass  /tf_static: ",
        "pass  /front/camera_info: ",
        "pass  /e_stop: ",
        "pass  /battery_state: ",
        "pass  pose: map -> odom -> base_link, ",
        "pass  camera front: 640 x 480 pixels, ",
        "0.40 m forward, 0.00 m left, 0.50 m up; it looks 17 degrees left of ahead and 3 degrees down",
        "-0.30 m forward, 0.10 m left, 0.60 m up; it looks -161 degrees left of ahead and 6 degrees down",
    ] {
        assert!(said.contains(finding), "{finding}: {said}");
    }
    assert!(!said.contains("/odom: ") && !said.contains("/amcl_pose"), "{said}");

    let robot = site.start_robot();
    site.wait_for_goal();
    site.wait_for_diagnostic("charge", 0, "75 %");
    // Stopped, it gets its own place as its goal; released, it goes on.
    site.order("stop true");
    site.wait_for_diagnostic("emergency stop", 2, "e_stop is true: the vehicle stands until it is false");
    site.order("stop false");
    site.wait_for_diagnostic("emergency stop", 0, "well again");
    site.wait_for_goal();

    let found = site.wait_for_objects();
    let [x, y, x_variance, y_variance, east, north] =
        [0, 1, 2, 3, 4, 5].map(|at| found[0][at].as_f64().unwrap());
    // The middle of its cell.
    assert!([east, north].iter().all(|meters| (meters - YARD.object_meters()).abs() < 1e-9), "{found}");
    for (place, variance) in [(x, x_variance), (y, y_variance)] {
        let off = (place - YARD.object_meters()).abs();
        assert!(variance > 0.0 && off < 3.0 * variance.sqrt() + 1.0, "{found}");
    }

    // A battery that fades sends it home, where it waits for a charged one; one that jumps is not believed.
    site.order("charge 0.05");
    site.wait_for_diagnostic("/battery_state", 1, "jumps from 75 to 5 %");
    site.charge([60, 45, 30, 15]);
    site.wait_for_diagnostic("battery", 1, "the battery is at 15 %; needed are 20 %");
    site.wait_for_log("returning to its base at [0, 0]");
    let is_in_base = |meters: &Value| (0.0..YARD.cell_meters).contains(&meters.as_f64().unwrap());
    site.wait("goal", |goal| is_in_base(&goal[0]) && is_in_base(&goal[1]));
    site.wait_for_log("resting: its budget or battery leaves no further step");
    site.charge([30, 45, 60, 75, 85]);
    site.wait_for_diagnostic("battery", 0, "well again");
    robot.terminate();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_robot_waits_for_what_its_network_does_not_say_yet() {
    let mut site = Site::new(&["late", "uncalibrated"]).await;
    let said = site.doctor();
    let lines: Vec<&str> = said.lines().collect();
    let finding = |begin: &str| *lines.iter().find(|line| line.starts_with(begin)).unwrap_or(&"");
    assert_mentions(finding("FAIL  /front/camera_info"), "k is all 0 .. not calibrated");
    assert_mentions(finding("FAIL  camera front"), "no valid camera_info");

    let robot = site.start_robot();
    site.wait_for_diagnostic("mounting of front", 1, "no valid camera_info has arrived");
    site.wait_for_diagnostic("/front/camera_info", 1, "not calibrated");
    site.wait_for_diagnostic("silence of front", 2, "no frame comes");
    site.order("calibrate");
    site.wait_for_diagnostic("mounting of front", 1, "no transform names the frame \"front_optical\"");
    site.order("mount");
    site.wait_for_diagnostic("mounting of rear", 0, "well again");
    site.wait_for_diagnostic("silence of front", 0, "well again");
    site.wait_for_goal();

    // Loops change nothing; without odometry the vehicle stands, and says which transform is old.
    site.order("loop");
    site.wait_for_diagnostic("/tf", 1, "a loop of frames: map -> base_link -> odom -> map");
    site.order("lose odom");
    site.wait_for_diagnostic("pose", 2, "the newest transform from \"odom\" to \"base_link\" is ");
    site.order("find odom");
    site.wait_for_diagnostic("pose", 0, "well again");
    site.wait_for_objects();
    robot.terminate();
}
