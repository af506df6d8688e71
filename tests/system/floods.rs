//! A participant floods a mission with invalid messages: logs and memory stay bounded, and the others go on.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use dragnet_coordinator::inspect::inspect;
use dragnet_proto::convert::encode;
use dragnet_proto::directive::Directive;
use dragnet_proto::key::Topic;
use dragnet_proto::message::{Activity, Heartbeat, Intent, Message, MissionStatus};
use dragnet_proto::sender::{Claim, Envelope};
use dragnet_runtime::session::open;
use dragnet_scenario::participant::Participant;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::observation::{Origin, RobotId, Version, Versions};
use zenoh::Session;

use crate::durability::endless;
use crate::eventually;
use crate::field::{DRAGNET, Field, Process};

/// The flooding robot; the others of its team are honest.
const FLOODER: RobotId = RobotId::new(3).unwrap();
/// Minimum number of rounds of invalid messages.
const ROUNDS: u64 = 1000;
/// Number of starts that it claims to know of each robot: almost the maximum.
const STARTS: u64 = 1000;
/// Maximum number of log lines about others: each kind once a minute for each sender.
const MOST_LINES: usize = 80;
/// 64 MiB of pending messages, and the program with its state.
const MOST_KIB: u64 = 256 << 10;

fn attached() -> Vec<u8> {
    Envelope { number: 7, identity: 5 }.encode()
}

/// The largest possible version vector.
fn versions() -> Versions {
    let origins = RobotId::first(FLOODER.number())
        .flat_map(|robot| (0..STARTS).map(move |incarnation| Origin { source: robot.into(), incarnation }));
    origins.map(|origin| Version { origin, next: 9 }).collect()
}

/// Well-formed, of maximum length, and dated far ahead.
fn long(cell: Cell) -> [(String, Vec<u8>); 2] {
    let (time_ns, directive, digest) = (1 << 60, Directive::default(), Digest(1));
    let intent = Intent { robot: FLOODER, incarnation: 0, decision: 1, time_ns, path: vec![cell].into() };
    let heartbeat = Heartbeat {
        robot: FLOODER,
        time_ns,
        activity: Activity::Searching,
        cell,
        path_meters: 0.0,
        intent,
        versions: versions(),
        digest,
        directive: directive.clone(),
    };
    let status = MissionStatus {
        time_ns,
        declared: Vec::new(),
        expected_remaining: 0.0,
        alive: vec![FLOODER],
        observations: 1 << 60,
        versions: versions(),
        digest,
        directive,
        doubled: vec![FLOODER],
    };
    [
        (key(Topic::Heartbeat(FLOODER)), encode(&Message::Heartbeat(heartbeat))),
        (key(Topic::Status), encode(&Message::MissionStatus(status))),
    ]
}

fn key(topic: Topic) -> String {
    "field".parse::<dragnet_proto::key::Mission>().unwrap().key(topic).to_string()
}

/// Sends invalid messages of all kinds, and counts the rounds.
async fn flood(session: Session, cell: Cell, rounds: Arc<AtomicU64>) {
    let robots = |rest: &str| format!("dragnet/field/robots/{rest}");
    let garbage = vec![0xa5; 300];
    let here = [
        "77/heartbeat",
        "x/intent",
        "3/observation",
        "1/heartbeat",
        "3/sync_reply/1",
        "3/sync_reply/coordinator",
    ];
    let bad: Vec<String> = here.map(robots).into_iter().chain([key(Topic::Status)]).collect();
    let long = long(cell);
    loop {
        let round = rounds.fetch_add(1, Ordering::Relaxed);
        session.put(robots("3/intent"), garbage.clone()).await.unwrap();
        for key in &bad {
            session.put(key, garbage.clone()).attachment(attached()).await.unwrap();
        }
        if round.is_multiple_of(20) {
            for (key, bytes) in &long {
                session.put(key, bytes.clone()).attachment(attached()).await.unwrap();
            }
        }
        // Tokens that come and go: of one robot, of the coordinator, and of a participant outside the team.
        for participant in [
            Participant::Robot(FLOODER),
            Participant::Coordinator,
            Participant::Robot(RobotId::new(77).unwrap()),
        ] {
            let claim = Claim { seniority: 0, identity: 1000 + round };
            let alive = key(Topic::Alive { participant, claim });
            session.liveliness().declare_token(alive).await.unwrap().undeclare().await.unwrap();
        }
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
}

struct Witnessed {
    process: Process,
    log: PathBuf,
}

impl Witnessed {
    fn start(verb: &str, settings: &Path) -> Self {
        let log = settings.with_extension("log");
        let mut command = Command::new(DRAGNET);
        let process = Process::start_logged(command.args([verb, "--config"]).arg(settings), &log);
        Self { process, log }
    }

    /// Its peak memory, KiB, on Linux.
    fn memory_kib(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.process.id())).unwrap();
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
        peak.trim().trim_end_matches(" kB").parse().unwrap()
    }

    /// Its log lines about others.
    fn end(self) -> Vec<String> {
        self.process.terminate();
        let log = std::fs::read_to_string(self.log).unwrap();
        let own = [
            " decided: ",
            " found: ",
            " learned from ",
            " doubts: ",
            " resting: ",
            " waiting: ",
            " declared: ",
            " withdrawn: ",
        ];
        log.lines().filter(|line| !own.iter().any(|word| line.contains(word))).map(str::to_owned).collect()
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_flood_fills_neither_logs_nor_memory_and_the_others_are_received() {
    let field = Field::new(&endless(3), 3, 4);
    let recording = field.path("field.mcap");
    let coordinator = Witnessed::start("coordinator", &field.coordinator_settings(&recording));
    let robot = Witnessed::start("agent", &field.robot_settings(1, None));
    let mate = Witnessed::start("agent", &field.robot_settings(2, None));
    let world = field.world();
    let session = open(&field.endpoints(4)).await.unwrap();
    let claim = Claim { seniority: 0, identity: 1 };
    let alive = key(Topic::Alive { participant: Participant::Robot(FLOODER), claim });
    let _present = session.liveliness().declare_token(alive).await.unwrap();
    let observations = || inspect(&recording).map_or(0, |read| read.observations);
    eventually("they search", || observations() > 3);
    let rounds = Arc::new(AtomicU64::new(0));
    let cell = field.scenario().terrain().grid().cells().next().unwrap();
    let flood = tokio::spawn(flood(session, cell, Arc::clone(&rounds)));
    eventually("the flood is there", || rounds.load(Ordering::Relaxed) > ROUNDS / 2);
    let before = observations();
    eventually("the others are heard", || {
        rounds.load(Ordering::Relaxed) > ROUNDS && observations() > before + 20
    });
    flood.abort();
    let memory = [&coordinator, &robot].map(Witnessed::memory_kib);
    mate.end();
    let logs = [coordinator, robot].map(Witnessed::end);
    world.kill();
    eprintln!("{rounds:?} rounds, {memory:?} KiB, {:?} lines", logs.each_ref().map(Vec::len));
    for (log, memory_kib) in logs.iter().zip(memory) {
        let text = log.join("\n");
        assert!(log.len() < MOST_LINES, "{text}");
        assert!(memory_kib < MOST_KIB, "{memory_kib} KiB");
        // One line for each kind and sender, and a count of the others.
        for (what, of) in
            [("invalid messages", "a participant outside the team"), ("invalid messages", "robot 3")]
        {
            let left_out = format!(", not logged: {what} of {of}");
            assert!(log.iter().any(|line| line.contains(&left_out)), "{left_out}: {text}");
        }
    }
}
