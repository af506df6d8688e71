//! The behavior of a robot whose teammates plan to observe all that is left.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::message::{Activity, Audience, Heartbeat, Intent, Message};
use dragnet_proto::state_machine::{Effects, Event};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::observation::{Observation, Origin, RobotId, Versions};

const SECOND: u64 = 1_000_000_000;
const MATE: RobotId = RobotId::new(2).unwrap();

/// Robots 1 and 2 on a corridor of 12 cells, 15 s each. Objects can be in the last three; robot 1 starts in the first.
struct Field {
    scenario: Scenario,
    robot: Agent,
    mate_sequence: u64,
}

fn at(seconds: u64) -> MissionTime {
    MissionTime(seconds * SECOND)
}

impl Field {
    fn new() -> Self {
        Self::with_expected(0.0)
    }

    /// The search may end when this number of objects is expected to remain.
    fn with_expected(expected: f64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("map.txt"), "............\n").unwrap();
        std::fs::write(folder.path().join("prior.csv"), "0,0,0,0,0,0,0,0,0,0.1,0.1,0.1\n").unwrap();
        let text = format!(
            "name = 'a'\nmap.file = 'map.txt'\nprior.file = 'prior.csv'\nsensor.radius = 1\nobjects.count = 1\n\
                    robots.count = 2\nmission = {{ budget_seconds = 1e6, stop_when_expected_remaining = {expected:?} }}\n"
        );
        let scenario = Scenario::from_text(&folder.path().join("a.toml"), text).unwrap();
        let robot = Agent::new(AgentConfig::of_team(&scenario, 0).remove(0));
        Self { scenario, robot, mate_sequence: 0 }
    }

    fn cell(&self, number: u32) -> Cell {
        self.scenario.terrain().grid().cell_numbered(number).unwrap()
    }

    fn start(&mut self) -> Effects<Message> {
        let readings = Vec::new();
        self.robot.react(at(0), Event::Sensed { cell: self.cell(0), readings })
    }

    fn receive(&mut self, seconds: u64, message: Message) -> Effects<Message> {
        self.robot.react(at(seconds), Event::Received { from: Participant::Robot(MATE), message })
    }

    /// The teammate is about to enter these cells.
    fn plan(&mut self, seconds: u64, decision: u64, path: impl IntoIterator<Item = u32>) -> Effects<Message> {
        let path = path.into_iter().map(|number| self.cell(number)).collect();
        let time_ns = at(seconds).0;
        self.receive(
            seconds,
            Message::Intent(Intent { robot: MATE, incarnation: 0, decision, time_ns, path }),
        )
    }

    /// The teammate has entered a cell and observed that these are empty.
    fn walk(&mut self, seconds: u64, from: u32, empty: impl IntoIterator<Item = u32>) -> Effects<Message> {
        let reading = |number: u32| {
            let variance = self.scenario.sensor().variance(number.abs_diff(from));
            Reading { cell: self.cell(number), value: 0.0, variance }
        };
        let observation = Observation {
            origin: Origin::first(MATE),
            sequence: self.mate_sequence,
            time_ns: at(seconds).0,
            from: self.cell(from),
            readings: empty.into_iter().map(reading).collect(),
            positions: Box::default(),
        };
        self.mate_sequence += 1;
        self.receive(seconds, Message::Observation(observation.into()))
    }

    fn wake(&mut self, seconds: u64) -> Effects<Message> {
        self.robot.react(at(seconds), Event::Woke)
    }
}

fn reported(effects: &Effects<Message>) -> Option<Activity> {
    effects.published.iter().find_map(|said| match said {
        (Audience::All, Message::Heartbeat(beat)) => Some(beat.activity),
        _ => None,
    })
}

#[test]
fn it_waits_while_a_plan_covers_all_that_is_left_and_reports_it() {
    let mut field = Field::new();
    field.plan(0, 1, 8..12);
    let effects = field.start();
    assert_eq!(effects.route, Some(Vec::new()), "{effects:?}");
    assert_eq!(field.robot.activity(), Activity::Waiting);
    assert!(!Activity::Waiting.is_rest(), "the search is not over");
    assert_eq!(reported(&field.wake(10)), Some(Activity::Waiting));
    assert_eq!(field.robot.decisions(), 0, "to wait is no waypoint");
}

#[test]
fn it_helps_in_unplanned_cells_though_a_teammate_is_nearer() {
    let mut field = Field::new();
    field.plan(0, 1, [9]);
    let effects = field.start();
    // Cells 9 and 10 are planned; only 11 is left, and the teammate is next to it. Its sensor radius is one cell.
    assert_eq!(effects.route, Some(vec![field.cell(1)]));
    assert_eq!(field.robot.activity(), Activity::Searching);
    let further = field.robot.react(at(15), Event::Sensed { cell: field.cell(1), readings: Vec::new() });
    assert_eq!(further.route, Some(vec![field.cell(2)]));
    field.plan(16, 2, 9..12);
    let further = field.robot.react(at(30), Event::Sensed { cell: field.cell(2), readings: Vec::new() });
    assert_eq!(further.route, Some(Vec::new()), "the mate sees to that, too");
    assert_eq!(field.robot.activity(), Activity::Waiting);
}

