//! What a robot does when a person, by way of the coordinator or of another robot, pauses, marks or adds to the search.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::Arc;

use dragnet_agent::agent::{Action, Agent, AgentConfig};
use dragnet_proto::command::Mark;
use dragnet_proto::directive::Directive;
use dragnet_proto::message::{Activity, Message, MissionStatus};
use dragnet_proto::state_machine::Event;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::observation::{Observation, Origin, RobotId, Source};

const SECOND: u64 = 1_000_000_000;
const ROBOT: RobotId = RobotId::FIRST;

/// A robot on a map whose two western columns are searched, and whose eastern ones are only crossed.
struct Field {
    scenario: Scenario,
    robot: Agent,
}

impl Field {
    fn new(mission: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("map.txt"), "..,,,,\n..,,,,\n..,,,,\n").unwrap();
        let text = format!(
            "name = 'a'\nmap.file = 'map.txt'\nsensor.radius = 1\nobjects.density = 0.2\n[mission]\n{mission}\n"
        );
        let scenario = Scenario::from_text(&folder.path().join("a.toml"), text).unwrap();
        let robot = Agent::new(AgentConfig::of_team(&scenario, 0).remove(0));
        Self { scenario, robot }
    }

    fn cell(&self, number: u32) -> Cell {
        self.scenario.terrain().grid().cell_numbered(number).unwrap()
    }

    fn at(seconds: u64) -> MissionTime {
        MissionTime(seconds * SECOND)
    }

    fn sense(&mut self, seconds: u64, number: u32) -> Vec<Action> {
        let cell = self.cell(number);
        self.robot.react(Self::at(seconds), Event::Sensed { cell, readings: Vec::new() })
    }

    fn hear(&mut self, seconds: u64, message: Message) -> Vec<Action> {
        self.robot.react(Self::at(seconds), Event::Received { from: Participant::Coordinator, message })
    }

    /// The coordinator says how a person has ordered it.
    fn order(&mut self, seconds: u64, number: u64, is_paused: bool, added: &[u32]) -> Vec<Action> {
        let added = added.iter().map(|&number| self.cell(number)).collect();
        self.hear(
            seconds,
            Message::MissionStatus(MissionStatus {
                time_ns: seconds * SECOND,
                declared: Vec::new(),
                expected_remaining: 1.0,
                alive: vec![ROBOT],
                observations: 0,
                versions: Vec::new(),
                digest: Digest(0),
                directive: Directive { number, is_paused, added },
                doubled: Vec::new(),
            }),
        )
    }
}

fn route(actions: &[Action]) -> Option<&[Cell]> {
    actions.iter().find_map(|action| match action {
        Action::Follow(route) => Some(route.as_slice()),
        _ => None,
    })
}

/// The directive and the activity of the heartbeat among what is said.
fn beat(actions: &[Action]) -> (Directive, Activity) {
    let said = actions.iter().find_map(|action| match action {
        Action::Publish(_, Message::Heartbeat(beat)) => Some((beat.directive.clone(), beat.activity)),
        _ => None,
    });
    said.unwrap()
}

#[test]
fn a_paused_robot_stays_says_so_and_goes_on_when_told() {
    let mut field = Field::new("budget_seconds = 1e6");
    assert!(!route(&field.sense(0, 0)).unwrap().is_empty());
    let paused = field.order(1, 5, true, &[]);
    assert_eq!(route(&paused), Some(&[][..]));
    assert!(paused.iter().any(
        |action| matches!(action, Action::Publish(_, Message::Intent(intent)) if intent.path.is_empty())
    ));
    assert_eq!(field.order(2, 5, true, &[]), [], "what is known is no news");
    assert_eq!(field.order(2, 4, false, &[]), [], "an older order comes late");
    assert_eq!(route(&field.sense(3, 1)), None, "it looks, and does not go");
    let wake = field.robot.wake_at();
    let (directive, activity) = beat(&field.robot.react(wake, Event::Woke));
    assert_eq!((directive.number, directive.is_paused, activity), (5, true, Activity::Paused));
    assert!(!route(&field.order(60, 6, false, &[])).unwrap().is_empty());
    assert_eq!(field.robot.activity(), Activity::Searching);
}

#[test]
fn a_robot_that_starts_into_a_pause_waits() {
    let mut field = Field::new("budget_seconds = 1e6");
    assert_eq!(route(&field.order(0, 5, true, &[])), None, "it does not know yet where it is");
    assert_eq!(route(&field.sense(1, 0)), Some(&[][..]));
    assert_eq!(field.robot.activity(), Activity::Paused);
    assert!(!route(&field.order(2, 6, false, &[])).unwrap().is_empty());
}

#[test]
fn a_pause_does_not_outlast_the_budget() {
    let mut field = Field::new("budget_seconds = 100.0");
    field.sense(0, 0);
    field.order(1, 5, true, &[]);
    while field.robot.wake_at() < Field::at(120) {
        let now = field.robot.wake_at();
        field.robot.react(now, Event::Woke);
    }
    assert_eq!(field.robot.activity(), Activity::Spent);
}

#[test]
fn cells_that_a_person_adds_are_searched_and_end_a_rest() {
    let mut field = Field::new("budget_seconds = 1e6\nstop_when_expected_remaining = 2.0");
    field.sense(0, 0);
    assert_eq!(field.robot.activity(), Activity::Cleared, "little enough is expected");
    let added: Vec<u32> = vec![2, 3, 4, 5, 8, 9, 10, 11];
    assert!(field.robot.belief().probability(field.cell(3)).abs() < 1e-12);
    let actions = field.order(1, 0, false, &added);
    assert!(!route(&actions).unwrap().is_empty(), "more is expected now");
    assert!((field.robot.belief().probability(field.cell(3)) - 0.2).abs() < 1e-9);
    assert!((field.robot.belief().probability(field.cell(0)) - 0.2).abs() < 1e-9);
    assert!(field.robot.belief().probability(field.cell(14)).abs() < 1e-12, "and nowhere else");
}

#[test]
fn a_mark_by_hand_counts_once_and_is_no_teammate() {
    let mut field = Field::new("budget_seconds = 1e6");
    field.sense(0, 0);
    let cell = field.cell(7);
    let mark = Message::Observation(Arc::new(Observation {
        origin: Origin { source: Source::Operator, incarnation: 3 },
        sequence: 0,
        time_ns: 3,
        from: cell,
        readings: vec![Mark::Clue.reading(cell)],
    }));
    let before = field.robot.belief().log_odds_nats(cell);
    let kept = field.hear(1, mark.clone());
    assert!(matches!(kept[..], [Action::Keep(_)]), "{kept:?}");
    assert_eq!(field.hear(2, mark), []);
    let moved = field.robot.belief().log_odds_nats(cell) - before;
    assert!((moved - Mark::STRENGTH_NATS).abs() < 1e-9, "{moved}");
}
