//! Robots with a simulated world that comes, goes and loses messages.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use dragnet_proto::convert::Codec;
use dragnet_proto::directive::Directive;
use dragnet_proto::message::{Activity, Audience, Heartbeat, Intent, Message};
use dragnet_proto::sender::Claim;
use dragnet_proto::state_machine::Event;
use dragnet_runtime::link::{Incoming, Link, ReceiveOnly};
use dragnet_runtime::session::{Endpoints, free_endpoints, open};
use dragnet_runtime::wall_clock::Report;
use dragnet_runtime::world::{self, WorldServer};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::observation::{RobotId, Versions};
use tokio::sync::mpsc;

use crate::field::{DRAGNET, Field, Process};
use crate::{eventually, scenario};

const ONE: RobotId = RobotId::FIRST;

/// A robot whose messages are sent by the test.
struct Robot {
    link: Link,
    sights: mpsc::Receiver<Report>,
    cells: Vec<Cell>,
    number: u64,
}

impl Robot {
    async fn join(scenario: &Scenario, world: &str) -> Self {
        let session =
            open(&Endpoints { connect: vec![world.to_owned()], ..Endpoints::default() }).await.unwrap();
        let codec = Codec::new(scenario.terrain().grid());
        let mut link =
            Link::join(session, "m".parse().unwrap(), Participant::Robot(ONE), codec.clone()).await.unwrap();
        let sights = world::sensor(&link, ONE, codec).await.unwrap();
        link.announce().await.unwrap();
        Self { link, sights, cells: scenario.terrain().grid().cells().collect(), number: 0 }
    }

    async fn say(&mut self, message: Message) {
        self.link.publish(self.number, Audience::All, &message).await.unwrap();
        self.number += 1;
    }

    fn intent(&self, decision: u64, path: &[usize]) -> Intent {
        let path = path.iter().map(|&cell| self.cells[cell]).collect();
        Intent { robot: ONE, incarnation: 0, decision, time_ns: 0, path }
    }

    async fn beat(&mut self, cell: usize, decision: u64, path: &[usize]) {
        self.beat_at(0, cell, decision, path).await;
    }

    async fn beat_at(&mut self, time_ns: u64, cell: usize, decision: u64, path: &[usize]) {
        let heartbeat = Heartbeat {
            robot: ONE,
            time_ns,
            activity: Activity::Searching,
            cell: self.cells[cell],
            path_meters: 0.0,
            intent: self.intent(decision, path),
            versions: Versions::default(),
            digest: Digest(0),
            directive: Directive::default(),
        };
        self.say(Message::Heartbeat(heartbeat)).await;
    }

    /// The next cell whose readings the world sends, unless it is the current one.
    async fn enters(&mut self, here: usize) -> usize {
        let another = async {
            while let Some((_, Event::Sensed { cell, .. })) = self.sights.recv().await {
                let cell = self.cells.iter().position(|&it| it == cell);
                if cell != Some(here) {
                    return cell;
                }
            }
            None
        };
        let entered = tokio::time::timeout(Duration::from_mins(1), another).await;
        entered.ok().flatten().unwrap_or_else(|| panic!("it is shown no cell but {here}"))
    }
}

