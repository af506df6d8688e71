//! A robot whose network is not there when it starts: it joins once the network is there.

use std::net::TcpListener;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use dragnet_proto::convert::Codec;
use dragnet_runtime::link::Link;
use dragnet_runtime::session::{Endpoints, free_endpoints, open};
use dragnet_scenario::participant::Participant;
use dragnet_search::observation::RobotId;

use crate::eventually;
use crate::field::{DRAGNET, Field, Process};

const ALONE: &str = "name = \"field\"\n[map]\nshape = \"all_traversable\"\nrows = 5\ncolumns = 5\n\
                     [objects]\ncount = 1\n[mission]\nbudget_seconds = 3600.0\n";

/// The settings of robot 1 with these endpoints.
fn settings(field: &Field, listen: &[String], connect: &[String]) -> PathBuf {
    listening(&field.robot_settings(1, None), listen, connect)
}

/// Settings of a process with other endpoints.
fn listening(file: &Path, listen: &[String], connect: &[String]) -> PathBuf {
    let text = std::fs::read_to_string(file).unwrap();
    let (common, _) = text.split_once("[common.zenoh]").unwrap();
    std::fs::write(file, format!("{common}[common.zenoh]\nlisten = {listen:?}\nconnect = {connect:?}\n"))
        .unwrap();
    file.to_owned()
}

fn agent(settings: &Path) -> Command {
    let mut command = Command::new(DRAGNET);
    command.args(["agent", "--config"]).arg(settings);
    command
}

#[tokio::test(flavor = "multi_thread")]
async fn a_robot_takes_part_once_its_network_is_there() {
    let field = Field::new(ALONE, 1, 1);
    // One address is not this computer's, and another process holds the port of the other.
    let endpoint = free_endpoints(1).unwrap().remove(0);
    let address = endpoint.trim_start_matches("tcp/");
    let holder = TcpListener::bind(address).unwrap();
    let listen = ["tcp/192.0.2.7:7447".to_owned(), endpoint.clone()];
    let manager = UnixDatagram::bind(field.path("manager")).unwrap();
    manager.set_read_timeout(Some(Duration::from_mins(1))).unwrap();
    let log = field.path("log");
    let file = settings(&field, &listen, &["tcp/nobody.invalid:7447".to_owned()]);
    let mut command = agent(&file);
    command.env("NOTIFY_SOCKET", field.path("manager")).stderr(std::fs::File::create(&log).unwrap());
    let robot = Process::start(&mut command);
    let mut words = [0; 256];
    let length = manager.recv(&mut words).unwrap();
    assert_eq!(&words[..length], b"READY=1\n", "{}", std::fs::read_to_string(&log).unwrap());
    for missing in &listen {
        let reported = format!("cannot listen yet, and tries again: {missing}");
        let is_told = || std::fs::read_to_string(&log).unwrap().contains(&reported);
        let waiting = async {
            while !is_told() {
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
        };
        let waited = tokio::time::timeout(Duration::from_mins(1), waiting).await;
        assert!(waited.is_ok(), "no {reported:?} in:\n{}", std::fs::read_to_string(&log).unwrap());
    }
    drop(holder);
    let session = open(&Endpoints { connect: vec![endpoint], ..Endpoints::default() }).await.unwrap();
    let codec = Codec::new(field.scenario().terrain().grid());
    let mut link =
        Link::join(session, "field".parse().unwrap(), Participant::Coordinator, codec).await.unwrap();
    link.wait_for(&[Participant::Robot(RobotId::FIRST)], Duration::from_mins(1), |_| ()).await.unwrap();
    robot.terminate();
}

#[test]
fn a_robot_and_a_coordinator_with_a_late_network_stop_on_request() {
    let field = Field::new(ALONE, 1, 1);
    let nowhere = ["tcp/192.0.2.7:7447".to_owned()];
    let robot = settings(&field, &nowhere, &[]);
    let coordinator = listening(&field.coordinator_settings(&field.path("field.mcap")), &nowhere, &[]);
    for (part, file) in [("agent", robot), ("coordinator", coordinator)] {
        for signal in ["TERM", "INT"] {
            let log = field.path("log");
            let said = || std::fs::read_to_string(&log).unwrap();
            let mut command = Command::new("env");
            command.args(["--default-signal=INT,TERM", DRAGNET, part, "--config"]).arg(&file);
            let process = Process::start_logged(&mut command, &log);
            eventually("it takes part", || said().contains("arrivals are logged"));
            assert!(process.signal(signal).success(), "{}", said());
            let said = said();
            assert!(said.contains("of mission field was asked to stop, and ends"), "{said}");
            // Zenoh gives up only after ten seconds, and says so.
            assert!(!said.contains("ERROR"), "{said}");
        }
    }
}

#[test]
fn an_impossible_endpoint_ends_a_robot_at_once() {
    let field = Field::new(ALONE, 1, 1);
    let check = |listen: &str, connect: &str, expected: &str| {
        let file = settings(&field, &[listen.to_owned()], &[connect.to_owned()]);
        let output = agent(&file).stdin(Stdio::null()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        // By this status the service manager knows that a person is needed.
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(expected), "{said}");
    };
    check("tpc/127.0.0.1:7447", "tcp/127.0.0.1:7448", "\"tpc/127.0.0.1:7447\"");
    check("tcp/127.0.0.1:0", "tcp/127.0.0.1", "allowed are those like 192.168.1.7:7447");
    let unit = concat!(env!("CARGO_MANIFEST_DIR"), "/deploy/dragnet-agent@.service");
    let unit = std::fs::read_to_string(unit).unwrap();
    for line in ["Restart=always", "RestartPreventExitStatus=2", "StartLimitIntervalSec=0"] {
        assert!(unit.lines().any(|it| it == line), "{line}");
    }
}
