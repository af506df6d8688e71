//! One time for a whole mission: robots on vehicles, without a simulator, that start apart, on computers with wrong
//! dates, and restart with and without their stored state.

use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use dragnet_proto::convert::Codec;
use dragnet_proto::message::{Activity, Heartbeat, Message};
use dragnet_runtime::link::{Incoming, Link};
use dragnet_runtime::session::{Endpoints, Mode, free_endpoints, open};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_search::observation::{Observation, Origin, RobotId};
use tempfile::TempDir;
use tokio::task::JoinHandle;

use crate::field::{DRAGNET, Process};
use crate::test_site::{SPEED_METERS_PER_SECOND, TestSite, Vehicle, cameras, settings};

const YARD: TestSite = TestSite { side: 6, cell_meters: 10.0, policy: "'random'" };
/// Robots that never rest, and reject observations dated more than a second ahead.
const ENDLESS: &str = "stop_when_expected_remaining = 0.0\nheartbeat_seconds = 1.0\nliveness_timeout_seconds = 10.0\n\
                       max_clock_skew_seconds = 1.0\n";

/// A library that shifts the date of a process, and nothing else.
const SHIFT: &str = r#"
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>
#include <time.h>
int clock_gettime(clockid_t clock, struct timespec *time) {
    static int (*real)(clockid_t, struct timespec *);
    if (!real) real = dlsym(RTLD_NEXT, "clock_gettime");
    int failed = real(clock, time);
    if (!failed && clock == CLOCK_REALTIME) time->tv_sec += atol(getenv("DATE_SHIFT"));
    return failed;
}
"#;

const HOUR: i64 = 3600;

/// Robots whose vehicles drive about in one test site.
struct Team {
    folder: TempDir,
    /// Endpoint of each robot in its team.
    listen: Vec<String>,
    /// Endpoint of each robot's vehicle.
    bridges: Vec<String>,
    vehicles: Vec<JoinHandle<()>>,
    /// Receives the mission's messages.
    ear: Link,
}