/// Lost messages are recovered by heartbeats; repeated ones, or those to another process of its number, move no robot
/// and are not new readings.
#[tokio::test(flavor = "multi_thread")]
async fn a_robot_moves_by_its_heartbeats_and_not_by_repeated_messages() {
    let row = scenario(
        "name = \"row\"\n[map]\nshape = \"all_traversable\"\nrows = 1\ncolumns = 6\n[objects]\ncount = 1\n\
         [robots]\ncount = 1\nstart = [0, 0]\n[mission]\nbudget_seconds = 36000.0\nspeed_meters_per_second = 1.0\n\
         heartbeat_seconds = 5.0\nliveness_timeout_seconds = 20.0\n",
    );
    let listen = free_endpoints(1).unwrap();
    let mut robot = None;
    let session = open(&Endpoints { listen: listen.clone(), ..Endpoints::default() }).await.unwrap();
    let mut nobody = |_, _| ();
    let world = async {
        let server = WorldServer::open(session, "m".parse().unwrap(), &row, 1, 20.0, false, &mut nobody);
        server.await.unwrap().run().await.map(|_| ())
    };
    let story = async {
        let robot = robot.insert(Robot::join(&row, &listen[0]).await);
        assert_eq!(robot.enters(usize::MAX).await, 0);
        // As every robot after its first observation.
        let risen = Claim { seniority: 1, ..robot.link.claim() };
        robot.link.rise(risen).await.unwrap();
        robot.beat(0, 5, &[1, 2]).await;
        assert_eq!(robot.enters(0).await, 1);
        // Its arrival stops no robot.
        let mut twin = Robot::join(&row, &listen[0]).await;
        assert_eq!(robot.enters(1).await, 2);
        for (decision, path) in [(4, [1]), (5, [1])] {
            let old = robot.intent(decision, &path);
            robot.say(Message::Intent(old)).await;
        }
        let another = twin.intent(9, &[0]);
        twin.say(Message::Intent(another)).await;
        robot.beat(2, 6, &[3, 4]).await;
        assert_eq!(robot.enters(2).await, 3);
        assert_eq!(robot.enters(3).await, 4);
        // It did not receive its readings, or they were lost.
        robot.beat(3, 6, &[4]).await;
        tokio::time::sleep(Duration::from_millis(300)).await;
        robot.beat(3, 6, &[4]).await;
        assert_eq!(robot.enters(usize::MAX).await, 4);
        assert!(twin.sights.try_recv().is_err());
    };
    tokio::select! {
        ended = world => panic!("the world ended: {ended:?}"),
        () = story => {}
    }
}

/// A mission that runs does not wait for a robot that is lost; one that comes later is shown its cell.
#[tokio::test(flavor = "multi_thread")]
async fn a_world_joins_a_mission_without_the_robots_that_are_lost() {
    let pair = scenario(
        "name = \"pair\"\n[map]\nshape = \"all_traversable\"\nrows = 1\ncolumns = 6\n[objects]\ncount = 1\n\
         [robots]\ncount = 2\nstart = [0, 0]\n[mission]\nbudget_seconds = 36000.0\nspeed_meters_per_second = 1.0\n",
    );
    let listen = free_endpoints(1).unwrap();
    let session = open(&Endpoints { listen: listen.clone(), ..Endpoints::default() }).await.unwrap();
    let mut nobody = |_, _| ();
    let world = async {
        let server = WorldServer::open(session, "m".parse().unwrap(), &pair, 1, 20.0, true, &mut nobody);
        server.await.unwrap().run().await.map(|_| ())
    };
    let story = async {
        let mut robot = Robot::join(&pair, &listen[0]).await;
        let mut ticks = tokio::time::interval(Duration::from_millis(500));
        let begun = std::time::Instant::now();
        while robot.sights.try_recv().is_err() {
            ticks.tick().await;
            robot.beat_at(1_000_000_000, 3, 5, &[4]).await;
            assert!(begun.elapsed() < Duration::from_secs(50), "the world does not begin without robot 2");
        }
    };
    tokio::select! {
        ended = world => panic!("the world ended: {ended:?}"),
        () = story => {}
    }
}

const SEARCH: &str = "name = \"field\"\n[map]\nshape = \"all_traversable\"\nrows = 20\ncolumns = 20\n\
                      [objects]\ncount = 4\n[robots]\ncount = 2\npolicy = \"path\"\n\
                      [mission]\nbudget_seconds = 3600.0\nstop_when_expected_remaining = 0.001\n";

/// Robots keep their cells and the mission its time: none of their later observations is rejected.
#[test]
fn a_world_that_is_started_again_joins_the_mission() {
    let field = Field::new(SEARCH, 2, 3);
    let coordinator = field.coordinator();
    let robots = [field.robot(1), field.robot(2)];
    let world = field.world();
    let recording = field.path("field.mcap");
    let seen = || dragnet_coordinator::inspect::inspect(&recording).map_or(0, |it| it.observations);
    eventually("six observations are recorded", || seen() >= 6);
    world.kill();
    let before = seen();
    let outcome: serde_json::Value = serde_json::from_str(&field.world().output()).unwrap();
    assert_eq!(outcome["beliefs_equal"], true, "{outcome}");
    robots.into_iter().for_each(Process::terminate);
    coordinator.terminate();
    let inspection = dragnet_coordinator::inspect::inspect(&recording).unwrap();
    assert!(inspection.observations > before);
    let summary = format!("{:?}", inspection.summary);
    assert!(!summary.contains("refused"), "{summary}");
}