#[test]
fn when_the_plan_is_walked_nothing_is_left_and_it_rests() {
    let mut field = Field::new();
    field.plan(0, 1, 8..12);
    field.start();
    for (seconds, cell) in [(15, 8), (30, 9), (45, 10)] {
        field.walk(seconds, cell, cell - 1..=cell + 1);
        field.wake(seconds + 2);
        assert_eq!(field.robot.activity(), Activity::Waiting);
    }
    field.walk(60, 11, 10..12);
    field.wake(80);
    assert_eq!(field.robot.activity(), Activity::Cleared);
    assert!(field.robot.activity().is_rest());
}

#[test]
fn on_its_path_too_it_rests_once_the_search_is_complete() {
    for (expected, is_over) in [(0.05, true), (0.0, false)] {
        let mut field = Field::with_expected(expected);
        let path = field.start().route.unwrap();
        assert!(path.len() > 5, "{path:?}");
        for cell in 9..12 {
            field.walk(10, cell, [cell]);
        }
        let effects = field.robot.react(at(15), Event::Sensed { cell: path[0], readings: Vec::new() });
        assert_eq!(effects.route, is_over.then(Vec::new), "{expected}");
        assert_eq!(field.robot.activity() == Activity::Cleared, is_over, "{expected}");
    }
}

#[test]
fn it_goes_where_a_plan_that_was_changed_no_longer_leads() {
    let mut field = Field::new();
    field.plan(0, 1, 8..12);
    field.start();
    field.plan(20, 2, []);
    assert!(field.robot.wake_at() <= at(22), "it thinks again at once: {:?}", field.robot.wake_at());
    let effects = field.wake(22);
    assert!(effects.route.as_ref().is_some_and(|route| route.len() >= 8), "{effects:?}");
}

#[test]
fn lost_and_stalled_robots_are_waited_for_no_longer() {
    for has_subscriber in [false, true] {
        let mut field = Field::new();
        field.plan(0, 1, 8..12);
        field.start();
        if has_subscriber {
            let heartbeat = |seconds: u64, field: &Field| {
                Message::Heartbeat(Heartbeat {
                    robot: MATE,
                    time_ns: at(seconds).0,
                    activity: Activity::Searching,
                    cell: field.cell(7),
                    path_meters: 0.0,
                    intent: Intent {
                        robot: MATE,
                        incarnation: 0,
                        decision: 1,
                        time_ns: 0,
                        path: (8..12).map(|number| field.cell(number)).collect(),
                    },
                    versions: Versions::default(),
                    digest: Digest(0),
                    directive: dragnet_proto::directive::Directive::default(),
                })
            };
            for seconds in (10..=110).step_by(10) {
                let beat = heartbeat(seconds, &field);
                field.receive(seconds, beat);
                field.wake(seconds);
                assert_eq!(field.robot.activity(), Activity::Waiting, "at {seconds} s");
            }
            for seconds in (120..=180).step_by(10) {
                let beat = heartbeat(seconds, &field);
                field.receive(seconds, beat);
                field.wake(seconds);
            }
        } else {
            field.wake(5);
            field.wake(15);
            field.robot.react(at(20), Event::Lost(MATE));
            let wake_at = field.robot.wake_at();
            assert!(wake_at < at(22), "{wake_at:?}");
            field.robot.react(wake_at, Event::Woke);
        }
        assert_eq!(field.robot.activity(), Activity::Searching, "heard: {has_subscriber}");
    }
}

#[test]
fn it_sleeps_while_nothing_changes_and_thinks_no_more_often_than_it_could_move() {
    let mut field = Field::new();
    field.plan(0, 1, 8..12);
    field.start();
    assert_eq!(field.robot.wake_at(), at(5), "its turn to give a sign of life");
    // Many messages.
    for _ in 0..1000 {
        field.walk(1, 7, [7]);
    }
    field.wake(5);
    field.wake(15);
    let thinks_at = field.robot.wake_at();
    // A diagonal move over cells of 30 m, at 2 m/s.
    assert!((thinks_at.as_seconds() - 15.0 * 2.0_f64.sqrt()).abs() < 1e-6, "{thinks_at:?}");
    field.robot.react(thinks_at, Event::Woke);
    assert_eq!(field.robot.wake_at(), at(25), "and then sleeps on");
}
