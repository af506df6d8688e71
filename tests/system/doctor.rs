//! `dragnet doctor`: its findings with missing parts, and with all of them.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use dragnet_proto::clock::Kept;
use dragnet_proto::convert::Codec;
use dragnet_proto::message::{Audience, Intent, Message};
use dragnet_ros2::cdr;
use dragnet_ros2::wire::robot::{Odometry, PoseWithCovarianceStamped};
use dragnet_ros2::wire::standard::{Header, MapMetaData, OccupancyGrid};
use dragnet_runtime::journal::{Journal, Subject};
use dragnet_runtime::link::Link;
use dragnet_runtime::session::{Endpoints, Mode, free_endpoints, open};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::RobotId;

use crate::field::{DRAGNET, Field, Process};
use crate::{eventually, scenario};

const TEAM: &str = "name = \"field\"\n[map]\nshape = \"all_traversable\"\nrows = 8\ncolumns = 8\n[objects]\ncount = 1\n\
                    [robots]\ncount = 2\npolicy = \"path\"\n[mission]\nbudget_seconds = 3600.0\n";

/// Its output, a line for each finding, and whether all checks pass.
fn examine(file: &Path, seconds: u32) -> (String, bool) {
    let output = Command::new(DRAGNET)
        .args(["doctor", "--listen", &seconds.to_string(), "--config"])
        .arg(file)
        .output()
        .unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.code().is_some_and(|code| code < 2), "{}", String::from_utf8_lossy(&output.stderr));
    (said, output.status.success())
}

fn check(said: &str, expected: &[&str]) {
    for line in expected {
        assert!(said.contains(line), "{line} is not in\n{said}");
    }
}

#[test]
fn a_robot_whose_team_is_there_may_go() {
    let field = Field::new(TEAM, 2, 1);
    let settings = field.robot_settings(1, None);
    let (said, will_do) = examine(&settings, 1);
    assert!(!will_do);
    check(
        &said,
        &[
            "pass  settings: robot 1 of 2",
            "pass  journal: ",
            "pass  decisions: path",
            "FAIL  team: no participant",
        ],
    );
    let _mate = field.robot(2);
    let _coordinator = field.coordinator();
    // They join once they have started.
    let (said, _) = std::iter::repeat_with(|| examine(&settings, 3)).find(|(_, will_do)| *will_do).unwrap();
    check(&said, &["pass  team: 2 of the mission", "robot 2, the coordinator"]);
}

/// For one robot that is slower than its vehicle.
fn alone() -> String {
    let text = TEAM.replace("count = 2", "count = 1");
    text.replace("[mission]\n", "[mission]\nspeed_meters_per_second = 1.0\n")
}

/// Settings of a robot of the team in a folder, with these endpoints.
fn robot_settings(folder: &Path, robot: u16, listen: &str, connect: &str) -> std::path::PathBuf {
    std::fs::write(folder.join("field.toml"), TEAM).unwrap();
    let file = folder.join("robot.toml");
    let settings = format!(
        "robot = {robot}\n[common]\nmission = \"field\"\nscenario = \"field.toml\"\n\
         zenoh = {{ listen = [{listen:?}], connect = [{connect:?}] }}\n"
    );
    std::fs::write(&file, settings).unwrap();
    file
}

#[test]
fn a_robot_that_can_meet_nobody_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("field.toml"), alone()).unwrap();
    let file = folder.path().join("robot.toml");
    std::fs::write(&file, "robot = 1\n[common]\nmission = \"field\"\nscenario = \"field.toml\"\n").unwrap();
    let (said, _) = examine(&file, 1);
    check(
        &said,
        &[
            "WARN  network: it listens nowhere, connects to nobody",
            "      under zenoh write listen = [\"tcp/",
        ],
    );
}

#[test]
fn a_port_that_is_taken_and_an_address_of_another_computer_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let endpoint = free_endpoints(1).unwrap().remove(0);
    let (said, _) = examine(&robot_settings(folder.path(), 1, &endpoint, "tcp/127.0.0.1:9"), 1);
    check(&said, &[&format!("pass  port {endpoint}: ")]);
    let other = std::net::TcpListener::bind(endpoint.trim_start_matches("tcp/")).unwrap();
    let (said, will_do) = examine(&robot_settings(folder.path(), 1, &endpoint, "tcp/127.0.0.1:9"), 1);
    assert!(!will_do);
    check(&said, &[&format!("FAIL  port {endpoint}: another process"), "FAIL  team: no participant"]);
    drop(other);
    let (said, will_do) =
        examine(&robot_settings(folder.path(), 1, "tcp/192.0.2.7:7140", "tcp/127.0.0.1:9"), 1);
    assert!(!will_do);
    check(&said, &["FAIL  port tcp/192.0.2.7:7140: "]);
}

