//! A mission on separate hosts: links that are cut, slow and lossy, robots and routers that are killed.

use std::fmt::Write;

use dragnet_coordinator::inspect::inspect;
use dragnet_runtime::journal::{Journal, Subject};
use dragnet_scenario::Scenario;
use dragnet_search::observation::RobotId;

use crate::hosts::Hosts;

const PACE: f64 = 30.0;
const ROBOTS: u16 = 4;

const SEARCH: &str = "name = \"field\"\n[map]\nshape = \"all_traversable\"\nrows = 30\ncolumns = 30\n\
                      [objects]\ncount = 6\n[robots]\ncount = 4\npolicy = \"greedy\"\n\
                      [mission]\nbudget_seconds = 7200.0\nstop_when_expected_remaining = 0.001\n";

/// A participant is lost after two seconds of silence; Zenoh's own lease is ten.
const ZENOH: &str = "{ mode: \"peer\", scouting: { multicast: { enabled: false }, gossip: { enabled: false } },\n\
                     transport: { link: { tx: { lease: 2000 } } } }\n";

/// The connections of the participants.
#[derive(Clone, Copy, PartialEq)]
enum Shape {
    /// Each robot connects to the coordinator and to all robots before it; the last one over the relay.
    Mesh,
    /// All connect to the coordinator only.
    Star,
}

struct Mission {
    hosts: Hosts,
    shape: Shape,
}

impl Mission {
    /// Robots 1 and 2 are on the left with the coordinator, 3 and 4 on the right with the relay.
    fn new(shape: Shape) -> Option<Self> {
        let mut hosts = Hosts::new()?;
        hosts.write("search.toml", SEARCH);
        hosts.write("zenoh.json5", ZENOH);
        for order in ["host sim 1 left", "host coordinator 2 left", "host relay 9 right"] {
            hosts.order(order);
        }
        for robot in 1..=ROBOTS {
            let side = if robot <= ROBOTS / 2 { "left" } else { "right" };
            hosts.order(&format!("host robot-{robot} {} {side}", 10 + robot));
        }
        Some(Self { hosts, shape })
    }

    fn zenoh(&self, listen: &str, connect: &[String]) -> String {
        let config = self.hosts.path("zenoh.json5");
        let mode = if self.shape == Shape::Star { "mode = \"router\"\n" } else { "" };
        let config = config.display();
        format!("listen = [{listen:?}]\nconnect = {connect:?}\nconfig = \"{config}\"\n{mode}")
    }

    fn common(&self, listen: &str, connect: &[String]) -> String {
        let zenoh = self.zenoh(listen, connect);
        format!(
            "[common]\nmission = \"field\"\nscenario = \"search.toml\"\nseed = 4\nreal_time_factor = {PACE:?}\n\
             [common.zenoh]\n{zenoh}"
        )
    }

    fn start_coordinator(&mut self, recording: &str) {
        let path = self.hosts.path(recording);
        let config = format!("recording = \"{}\"\n{}", path.display(), self.common("tcp/10.0.0.2:7140", &[]));
        self.hosts.write("coordinator.toml", &config);
        let router = if self.shape == Shape::Star { "--router" } else { "" };
        let config = self.hosts.path("coordinator.toml");
        self.hosts.start("coordinator", &format!("coordinator {router} --config {}", config.display()));
    }

    fn start_robot(&mut self, robot: u16) {
        let mut connect = vec!["tcp/10.0.0.2:7140".to_owned()];
        if self.shape == Shape::Mesh {
            connect.push("tcp/10.9.0.1:7140".to_owned());
            connect.extend((1..robot).map(|other| format!("tcp/10.0.0.{}:7140", 10 + other)));
        }
        if self.shape == Shape::Mesh && robot == ROBOTS {
            // All but the world, which has no radio.
            connect = (0..robot).map(|place| format!("tcp/10.0.0.9:{}", 7000 + place)).collect();
            connect.push("tcp/10.9.0.1:7140".to_owned());
        }
        let listen = format!("tcp/10.0.0.{}:7140", 10 + robot);
        let name = format!("robot-{robot}");
        self.hosts
            .write(&format!("{name}.toml"), &format!("robot = {robot}\n{}", self.common(&listen, &connect)));
        let config = self.hosts.path(&format!("{name}.toml"));
        self.hosts.start(&name, &format!("agent --config {}", config.display()));
    }

    /// A fifth of a second each way, and 100 kB per second: port 7000 is the coordinator's, then one for each robot.
    fn start_relay(&mut self) {
        let mut forwards = "10.0.0.9:7000=10.0.0.2:7140".to_owned();
        for robot in 1..ROBOTS {
            write!(forwards, " 10.0.0.9:{}=10.0.0.{}:7140", 7000 + robot, 10 + robot).unwrap();
        }
        self.hosts.start("relay", &format!("relay {forwards} --delay 0.2 --rate 100000"));
    }

    fn start_world(&mut self) {
        let connect = match self.shape {
            Shape::Mesh => Vec::new(),
            Shape::Star => vec!["tcp/10.0.0.2:7140".to_owned()],
        };
        let zenoh = self.zenoh("tcp/10.9.0.1:7140", &connect);
        self.hosts.write(
            "sim.toml",
            &format!("mission = \"field\"\nseed = 4\nreal_time_factor = {PACE:?}\n[zenoh]\n{zenoh}"),
        );
        let (scenario, config) = (self.hosts.path("search.toml"), self.hosts.path("sim.toml"));
        self.hosts.start("sim", &format!("sim {} --json --config {}", scenario.display(), config.display()));
    }