/// The TOML block of the guide after some words.
fn block<'a>(guide: &'a str, words: &str) -> &'a str {
    let (_, rest) = guide.split_once(words).unwrap_or_else(|| panic!("the guide does not say {words:?}"));
    let (_, block) = rest.split_once("```toml\n").unwrap();
    block.split_once("```").unwrap().0
}

/// All endpoints in settings, in order.
fn endpoints(settings: &str) -> Vec<String> {
    let quoted = settings.lines().filter(|line| !line.starts_with('#')).flat_map(|line| line.split('"'));
    quoted.filter(|text| text.starts_with("tcp/")).map(str::to_owned).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn the_guides_example_files_meet_each_other_as_printed() {
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide.md");
    let guide = std::fs::read_to_string(guide).unwrap();
    let robot = block(&guide, "`robot_1.toml`, for");
    let (coordinator, sim) = (
        block(&guide, "`coordinator.toml`, for"),
        block(&guide, "dragnet sim valley.toml --config sim.toml"),
    );
    // Addresses of one network, which become ports of this computer.
    let mut places = BTreeMap::new();
    for endpoint in [robot, coordinator, sim].into_iter().flat_map(endpoints) {
        let free = || {
            free_endpoints(8).unwrap().into_iter().find(|it| !places.values().any(|used| used == it)).unwrap()
        };
        let here = places.get(&endpoint).cloned().unwrap_or_else(free);
        places.insert(endpoint, here);
    }
    let here = |settings: &str| {
        places.iter().fold(settings.to_owned(), |text, (there, here)| {
            text.replace(&format!("{there:?}"), &format!("{here:?}"))
        })
    };
    let folder = tempfile::tempdir().unwrap();
    let start = |name: &str, settings: &str, arguments: &[&str]| {
        std::fs::write(folder.path().join(name), here(settings)).unwrap();
        let mut command = Command::new(DRAGNET);
        Process::start(command.args(arguments).args(["--config", name]).current_dir(folder.path()))
    };
    let valley = "name = \"valley\"\n[map]\nshape = \"all_traversable\"\nrows = 8\ncolumns = 8\n[objects]\ncount = 1\n\
                  [robots]\ncount = 3\n[mission]\nbudget_seconds = 3600.0\nspeed_meters_per_second = 5.0\n";
    std::fs::write(folder.path().join("valley.toml"), valley).unwrap();
    let team = endpoints(robot);
    let mut processes = vec![start("coordinator.toml", coordinator, &["coordinator"])];
    for number in 1..=3 {
        // The others' files are the first one's, with their numbers and addresses.
        let (first, own) = (format!("{:?}", team[0]), format!("{:?}", team[number - 1]));
        let settings = robot
            .replacen("robot = 1", &format!("robot = {number}"), 1)
            .replace(&own, "own")
            .replace(&first, &own)
            .replace("own", if number == 1 { &own } else { &first });
        processes.push(start(&format!("robot_{number}.toml"), &settings, &["agent"]));
    }
    processes.push(start("sim.toml", sim, &["sim", "valley.toml"]));
    let connect = team.iter().map(|endpoint| places[endpoint].clone()).collect();
    let session = open(&Endpoints { connect, ..Endpoints::default() }).await.unwrap();
    let codec = Codec::new(Scenario::load(&folder.path().join("valley.toml")).unwrap().terrain().grid());
    let mut ear = Link::join(session, "valley".parse().unwrap(), ReceiveOnly, codec).await.unwrap();
    let mut searching = Vec::new();
    let meeting = async {
        while searching.len() < 3 {
            if let Some(Incoming::Message { from, message: Message::Observation(_), .. }) =
                ear.receive().await
                && !searching.contains(&from)
            {
                searching.push(from);
            }
        }
    };
    assert!(tokio::time::timeout(Duration::from_mins(1), meeting).await.is_ok(), "only {searching:?} search");
    // The coordinator receives them, too.
    let recording = folder.path().join("valley.mcap");
    let seen = || dragnet_coordinator::inspect::inspect(&recording).map_or(0, |it| it.observations);
    eventually("the coordinator records what they see", || seen() >= 3);
    drop(processes);
}