#[test]
fn another_robots_number_is_reported_and_the_own_one_is_not() {
    let field = Field::new(TEAM, 2, 1);
    let settings = field.robot_settings(1, None);
    let robot = field.robot(1);
    let calls = field.endpoints(2).listen.remove(0);
    eventually("the robot listens", || {
        std::net::TcpStream::connect(calls.trim_start_matches("tcp/")).is_ok()
    });
    // The robot runs, and has its journal and its port.
    let own = "it is taken, as by this robot itself";
    let mut said = String::new();
    eventually("it has its journal", || {
        said = examine(&settings, 1).0;
        said.contains(own)
    });
    assert!(!said.contains("number") && !said.contains("FAIL  port"), "{said}");
    // On another computer, by copied settings.
    let folder = tempfile::tempdir().unwrap();
    let (said, will_do) = examine(&robot_settings(folder.path(), 1, "tcp/127.0.0.1:0", &calls), 3);
    assert!(!will_do);
    check(&said, &["FAIL  number: a robot 1"]);
    let (said, _) = examine(&robot_settings(folder.path(), 2, "tcp/127.0.0.1:0", &calls), 3);
    assert!(!said.contains("number"), "{said}");
    check(&said, &["pass  team: 1 of the mission"]);
    robot.terminate();
}

/// Processes with these robots' numbers, in one session that listens there.
async fn robots(listen: &str, numbers: &[u16]) -> Vec<Link> {
    let session = open(&Endpoints { listen: vec![listen.to_owned()], ..Endpoints::default() }).await.unwrap();
    let codec = Codec::new(scenario(TEAM).terrain().grid());
    let mut links = Vec::new();
    for &number in numbers {
        let participant = Participant::Robot(RobotId::new(number).unwrap());
        let mut link =
            Link::join(session.clone(), "field".parse().unwrap(), participant, codec.clone()).await.unwrap();
        link.announce().await.unwrap();
        links.push(link);
    }
    links
}

