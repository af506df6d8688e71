//! Access to a mission over mutual TLS: real sessions, real processes.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use dragnet_keys::folder::{Folder, SETTINGS};
use dragnet_keys::name::Name;
use dragnet_keys::register::Topology;
use dragnet_proto::convert::{self, Codec};
use dragnet_proto::message::{Audience, Intent, Message};
use dragnet_proto::sender::Envelope;
use dragnet_runtime::link::{Incoming, Link};
use dragnet_runtime::session::{Endpoints, free_endpoints, open};
use dragnet_scenario::participant::Participant;
use dragnet_search::cell::Grid;
use dragnet_search::observation::RobotId;
use serde_json::{Value, json};
use time::OffsetDateTime;

use crate::eventually;

const DRAGNET: &str = env!("CARGO_BIN_EXE_dragnet");
const PATIENCE: Duration = Duration::from_mins(1);
pub(crate) const NAMES: [Name; 4] =
    [Name::robot(1).unwrap(), Name::robot(2).unwrap(), Name::COORDINATOR, Name::Simulator];

/// A mission with certificates, on this computer.
pub(crate) struct Field {
    folder: tempfile::TempDir,
    pub(crate) endpoints: Vec<String>,
}

impl Field {
    pub(crate) fn new(topology: Topology) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let now = OffsetDateTime::now_utc();
        let mut keys =
            Folder::init(&folder.path().join("keys"), "field".parse().unwrap(), topology, now).unwrap();
        keys.add(&NAMES, &[], 1, now).unwrap();
        let scenario = "name = \"field\"\n[map]\nshape = \"all_traversable\"\nrows = 15\ncolumns = 15\n\
                        [objects]\ncount = 4\n[robots]\ncount = 2\npolicy = \"path\"\n\
                        [mission]\nbudget_seconds = 3600.0\nstop_when_expected_remaining = 0.001\n";
        fs::write(folder.path().join("field.toml"), scenario).unwrap();
        let endpoints = free_endpoints(NAMES.len() + 1).unwrap();
        let endpoints = endpoints.iter().map(|endpoint| endpoint.replace("tcp/", "tls/")).collect();
        Self { folder, endpoints }
    }

    fn keys(&self) -> Folder {
        Folder::open(&self.path("keys")).unwrap()
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn settings(&self, name: Name) -> PathBuf {
        self.keys().home(name).join(SETTINGS)
    }

    /// Changed settings of a participant, without its own access control.
    fn altered(&self, name: Name, change: impl Fn(&mut Value)) -> PathBuf {
        let text = fs::read_to_string(self.settings(name)).unwrap();
        let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with("//")).collect();
        let mut settings: Value = serde_json::from_str(&lines.join("\n")).unwrap();
        settings["access_control"] = json!({ "enabled": false });
        change(&mut settings["transport"]["link"]);
        let file = self.keys().home(name).join("altered.json5");
        fs::write(&file, settings.to_string()).unwrap();
        file
    }

    /// The process at this place of the mesh: it listens there, and connects to all before it.
    fn start(&self, name: Name, place: usize) -> Process {
        Process::start(&mut self.command(name, place))
    }

    pub(crate) fn command(&self, name: Name, place: usize) -> Command {
        let calls = &self.endpoints[..place];
        let zenoh = format!(
            "listen = [{:?}]\nconnect = {calls:?}\nconfig = \"{}\"\n",
            self.endpoints[place],
            self.settings(name).display()
        );
        let scenario = self.path("field.toml");
        let common = format!(
            "[common]\nmission = \"field\"\nscenario = \"{}\"\nseed = 3\nreal_time_factor = 100.0\n[common.zenoh]\n{zenoh}",
            scenario.display()
        );
        let (arguments, config) = match name {
            Name::Participant(Participant::Robot(robot)) => {
                (vec!["agent"], format!("robot = {robot}\n{common}"))
            }
            Name::Participant(Participant::Coordinator) => (vec!["coordinator"], common),
            Name::Simulator => {
                let config =
                    format!("mission = \"field\"\nseed = 3\nreal_time_factor = 100.0\n[zenoh]\n{zenoh}");
                (vec!["sim", scenario.to_str().unwrap(), "--json"], config)
            }
        };
        let file = self.path(&format!("{name}.toml"));
        fs::write(&file, config).unwrap();
        let mut command = Command::new(DRAGNET);
        command.args(arguments).arg("--config").arg(file);
        command
    }
}