    /// Waits until this many observations are on the coordinator's disk.
    fn await_observations(&self, recording: &str, count: u64) {
        let path = self.hosts.path(recording);
        let recorded = || inspect(&path).map_or(0, |inspection| inspection.observations);
        self.hosts.until(&format!("{count} observations in {recording}"), |_| recorded() >= count);
    }

    /// Waits until a process has logged something this many times.
    fn await_words(&self, participant: &str, words: &str, times: usize) {
        let count = |hosts: &Hosts| hosts.log(participant).matches(words).count();
        self.hosts.until(&format!("{participant} says {words:?}"), |hosts| count(hosts) >= times);
    }

    /// Number of observations in a robot's journal.
    fn journal(&self, robot: u16) -> u64 {
        let scenario = Scenario::load(&self.hosts.path("search.toml")).unwrap();
        let (mission, terrain) = ("field".parse().unwrap(), scenario.terrain());
        let subject = Subject { mission: &mission, robot: RobotId::new(robot).unwrap(), terrain };
        let path = self.hosts.path(&format!("field-robot-{robot}.journal"));
        Journal::open(&path, subject, 0).unwrap().1.observations.len() as u64
    }

    /// Waits for the end of the search: everything is found, and all robots believe the same.
    fn outcome(&mut self) -> serde_json::Value {
        self.hosts.order("wait sim x");
        let outcome = std::fs::read_to_string(self.hosts.path("sim.out")).unwrap();
        let outcome: serde_json::Value = serde_json::from_str(&outcome).unwrap_or_else(|error| {
            panic!("{error}: {outcome} {}", self.hosts.log("sim"));
        });
        assert_eq!((&outcome["beliefs_equal"], &outcome["recall"]), (&true.into(), &1.0.into()), "{outcome}");
        outcome
    }

    /// Ends the mission, and checks that the last coordinator has everything.
    fn finish(mut self, recording: &str) {
        let outcome = self.outcome();
        self.hosts.order("kill coordinator TERM");
        self.hosts.order("wait coordinator x");
        let recorded = inspect(&self.hosts.path(recording)).unwrap();
        for robot in 1..=ROBOTS {
            self.hosts.order(&format!("kill robot-{robot} TERM"));
            self.hosts.order(&format!("wait robot-{robot} x"));
            assert_eq!(self.journal(robot), recorded.observations, "robot {robot}");
        }
        // Readings that a robot missed while it was away are sent again.
        let sent = outcome["observations_sent"].as_u64().unwrap();
        assert!(recorded.observations <= sent, "{} {outcome}", recorded.observations);
    }
}

#[test]
fn a_mesh_survives_a_partition_a_slow_link_and_deaths() {
    let Some(mut mission) = Mission::new(Shape::Mesh) else { return };
    mission.start_relay();
    mission.start_coordinator("first.mcap");
    (1..=ROBOTS).for_each(|robot| mission.start_robot(robot));
    mission.start_world();
    mission.await_observations("first.mcap", 20);
    // Two and two.
    mission.hosts.order("link trunk down");
    mission.await_words("robot-1", "robot 3 has left", 1);
    mission.await_words("robot-3", "robot 1 has left", 1);
    // A participant that is still considered present when the trunk is restored would not join again.
    mission.await_words("robot-4", "robot 2 has left", 1);
    mission.hosts.order("link trunk up");
    mission.await_words("robot-1", "robot 3 is back", 1);
    mission.await_words("robot-4", "robot 2 is back", 1);
    // A robot dies, and restarts with its journal.
    mission.hosts.order("kill robot-2 KILL");
    mission.await_words("robot-1", "robot 2 has left", 1);
    mission.start_robot(2);
    mission.await_words("robot-2", "robot 2 goes on with", 1);
    // A late joiner without observations.
    mission.hosts.order("kill coordinator KILL");
    mission.await_words("robot-1", "the coordinator has left", 1);
    mission.start_coordinator("second.mcap");
    mission.finish("second.mcap");
}

#[test]
fn a_star_survives_the_death_of_its_router() {
    let Some(mut mission) = Mission::new(Shape::Star) else { return };
    mission.start_coordinator("first.mcap");
    (1..=ROBOTS).for_each(|robot| mission.start_robot(robot));
    mission.start_world();
    mission.await_observations("first.mcap", 20);
    mission.hosts.order("kill coordinator KILL");
    mission.await_words("robot-1", "robot 2 has left", 1);
    mission.start_coordinator("second.mcap");
    mission.await_words("robot-1", "robot 2 is back", 1);
    mission.finish("second.mcap");
}

/// Zenoh's links over TCP repair what is lost, with pauses of seconds of mission time.
#[test]
fn a_mesh_that_loses_a_third_of_its_packets_finds_everything() {
    let Some(mut mission) = Mission::new(Shape::Mesh) else { return };
    if std::process::Command::new("nft").arg("--version").output().is_err() {
        return crate::skip("this system has no `nft`");
    }
    for host in ["coordinator", "relay", "robot-1", "robot-2", "robot-3", "robot-4"] {
        mission.hosts.order(&format!("lose {host} 33"));
    }
    mission.start_relay();
    mission.start_coordinator("first.mcap");
    (1..=ROBOTS).for_each(|robot| mission.start_robot(robot));
    mission.start_world();
    mission.outcome();
    mission.hosts.order("start ruleset robot-1 nft list ruleset");
    mission.hosts.order("wait ruleset x");
    let ruleset = std::fs::read_to_string(mission.hosts.path("ruleset.out")).unwrap();
    let lost = ruleset.split_once("counter packets ").unwrap().1;
    let lost: u64 = lost.split_once(' ').unwrap().0.parse().unwrap();
    assert!(lost > 100, "{ruleset}");
}