async fn examine_aside(file: &Path) -> (String, bool) {
    let file = file.to_owned();
    tokio::task::spawn_blocking(move || examine(&file, 3)).await.unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn two_of_one_number_are_reported_for_the_own_and_for_other_numbers() {
    let folder = tempfile::tempdir().unwrap();
    for (numbers, expected) in
        [([2, 2], "FAIL  team: robot 2"), ([1, 1], "FAIL  number: 2 robots have number 1")]
    {
        let endpoint = free_endpoints(1).unwrap().remove(0);
        let file = robot_settings(folder.path(), 1, "tcp/127.0.0.1:0", &endpoint);
        let both = robots(&endpoint, &numbers).await;
        let (said, will_do) = examine_aside(&file).await;
        assert!(!will_do);
        check(&said, &[expected]);
        drop(both);
        let one = robots(&endpoint, &numbers[..1]).await;
        let (said, _) = examine_aside(&file).await;
        assert!(!said.contains("twice") && !said.contains("2 robots have"), "{said}");
        drop(one);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_journal_ahead_of_the_only_participant_is_reported_and_not_changed() {
    let folder = tempfile::tempdir().unwrap();
    let endpoint = free_endpoints(1).unwrap().remove(0);
    let file = robot_settings(folder.path(), 1, "tcp/127.0.0.1:0", &endpoint);
    let mate = robots(&endpoint, &[2]).await.remove(0);
    let speaking = tokio::spawn(async move {
        let started = Instant::now();
        loop {
            let time_ns = (MissionTime::START + Duration::from_secs(500) + started.elapsed()).0;
            let intent = Intent {
                robot: RobotId::new(2).unwrap(),
                incarnation: 0,
                decision: 1,
                time_ns,
                path: Vec::new().into(),
            };
            mate.publish(1, Audience::All, &Message::Intent(intent)).await.unwrap();
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    });
    let (said, will_do) = examine_aside(&file).await;
    assert!(will_do, "{said}");
    check(&said, &["pass  clocks: the mission is 5", "by the clock of robot 2"]);
    let scenario = scenario(TEAM);
    let journal = folder.path().join("field-robot-1.journal");
    for (seconds, expected) in [(9000, "FAIL  clocks: "), (100, "pass  clocks: ")] {
        let mission = "field".parse().unwrap();
        let subject = Subject { mission: &mission, robot: RobotId::FIRST, terrain: scenario.terrain() };
        let (mut kept, _) = Journal::open(&journal, subject, 0).unwrap();
        // Of a computer that was off since, so that no time has passed.
        let time = MissionTime::START + Duration::from_secs(seconds);
        kept.note_time(Kept { boot: "another".to_owned(), uptime: Duration::ZERO, time });
        kept.commit();
        drop(kept);
        let before = std::fs::read(&journal).unwrap();
        let (said, will_do) = examine_aside(&file).await;
        assert_eq!(will_do, seconds == 100, "{said}");
        // It may be a second older when it is told.
        let found = format!("{expected}by the journal of robot 1 the mission is {}", seconds / 10);
        check(&said, &[&found, "s old, by the clock of robot 2 5"]);
        assert_eq!(std::fs::read(&journal).unwrap(), before);
    }
    speaking.abort();
}

/// A copy of the scenario that was changed.
#[test]
fn a_robot_with_another_scenario_is_reported_by_the_doctor_and_by_all_logs() {
    let field = Field::new(TEAM, 2, 1);
    let threshold = "[mission]\ndetection_threshold = 0.9\n";
    std::fs::write(field.path("other.toml"), TEAM.replace("[mission]\n", threshold)).unwrap();
    let settings = field.robot_settings(2, None);
    let text = std::fs::read_to_string(&settings).unwrap();
    std::fs::write(&settings, text.replace("\"field.toml\"", "\"other.toml\"")).unwrap();
    let log = |name: &str| field.path(&format!("{name}.log"));
    let start = |name: &str, verb: &str, settings: &Path| {
        Process::start_logged(Command::new(DRAGNET).args([verb, "--config"]).arg(settings), &log(name))
    };
    let coordinator = field.coordinator_settings(&field.path("field.mcap"));
    let _coordinator = start("coordinator", "coordinator", &coordinator);
    let _robot = start("robot", "agent", &settings);
    let what = "another detection threshold or rate of radios";
    for (name, expected) in [
        ("coordinator", format!("robot 2 has another scenario than the coordinator: {what}; give")),
        ("robot", format!("the coordinator has another scenario than robot 2: {what}; give")),
    ] {
        let told = || std::fs::read_to_string(log(name)).unwrap().matches(&expected).count();
        eventually("the log tells it", || told() > 0);
        assert_eq!(told(), 1);
    }
    let (said, will_do) = examine(&field.robot_settings(1, None), 3);
    assert!(!will_do);
    check(&said, &[&format!("FAIL  team: robot 2 has another scenario than these settings: {what}")]);
    assert_eq!(said.matches("another scenario").count(), 1, "{said}");
    let (said, _) = examine(&settings, 3);
    check(&said, &["FAIL  team: the coordinator has another scenario than these settings"]);
}

/// The doctor predicts what a robot does with its journal when it starts, and changes nothing.
#[test]
fn a_journal_that_the_robot_would_reject_fails_and_a_damaged_one_is_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let file = robot_settings(folder.path(), 1, "tcp/127.0.0.1:0", "tcp/127.0.0.1:9");
    let path = folder.path().join("field-robot-1.journal");
    let subject = |mission| (RobotId::FIRST, mission, scenario(TEAM));
    let write = |(robot, mission, scenario): (RobotId, &str, Scenario)| {
        let mission = mission.parse().unwrap();
        let subject = Subject { mission: &mission, robot, terrain: scenario.terrain() };
        drop(Journal::open(&path, subject, 0).unwrap());
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        bytes
    };
    let own = write(subject("field"));
    let damaged = [&[0; 4096], &own[4096..]].concat();
    let (other, cut) = (write(subject("other")), own[..100].to_vec());
    let letter = b"a letter to somebody, which is no journal at all".to_vec();
    for (bytes, expected) in [
        (own, "pass  journal: "),
        (damaged, "WARN  journal: "),
        (cut, "WARN  journal: "),
        (other, "FAIL  journal: "),
        (letter, "FAIL  journal: "),
    ] {
        std::fs::write(&path, &bytes).unwrap();
        let (said, _) = examine(&file, 1);
        check(&said, &[expected]);
        assert_eq!(said.matches("  journal: ").count(), 1, "{said}");
        assert_eq!(std::fs::read(&path).unwrap(), bytes);
    }
    std::fs::remove_file(&path).unwrap();
    std::fs::create_dir(&path).unwrap();
    check(&examine(&file, 1).0, &["FAIL  journal: ", "no plain file"]);
}

/// Edge of the scenario's cells, meters.
const CELL_METERS: f32 = 10.0;

/// A map of the scenario's ground, shifted to the east.
fn map(east_meters: f64) -> OccupancyGrid {
    let header = Header { frame_id: "map".to_owned(), ..Header::default() };
    let mut info = MapMetaData { resolution: CELL_METERS, width: 8, height: 8, ..MapMetaData::default() };
    info.origin.position.x = east_meters;
    info.origin.orientation.w = 1.0;
    OccupancyGrid { header, info, data: vec![0; 64] }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_different_map_is_reported_and_unused_topics_are_not_required() {
    let folder = tempfile::tempdir().unwrap();
    let endpoint = free_endpoints(1).unwrap().remove(0);
    let scenario = alone().replace("columns = 8\n", &format!("columns = 8\ncell_meters = {CELL_METERS:?}\n"));
    std::fs::write(folder.path().join("test_site.toml"), scenario).unwrap();
    let file = folder.path().join("robot.toml");
    let settings = format!(
        "robot = 1\n[common]\nmission = \"test_site\"\nscenario = \"test_site.toml\"\n[vehicle]\nmotion = {{ kind = \"goal\" }}\n\
         [ros]\ntransport = \"bridge\"\nzenoh.connect = [{endpoint:?}]\n"
    );
    std::fs::write(&file, settings).unwrap();
    let bridge = Endpoints { listen: vec![endpoint], mode: Some(Mode::Router), ..Endpoints::default() };
    let session = open(&bridge).await.unwrap();
    let mut pose =
        PoseWithCovarianceStamped { header: map(0.0).header, ..PoseWithCovarianceStamped::default() };
    pose.pose.pose.position.x = 25.0;
    pose.pose.pose.position.y = 15.0;
    pose.pose.pose.orientation.w = 1.0;
    for (east_meters, expected) in [(0.0, "pass  map: "), (30.0, "FAIL  map: ")] {
        let (session, pose) = (session.clone(), pose.clone());
        let publishing = tokio::spawn(async move {
            loop {
                session.put("map", cdr::encode(&map(east_meters))).await.unwrap();
                session.put("amcl_pose", cdr::encode(&pose)).await.unwrap();
                tokio::time::sleep(std::time::Duration::from_millis(100)).await;
            }
        });
        let examined = file.clone();
        let (said, _) = tokio::task::spawn_blocking(move || examine(&examined, 3)).await.unwrap();
        publishing.abort();
        check(&said, &[expected, "pass  place: ", "[1, 2]", "FAIL  /odom: 0 messages"]);
        check(&said, &["pass  /navigate_to_pose/_action/status: 0 messages"]);
        assert!(!said.contains("/fix"), "{said}");
        let outside = if east_meters > 0.0 { 24 } else { 0 };
        check(&said, &[&format!("of 64 cells that are free in the scenario {outside} ")]);
    }
}

#[test]
fn invalid_settings_are_the_only_finding() {
    let field = Field::new(TEAM, 2, 1);
    let settings = field.robot_settings(2, None);
    let text = std::fs::read_to_string(&settings).unwrap();
    std::fs::write(&settings, text.replace("robot = 2", "robot = 7")).unwrap();
    let (said, will_do) = examine(&settings, 1);
    assert!(!will_do && said.lines().count() == 2, "{said}");
    check(&said, &["FAIL  settings: robot is 7"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn each_topic_of_a_vehicle_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let endpoint = free_endpoints(1).unwrap().remove(0);
    std::fs::write(folder.path().join("test_site.toml"), alone()).unwrap();
    let file = folder.path().join("robot.toml");
    let settings = format!(
        "robot = 1\n[common]\nmission = \"test_site\"\nscenario = \"test_site.toml\"\n[vehicle]\n[ros]\ntransport = \"bridge\"\n\
         localization = \"odometry\"\nzenoh.connect = [{endpoint:?}]\nsubscribe = {{ pose = \"\", fix = \"\", map = \"\", goals = \"\" }}\n\
         cameras = [{{ name = \"wide\", detections = \"seen\" }}]\n"
    );
    std::fs::write(&file, settings).unwrap();
    let (said, _) = examine(&file, 1);
    check(&said, &["pass  team: it searches alone", "FAIL  vehicle: no router"]);
    let bridge = Endpoints { listen: vec![endpoint], mode: Some(Mode::Router), ..Endpoints::default() };
    let session = open(&bridge).await.unwrap();
    let _follower = session.declare_subscriber("dragnet/path").await.unwrap();
    let publishing = tokio::spawn(async move {
        // As of a clock that was never set.
        let header = Header { frame_id: "odom".to_owned(), ..Header::default() };
        let mut odometry = Odometry { header, child_frame_id: "base_link".to_owned(), ..Odometry::default() };
        odometry.pose.pose.orientation.w = 1.0;
        loop {
            session.put("odom", cdr::encode(&odometry)).await.unwrap();
            session.put("seen", b"nothing".as_slice()).await.unwrap();
            tokio::time::sleep(std::time::Duration::from_millis(20)).await;
        }
    });
    let (said, will_do) = tokio::task::spawn_blocking(move || examine(&file, 2)).await.unwrap();
    publishing.abort();
    assert!(!will_do);
    check(
        &said,
        &[
            "FAIL  /odom: ",
            "before this computer's clock",
            "FAIL  camera narrow: ros.cameras",
            "FAIL  speed: the vehicle drives 2 m/s",
            "FAIL  /seen: ",
            "not the bytes",
            "pass  path: ",
        ],
    );
}