/// A process that ends with the test, and whose log is read.
pub(crate) struct Process {
    child: Child,
    log: Receiver<String>,
}

impl Process {
    pub(crate) fn start(command: &mut Command) -> Self {
        let command = command.env_remove("RUST_LOG").stdin(Stdio::null()).stdout(Stdio::piped());
        let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
        let (sender, log) = channel();
        let lines = BufReader::new(child.stderr.take().unwrap()).lines();
        std::thread::spawn(move || lines.map_while(Result::ok).try_for_each(|line| sender.send(line)));
        Self { child, log }
    }

    /// Waits for a log line with all of these parts.
    pub(crate) fn logs(&self, parts: &[&str]) -> String {
        self.lines_until(parts).pop().unwrap_or_default()
    }

    /// Its log lines up to one with all of these parts.
    pub(crate) fn lines_until(&self, parts: &[&str]) -> Vec<String> {
        let mut said = Vec::new();
        loop {
            match self.log.recv_timeout(PATIENCE) {
                Ok(line) => {
                    let is_it = parts.iter().all(|part| line.contains(part));
                    said.push(line);
                    if is_it {
                        return said;
                    }
                }
                Err(end) => panic!("it did not say {parts:?} ({end}), but\n{}", said.join("\n")),
            }
        }
    }

