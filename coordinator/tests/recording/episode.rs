//! A small scripted mission: two robots, an object, and a false one that is declared and withdrawn.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use dragnet_coordinator::mission::{CoordinatorConfig, Mission, Outcome, Record};
use dragnet_coordinator::record::{Header, Recorder};
use dragnet_proto::directive::Directive;
use dragnet_proto::message::{Activity, Heartbeat, Intent, Message, SyncReply};
use dragnet_proto::state_machine::Event;
use dragnet_proto::validation::Limits;
use dragnet_scenario::map_file::MapOrigin;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_scenario::{Class, Scenario};
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Reading;
use dragnet_search::observation::{Observation, Origin, RobotId, Versions};
use dragnet_search::sensor::{Noise, Sensor};
use dragnet_search::terrain::Terrain;

/// Length of the mission, seconds.
pub(crate) const SECONDS: u64 = 20;
/// Where the object is.
pub(crate) const OBJECT: u32 = 17;
/// Origin of its map.
pub(crate) const ORIGIN: MapOrigin = MapOrigin { x_meters: -20.0, y_meters: -12.5, yaw_radians: 0.5 };
/// Cell of a false object that is declared and withdrawn.
const MIRAGE: u32 = 3;
const ROBOTS: [RobotId; 2] = [RobotId::FIRST, RobotId::new(2).unwrap()];

/// A scripted mission.
pub(crate) struct Episode {
    pub(crate) records: Vec<(MissionTime, Record)>,
    pub(crate) mission: Mission,
}

pub(crate) fn seconds(seconds: f64) -> MissionTime {
    MissionTime::START + Duration::from_secs_f64(seconds)
}

fn terrain() -> Arc<Terrain> {
    Arc::new(Terrain::from_ascii("......\n..#.~.\n....,.\n......", 30.0).unwrap())
}

fn prior() -> Belief {
    Belief::uniform(&terrain(), 0.05).unwrap()
}

/// Limits that all of its observations satisfy.
fn limits() -> Limits {
    let text = "name = 'a'\nmap = { shape = 'all_traversable', rows = 6, columns = 6 }\nrobots.count = 2\n\
                objects.count = 1\n\
                mission = { budget_seconds = 60.0, speed_meters_per_second = 1e6 }\n";
    let scenario = Scenario::from_text(Path::new("a.toml"), text.to_owned()).unwrap();
    let sensor = Sensor::new(10, 0.005, Noise::Gaussian).unwrap();
    let class = Arc::new(Class { sensor: Arc::new(sensor), ..(*scenario.robots()[0].class).clone() });
    let team = ROBOTS.map(|robot| (robot, Arc::clone(&class)));
    Limits::new(terrain(), team, scenario.mission().clock_tolerance)
}

/// The header of its recording.
pub(crate) fn header() -> Header {
    let facts = [("scenario", "by hand"), ("seed", "7"), ("policy", "path")];
    Header {
        start_unix_ns: 1_760_000_000_000_000_000,
        terrain: terrain(),
        origin: ORIGIN,
        prior: prior(),
        scenario: "# Süd-West\nseed = 7\n".into(),
        earth: None,
        run: facts.into_iter().map(|(name, value)| (name.into(), value.into())).collect(),
    }
}

impl Episode {
    /// Runs it; the second robot is silent for a while and returns.
    pub(crate) fn play() -> Self {
        let mission = Mission::new(CoordinatorConfig {
            limits: limits(),
            terrain: terrain(),
            prior: prior(),
            subjects: None,
            detection_threshold: 0.95,
            robots: ROBOTS.to_vec(),
            speeds_meters_per_second: vec![1.0; 2],
            heartbeat: Duration::from_secs(1),
            lost_after: Duration::from_secs(4),
            belief_period: Duration::from_secs(5),
            max_observations: SyncReply::MAX_OBSERVATIONS,
        });
        let mut episode = Self { records: Vec::new(), mission };
        for half in 0..2 * SECONDS {
            let now = seconds(half as f64 / 2.0);
            for robot in ROBOTS {
                episode.tell(now, robot, half);
            }
            while episode.mission.wake_at() <= now {
                episode.handle(episode.mission.wake_at(), Event::Woke);
            }
        }
        let end = seconds(SECONDS as f64);
        let last = episode.mission.finish(end);
        episode.keep(end, last);
        episode
    }