impl Team {
    async fn new(robots: usize, mission: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let test_site = YARD.scenario().replace("count = 1\npolicy", &format!("count = {robots}\npolicy"));
        std::fs::write(folder.path().join("test_site.toml"), format!("{test_site}{mission}")).unwrap();
        std::fs::write(folder.path().join("shift.c"), SHIFT).unwrap();
        let shift = ["-shared", "-fPIC", "-o", "shift.so", "shift.c", "-ldl"];
        let compiled = Command::new("cc").args(shift).current_dir(folder.path()).status().unwrap();
        assert!(compiled.success());
        let mut listen = free_endpoints(2 * robots).unwrap();
        let bridges = listen.split_off(robots);
        let mut vehicles = Vec::new();
        for bridge in &bridges {
            let bridge =
                Endpoints { listen: vec![bridge.clone()], mode: Some(Mode::Router), ..Endpoints::default() };
            vehicles.push(tokio::spawn(drive(bridge)));
        }
        let session = open(&Endpoints { connect: listen.clone(), ..Endpoints::default() }).await.unwrap();
        let scenario = Scenario::load(&folder.path().join("test_site.toml")).unwrap();
        let codec = Codec::new(scenario.terrain().grid());
        let mut ear =
            Link::join(session, "test_site".parse().unwrap(), Participant::Coordinator, codec).await.unwrap();
        ear.announce().await.unwrap();
        Self { folder, listen, bridges, vehicles, ear }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn log(&self, robot: usize) -> String {
        std::fs::read_to_string(self.path(&format!("log-{robot}"))).unwrap()
    }

    /// Starts a robot whose date is off by this many seconds.
    fn start(&self, robot: usize, shift: i64) -> Process {
        let place = robot - 1;
        let calls = format!("zenoh = {{ connect = {:?}, listen", &self.listen[..place]);
        let settings = settings(&self.listen[place], &self.bridges[place])
            .replacen("robot = 1", &format!("robot = {robot}"), 1)
            // Stamps of the vehicle are not by the robot's date.
            .replacen("[ros]\n", "[ros]\nstamps = \"arrival\"\n", 1)
            .replacen("zenoh = { listen", &calls, 1);
        let file = self.path(&format!("robot_{robot}.toml"));
        std::fs::write(&file, settings).unwrap();
        let log = std::fs::File::options().create(true).append(true).open(self.path(&format!("log-{robot}")));
        let mut command = Command::new(DRAGNET);
        command.args(["agent", "--config"]).arg(file).stderr(log.unwrap());
        Process::start(command.env("LD_PRELOAD", self.path("shift.so")).env("DATE_SHIFT", shift.to_string()))
    }

    /// The first message with a property.
    async fn receive<T>(&mut self, what: &str, mut look_for: impl FnMut(&Message) -> Option<T>) -> T {
        let hearing = async {
            loop {
                if let Some(Incoming::Message { message, .. }) = self.ear.receive().await
                    && let Some(found) = look_for(&message)
                {
                    return found;
                }
            }
        };
        let received = tokio::time::timeout(Duration::from_mins(1), hearing).await;
        received.unwrap_or_else(|_| panic!("nobody says {what}; robot 1 says:\n{}", self.log(1)))
    }

    /// An observation of a robot from a mission time on, of none of these starts.
    async fn new_observation(&mut self, robot: u16, since_ns: u64, known: &[Origin]) -> (Origin, u64) {
        let what = format!("what robot {robot} sees from {since_ns} ns on");
        self.receive(&what, |message| match message {
            Message::Observation(observation) => {
                let Observation { origin, time_ns, .. } = **observation;
                let is_new = origin.source == RobotId::new(robot).unwrap().into() && !known.contains(&origin);
                (is_new && time_ns >= since_ns).then_some((origin, time_ns))
            }
            _ => None,
        })
        .await
    }

    /// Waits until a robot has observations of another's start.
    async fn knows(&mut self, robot: u16, of: Origin) {
        let what = format!("that robot {robot} knows what {of:?} saw");
        let is_told = |heartbeat: &Heartbeat| {
            heartbeat.robot == RobotId::new(robot).unwrap()
                && heartbeat.versions.iter().any(|version| version.origin == of)
        };
        self.receive(&what, |message| {
            matches!(message, Message::Heartbeat(beat) if is_told(beat)).then_some(())
        })
        .await;
    }
}

impl Drop for Team {
    fn drop(&mut self) {
        self.vehicles.iter().for_each(JoinHandle::abort);
    }
}

/// A vehicle follows its paths, and its cameras work.
async fn drive(bridge: Endpoints) {
    let session = open(&bridge).await.unwrap();
    let paths = session.declare_subscriber("dragnet/path").await.unwrap();
    let (mut vehicle, cameras, tick) = (Vehicle::new(YARD), cameras(), Duration::from_millis(50));
    let mut ticks = tokio::time::interval(tick);
    loop {
        ticks.tick().await;
        while let Ok(Some(sample)) = paths.try_recv() {
            vehicle.follow(&sample.payload().to_bytes());
        }
        vehicle.drive(SPEED_METERS_PER_SECOND * tick.as_secs_f64());
        for (key, bytes) in vehicle.messages(&cameras) {
            session.put(key, bytes).await.unwrap();
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn robots_that_start_apart_with_wrong_dates_or_no_memory_share_one_time() {
    let mut team = Team::new(2, ENDLESS).await;
    let first = team.start(1, 3 * HOUR);
    let (one, began_ns) = team.new_observation(1, 0, &[]).await;
    let later = began_ns + 4_000_000_000;
    let (_, late_ns) = team.new_observation(1, later, &[]).await;
    // The second starts when the first has searched for longer than the allowed clock skew.
    let second = team.start(2, -HOUR);
    let (two, time_ns) = team.new_observation(2, 0, &[]).await;
    assert!(time_ns > late_ns, "{time_ns} {late_ns}");
    team.knows(1, two).await;
    team.knows(2, one).await;
    // The same without its stored state.
    second.kill();
    std::fs::remove_file(team.path("test_site-robot-2.journal")).unwrap();
    let second = team.start(2, HOUR);
    let (again, again_ns) = team.new_observation(2, 0, &[two]).await;
    assert!(again_ns > time_ns && again > two, "{again_ns} {time_ns} {again:?} {two:?}");
    team.knows(1, again).await;
    team.knows(2, two).await;
    second.terminate();
    first.terminate();
    for robot in [1, 2] {
        assert!(!team.log(robot).contains("dated in the future"), "{}", team.log(robot));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_date_that_is_set_between_two_starts_ends_no_search() {
    let mut team = Team::new(1, ENDLESS).await;
    let robot = team.start(1, -HOUR);
    let (one, _) = team.new_observation(1, 0, &[]).await;
    robot.kill();
    // The budget is ten hours.
    let robot = team.start(1, 20 * HOUR);
    let (two, time_ns) = team.new_observation(1, 0, &[one]).await;
    let (_, next_ns) = team.new_observation(1, time_ns + 3_000_000_000, &[one]).await;
    assert!(next_ns < 120_000_000_000, "{next_ns}");
    assert!(two > one);
    let activity = team.receive("a sign of life", |message| match message {
        Message::Heartbeat(heartbeat) => Some(heartbeat.activity),
        _ => None,
    });
    assert_eq!(activity.await, Activity::Searching);
    robot.terminate();
}
