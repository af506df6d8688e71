//! A robot behind an autopilot: `dragnet agent` as a process, and an autopilot by pymavlink.

use std::io::{BufRead, BufReader, Read};
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use dragnet_runtime::session::free_endpoints;

use crate::field::{DRAGNET, Process};
use crate::interpreter::interpreter;

const SIDE: u32 = 6;
const CELL_METERS: f64 = 20.0;
const CORNER_DEGREES: [f64; 2] = [47.5, 9.5];

fn scenario() -> String {
    let [latitude, longitude] = CORNER_DEGREES;
    format!(
        "name = \"site\"\n[map]\nshape = \"all_traversable\"\nrows = {SIDE}\ncolumns = {SIDE}\ncell_meters = {CELL_METERS:?}\n\
         origin = {{ latitude_degrees = {latitude:?}, longitude_degrees = {longitude:?} }}\n[objects]\ncount = 1\n[sensor]\n\
         radius = 2\n[robots]\ncount = 1\npolicy = \"path\"\n[mission]\nbudget_seconds = 36000.0\n\
         speed_meters_per_second = 20.0\nstop_when_expected_remaining = 0.005\n"
    )
}

/// Settings of a robot, with the ports of its autopilot and its detectors.
fn settings(team: &str, [autopilot, detections]: [u16; 2]) -> String {
    let cameras = [0.0, 120.0, -120.0].iter().enumerate().map(|(number, yaw)| {
        format!(
            "[[vehicle.cameras]]\nname = \"camera_{number}\"\nwidth_pixels = 1000\nheight_pixels = 600\n\
             field_of_view_degrees = 125.0\nyaw_degrees = {yaw:?}\nmin_range_meters = 0.5\nmax_range_meters = 35.0\n"
        )
    });
    format!(
        "robot = 1\n[common]\nmission = \"site\"\nscenario = \"site.toml\"\nzenoh = {{ listen = [{team:?}] }}\n\
         [vehicle]\nspeed_meters_per_second = 20.0\nfootprint = {{ shape = \"disc\", radius_meters = 0.5 }}\n\
         motion = {{ kind = \"goal\" }}\n{}[mavlink]\nconnection = \"udpin:127.0.0.1:{autopilot}\"\n\
         detections = {{ listen = \"127.0.0.1:{detections}\" }}\n",
        cameras.collect::<String>()
    )
}

fn free_port() -> u16 {
    UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// Writes scenario and settings into a folder; returns the file of the settings, and the ports.
fn site(folder: &Path) -> (PathBuf, [u16; 2]) {
    let ports = [free_port(), free_port()];
    std::fs::write(folder.join("site.toml"), scenario()).unwrap();
    let file = folder.join("robot.toml");
    std::fs::write(&file, settings(&free_endpoints(1).unwrap()[0], ports)).unwrap();
    (file, ports)
}

#[test]
fn a_robot_steers_an_autopilot_until_the_search_is_done_and_yields_whenever_it_must() {
    let folder = tempfile::tempdir().unwrap();
    let (file, [autopilot_port, detections_port]) = site(folder.path());
    let log = folder.path().join("log");
    let robot = Process::start_logged(Command::new(DRAGNET).args(["agent", "--config"]).arg(&file), &log);
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR"));
    // In the corner of the map, which is searched last.
    let object_meters = (f64::from(SIDE) - 0.5) * CELL_METERS;
    let numbers = [CORNER_DEGREES[0], CORNER_DEGREES[1], object_meters, object_meters, 0.2];
    let mut autopilot = Command::new(interpreter(workspace))
        .arg(workspace.join("tests/python/autopilot.py"))
        .args([autopilot_port.to_string(), detections_port.to_string()])
        .args(numbers.map(|number| number.to_string()))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(autopilot.stdout.take().unwrap());
    let said = || std::fs::read_to_string(&log).unwrap();
    let mut played = String::new();
    while !played.contains("the rest is the robot's") {
        assert!(lines.read_line(&mut played).unwrap() > 0, "{played}\n{}", said());
    }
    assert_eq!(played.lines().count(), 7, "{played}");
    for stretch in 0.. {
        let said = said();
        if said.contains("robot 1 found: an object at") && said.contains("robot 1 resting") {
            break;
        }
        assert!(stretch < 3000, "the search is not done: {said}");
        std::thread::sleep(Duration::from_millis(100));
    }
    drop(autopilot.stdin.take());
    let mut rest = String::new();
    lines.read_to_string(&mut rest).unwrap();
    assert!(autopilot.wait().unwrap().success(), "{rest}");
    eprintln!("{rest}");
    robot.terminate();
    let said = said();
    for reason in [
        "control: the vehicle is not the robot's: mode MANUAL",
        "mode RTL",
        "the autopilot has started again",
        "breach of its fence: FENCE_BREACH_BOUNDARY",
        "battery: the battery is at",
    ] {
        assert!(said.contains(reason), "{reason}: {said}");
    }
}

#[test]
fn settings_of_an_autopilot_that_do_not_match_are_reported_with_their_key() {
    let folder = tempfile::tempdir().unwrap();
    let (file, ports) = site(folder.path());
    let good = settings("tcp/127.0.0.1:0", ports);
    let check = |from: &str, to: &str, reason: &str| {
        assert!(good.contains(from), "{from}");
        std::fs::write(&file, good.replace(from, to)).unwrap();
        let output = Command::new(DRAGNET).args(["agent", "--config"]).arg(&file).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && said.contains("robot.toml") && said.contains(reason), "{said}");
    };
    check("kind = \"goal\"", "kind = \"lattice\"", "allowed is 'goal'");
    check(
        "[mavlink]\n",
        "[ros]\ntransport = \"bridge\"\n[mavlink]\n",
        "[ros] and [mavlink]: allowed is one of the two",
    );
    check("connection = \"udpin", "connection = \"serial", "mavlink.connection is \"serial");
    check("[mavlink]\n", "[detector]\nmodule = \"a.pt\"\n[mavlink]\n", "mavlink.detections.listen");
    check("[mavlink]\n", "[mavlink]\nmax_distance_meters = -1.0\n", "mavlink.max_distance_meters is -1");
    let without =
        scenario().lines().filter(|line| !line.starts_with("origin")).collect::<Vec<_>>().join("\n");
    std::fs::write(folder.path().join("site.toml"), without).unwrap();
    check("[mavlink]\n", "[mavlink]\nposition = \"global\"\n", "needs a map with an origin");
}