    /// The messages of a robot in a half second.
    fn tell(&mut self, now: MissionTime, robot: RobotId, half: u64) {
        if robot == ROBOTS[1] && (10..24).contains(&half) {
            return;
        }
        let mut say = |message| {
            self.handle(now, Event::Received { from: Participant::Robot(robot), message });
        };
        say(Message::Observation(Arc::new(observation(now, robot, half))));
        if half.is_multiple_of(6) {
            say(Message::Intent(intent(now, robot, half)));
        }
        if half.is_multiple_of(4) {
            say(heartbeat(now, robot, half));
        }
    }

    fn handle(&mut self, now: MissionTime, event: Event<Message>) {
        let outcome = self.mission.react(now, event);
        self.keep(now, outcome);
    }

    fn keep(&mut self, now: MissionTime, outcome: Outcome) {
        self.records.extend(outcome.records.into_iter().map(|record| (now, record)));
    }

    /// Records it.
    pub(crate) fn record(&self, path: &Path) {
        let mut recorder = Recorder::create(path, header()).unwrap();
        for (now, record) in &self.records {
            recorder.record(*now, record).unwrap();
        }
        let found = self.mission.declared().count().to_string();
        recorder.finish(BTreeMap::from([("found".into(), found)])).unwrap();
    }

    /// Number of records for which this holds.
    pub(crate) fn count(&self, is_so: impl Fn(&Record) -> bool) -> u64 {
        self.records.iter().filter(|(_, record)| is_so(record)).count() as u64
    }
}

fn cell(number: u64) -> Cell {
    let number = u32::try_from(number).unwrap();
    terrain().grid().cell_numbered(number).unwrap()
}

/// Robot 1 observes a false object for some seconds and then an empty cell; robot 2 observes the object.
fn observation(now: MissionTime, robot: RobotId, half: u64) -> Observation {
    let (seen, value) =
        if robot == ROBOTS[1] { (OBJECT, 1.0) } else { (MIRAGE, if half < 12 { 1.1 } else { -0.25 }) };
    let readings = [(u64::from(seen), value), (0, 0.125), (23, -0.0625)];
    let readings = readings.map(|(number, value)| Reading { cell: cell(number), value, variance: 0.5 });
    let (sequence, from) = (half - if robot == ROBOTS[1] && half >= 24 { 14 } else { 0 }, cell(half / 2 % 6));
    Observation {
        origin: Origin::first(robot),
        sequence,
        time_ns: now.0,
        from,
        readings: readings.to_vec(),
        positions: Box::default(),
    }
}

fn intent(now: MissionTime, robot: RobotId, half: u64) -> Intent {
    Intent { robot, incarnation: 0, decision: half, time_ns: now.0, path: (0..half % 5).map(cell).collect() }
}

fn heartbeat(now: MissionTime, robot: RobotId, half: u64) -> Message {
    Message::Heartbeat(Heartbeat {
        robot,
        time_ns: now.0,
        activity: Activity::Searching,
        cell: cell(half / 2 % 6),
        path_meters: half as f64,
        intent: intent(now, robot, half / 6 * 6),
        versions: Versions::default(),
        digest: prior().digest(),
        directive: Directive::default(),
    })
}

#[test]
fn the_episode_meets_a_loss_a_return_and_a_withdrawal() {
    let episode = Episode::play();
    let statuses = || {
        episode.records.iter().filter_map(|(_, record)| match record {
            Record::Status(status) => Some(status),
            _ => None,
        })
    };
    let mut alive: Vec<usize> = statuses().map(|status| status.alive.len()).collect();
    alive.dedup();
    assert_eq!(alive, [1, 2, 1, 2]);
    let mut declared: Vec<Vec<u32>> = statuses()
        .map(|status| status.declared.iter().map(|object| object.cell.number()).collect())
        .collect();
    declared.dedup();
    assert_eq!(declared, [vec![], vec![MIRAGE], vec![MIRAGE, OBJECT], vec![OBJECT]]);
}