    pub(crate) fn output(mut self) -> String {
        eventually("it has ended", || self.child.try_wait().unwrap().is_some());
        let mut text = String::new();
        std::io::Read::read_to_string(&mut self.child.stdout.take().unwrap(), &mut text).unwrap();
        text
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_mission_over_mutual_tls_is_searched_to_its_end() {
    let field = Field::new(Topology::Mesh);
    let world = field.start(Name::Simulator, 0);
    let others: Vec<Process> =
        NAMES[..3].iter().zip(1..).map(|(&name, place)| field.start(name, place)).collect();
    let outcome: Value = serde_json::from_str(&world.output()).unwrap();
    assert_eq!((&outcome["beliefs_equal"], &outcome["recall"]), (&json!(true), &json!(1.0)), "{outcome}");
    drop(others);
}

/// The coordinator's log line when a client with these settings connects.
fn refusal(field: &Field, settings: &Path, protocol: &str, expected: &[&str]) {
    let coordinator = field.start(Name::COORDINATOR, 0);
    coordinator.logs(&["the coordinator of mission field listens"]);
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let connect = vec![field.endpoints[0].replace("tls/", protocol)];
    let endpoints = Endpoints { connect, config: Some(settings.to_owned()), ..Endpoints::default() };
    // Kept until it has been rejected: it connects again and again.
    let caller = runtime.block_on(open(&endpoints)).unwrap();
    coordinator.logs(expected);
    drop(caller);
}

#[test]
fn connections_without_a_certificate_are_rejected() {
    let field = Field::new(Topology::Mesh);
    let settings = field.altered(Name::robot(2).unwrap(), |link| {
        link["tls"] = json!({
            "root_ca_certificate": "authority.pem", "enable_mtls": false, "verify_name_on_connect": false,
        });
    });
    refusal(&field, &settings, "tls/", &["rejected a connection", "the client has no certificate"]);
}

#[test]
fn a_certificate_of_a_foreign_authority_is_rejected() {
    let (field, foreign) = (Field::new(Topology::Mesh), Field::new(Topology::Mesh));
    let authority = field.path("keys/authority.pem");
    let settings = foreign
        .altered(Name::robot(2).unwrap(), |link| link["tls"]["root_ca_certificate"] = json!(authority));
    refusal(&field, &settings, "tls/", &["rejected a connection", "is not of this mission's authority"]);
}

#[test]
fn an_expired_certificate_is_rejected() {
    let field = Field::new(Topology::Mesh);
    let long_ago = OffsetDateTime::now_utc() - time::Duration::days(20);
    field.keys().add(&[Name::robot(3).unwrap()], &[], 1, long_ago).unwrap();
    let settings = field.altered(Name::robot(3).unwrap(), |_| ());
    refusal(&field, &settings, "tls/", &["rejected a connection", "certificate has expired"]);
}

#[test]
fn plain_tcp_is_not_understood_where_tls_is_spoken() {
    let field = Field::new(Topology::Mesh);
    let settings = field.path("plain.json5");
    fs::write(&settings, "{ mode: 'peer', scouting: { multicast: { enabled: false } } }").unwrap();
    refusal(&field, &settings, "tcp/", &["rejected a connection", "the client does not use TLS"]);
}

#[test]
fn a_robot_does_not_trust_an_unknown_peer() {
    let (field, foreign) = (Field::new(Topology::Mesh), Field::new(Topology::Mesh));
    let stranger = foreign.start(Name::COORDINATOR, 0);
    stranger.logs(&["the coordinator of mission field listens"]);
    let field = Field { endpoints: [&foreign.endpoints[..1], &field.endpoints[1..]].concat(), ..field };
    let robot = field.start(Name::robot(1).unwrap(), 1);
    robot.logs(&["no connection to tls/", "one side rejects the other", "invalid peer certificate"]);
}

fn intent_of(robot: u16) -> Message {
    let robot = RobotId::new(robot).unwrap();
    Message::Intent(Intent { robot, incarnation: 0, decision: 1, time_ns: 0, path: Vec::new().into() })
}

/// Publishes as robots 1 and 2, with the certificate of robot 2.
async fn pose(endpoint: &str, settings: PathBuf) -> Link {
    let endpoints =
        Endpoints { connect: vec![endpoint.to_owned()], config: Some(settings), ..Endpoints::default() };
    let session = open(&endpoints).await.unwrap();
    let codec = Codec::new(Grid::new(15, 15).unwrap());
    let participant = Participant::Robot(RobotId::new(2).unwrap());
    let mut mouth = Link::join(session.clone(), "field".parse().unwrap(), participant, codec).await.unwrap();
    mouth.announce().await.unwrap();
    mouth.wait_for(&[Participant::Coordinator], PATIENCE, |_| ()).await.unwrap();
    let number = Envelope { number: 7, identity: 5 }.encode();
    session
        .put("dragnet/field/robots/1/intent", convert::encode(&intent_of(1)))
        .attachment(number)
        .await
        .unwrap();
    mouth.publish(8, Audience::All, &intent_of(2)).await.unwrap();
    mouth
}

#[test]
fn a_robot_publishes_under_its_own_number_only() {
    let field = Field::new(Topology::Mesh);
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let settings = field.altered(Name::robot(2).unwrap(), |_| ());
    runtime.block_on(async {
        let endpoints = Endpoints {
            listen: vec![field.endpoints[1].clone()],
            config: Some(field.settings(Name::COORDINATOR)),
            ..Endpoints::default()
        };
        let codec = Codec::new(Grid::new(15, 15).unwrap());
        let session = open(&endpoints).await.unwrap();
        let participant = Participant::Coordinator;
        let mut ear = Link::join(session, "field".parse().unwrap(), participant, codec).await.unwrap();
        ear.announce().await.unwrap();
        let mouth = pose(&field.endpoints[1], settings.clone()).await;
        // Both came over one connection, in this order: the first was not accepted. A busy machine drops messages.
        let mut number = 8;
        loop {
            let Ok(incoming) = tokio::time::timeout(Duration::from_secs(2), ear.receive()).await else {
                number += 1;
                assert!(number < 40, "no message of robot 2 comes");
                mouth.publish(number, Audience::All, &intent_of(2)).await.unwrap();
                continue;
            };
            match incoming.unwrap() {
                Incoming::Message { from, message, .. } => {
                    assert_eq!((from, message), (Participant::Robot(RobotId::new(2).unwrap()), intent_of(2)));
                    break;
                }
                Incoming::Came(participant, _) => {
                    assert_eq!(participant, Participant::Robot(RobotId::new(2).unwrap()));
                }
                other => panic!("{other:?}"),
            }
        }
        drop(mouth);
    });
    let coordinator = field.start(Name::COORDINATOR, 0);
    coordinator.logs(&["listens"]);
    let mouth = runtime.block_on(pose(&field.endpoints[0], settings));
    coordinator.logs(&["refused Put of robot-2#3 under dragnet/field/robots/1/intent"]);
    drop(mouth);
}

#[test]
fn a_revoked_robot_is_out_once_the_others_have_their_new_settings() {
    let field = Field::new(Topology::Mesh);
    let stolen = field.path("stolen");
    fs::rename(field.keys().home(Name::robot(2).unwrap()), &stolen).unwrap();
    fs::create_dir(field.keys().home(Name::robot(2).unwrap())).unwrap();
    let revoked = Command::new(DRAGNET)
        .args(["keys", "revoke"])
        .arg(field.path("keys"))
        .arg("robot-2")
        .output()
        .unwrap();
    let text = String::from_utf8(revoked.stdout).unwrap();
    for reported in
        ["robot-2#3 is revoked", "robot-1/zenoh.json5", "coordinator/zenoh.json5", "sim/zenoh.json5"]
    {
        assert!(text.contains(reported), "{text}");
    }
    let coordinator = field.start(Name::COORDINATOR, 0);
    coordinator.logs(&["listens"]);
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let endpoints = Endpoints {
        connect: field.endpoints[..1].to_vec(),
        config: Some(stolen.join(SETTINGS)),
        ..Endpoints::default()
    };
    let robot = runtime.block_on(async {
        let codec = Codec::new(Grid::new(15, 15).unwrap());
        let session = open(&endpoints).await.unwrap();
        let participant = Participant::Robot(RobotId::new(2).unwrap());
        let mut link = Link::join(session, "field".parse().unwrap(), participant, codec).await.unwrap();
        link.announce().await.unwrap();
        link
    });
    coordinator.logs(&["refused Declare Subscriber of robot-2#3 under dragnet/field"]);
    // A valid one is accepted, and only that one.
    let first = field.start(Name::robot(1).unwrap(), 1);
    let line = coordinator.logs(&["is here"]);
    assert!(line.contains("robot 1 is here"), "{line}");
    drop((robot, first));
}

#[test]
fn in_a_star_the_coordinator_forwards_messages_of_robots() {
    let field = Field::new(Topology::Star);
    let coordinator = field.start(Name::COORDINATOR, 0);
    coordinator.logs(&["listens"]);
    let runtime = tokio::runtime::Runtime::new().unwrap();
    runtime.block_on(async {
        let codec = Codec::new(Grid::new(15, 15).unwrap());
        let mut links = Vec::new();
        for number in [1, 2] {
            let endpoints = Endpoints {
                connect: field.endpoints[..1].to_vec(),
                config: Some(field.settings(Name::robot(number).unwrap())),
                ..Endpoints::default()
            };
            let participant = Participant::Robot(RobotId::new(number).unwrap());
            let session = open(&endpoints).await.unwrap();
            let mut link =
                Link::join(session, "field".parse().unwrap(), participant, codec.clone()).await.unwrap();
            link.announce().await.unwrap();
            links.push(link);
        }
        let [first, second] = &mut links[..] else { panic!("two robots") };
        first
            .wait_for(
                &[Participant::Robot(RobotId::new(2).unwrap()), Participant::Coordinator],
                PATIENCE,
                |_| (),
            )
            .await
            .unwrap();
        second.wait_for(&[Participant::Robot(RobotId::FIRST)], PATIENCE, |_| ()).await.unwrap();
        // That robots see each other does not say that subscriptions have come through: it is said until it is heard.
        let forwarded = async {
            for number in 1.. {
                first.publish(number, Audience::All, &intent_of(1)).await.unwrap();
                let received = tokio::time::timeout(Duration::from_secs(1), second.receive()).await;
                if let Ok(Some(Incoming::Message {
                    from: Participant::Robot(RobotId::FIRST), message, ..
                })) = received
                {
                    assert_eq!(message, intent_of(1));
                    return;
                }
            }
        };
        tokio::time::timeout(PATIENCE, forwarded).await.unwrap();
    });
}
