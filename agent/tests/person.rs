//! A robot's reactions to an operator who pauses, marks or extends the search, through the coordinator or another
//! robot.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::Arc;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::command::Mark;
use dragnet_proto::directive::Directive;
use dragnet_proto::message::{Activity, Message, MissionStatus};
use dragnet_proto::state_machine::{Effects, Event};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::observation::{Observation, Origin, RobotId, Source, Versions};

const SECOND: u64 = 1_000_000_000;
const ROBOT: RobotId = RobotId::FIRST;

/// A robot on a map whose two western columns are searched, and whose eastern ones are only traversable.
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

    fn sense(&mut self, seconds: u64, number: u32) -> Effects<Message> {
        let cell = self.cell(number);
        self.robot.react(Self::at(seconds), Event::Sensed { cell, readings: Vec::new() })
    }

    fn receive(&mut self, seconds: u64, message: Message) -> Effects<Message> {
        self.robot.react(Self::at(seconds), Event::Received { from: Participant::Coordinator, message })
    }

    /// The coordinator publishes the operator's directive.
    fn order(&mut self, seconds: u64, number: u64, is_paused: bool, added: &[u32]) -> Effects<Message> {
        let added = added.iter().map(|&number| self.cell(number)).collect();
        self.receive(
            seconds,
            Message::MissionStatus(MissionStatus {
                time_ns: seconds * SECOND,
                declared: Vec::new(),
                expected_remaining: 1.0,
                alive: vec![ROBOT],
                observations: 0,
                versions: Versions::default(),
                digest: Digest(0),
                directive: Directive { number, is_paused, added },
                doubled: Vec::new(),
            }),
        )
    }
}

fn is_nothing(effects: &Effects<Message>) -> bool {
    let Effects { wake_at, activity, .. } = *effects;
    *effects == Effects { wake_at, activity, ..Effects::default() }
}

/// The directive and the activity of the published heartbeat.
fn heartbeat(effects: &Effects<Message>) -> (Directive, Activity) {
    let said = effects.published.iter().find_map(|(_, message)| match message {
        Message::Heartbeat(heartbeat) => Some((heartbeat.directive.clone(), heartbeat.activity)),
        _ => None,
    });
    said.unwrap()
}

#[test]
fn a_paused_robot_stays_and_reports_it_until_resumed() {
    let mut field = Field::new("budget_seconds = 1e6");
    assert!(!field.sense(0, 0).route.unwrap().is_empty());
    let paused = field.order(1, 5, true, &[]);
    assert_eq!(paused.route, Some(Vec::new()));
    let is_told = |message: &Message| matches!(message, Message::Intent(intent) if intent.path.is_empty());
    assert!(paused.published.iter().any(|(_, message)| is_told(message)));
    assert!(is_nothing(&field.order(2, 5, true, &[])), "what is known is no news");
    assert!(is_nothing(&field.order(2, 4, false, &[])), "an older order comes late");
    assert_eq!(field.sense(3, 1).route, None, "it looks, and does not go");
    let wake = field.robot.wake_at();
    let (directive, activity) = heartbeat(&field.robot.react(wake, Event::Woke));
    assert_eq!((directive.number, directive.is_paused, activity), (5, true, Activity::Paused));
    assert!(!field.order(60, 6, false, &[]).route.unwrap().is_empty());
    assert_eq!(field.robot.activity(), Activity::Searching);
}

#[test]
fn a_robot_that_starts_into_a_pause_waits() {
    let mut field = Field::new("budget_seconds = 1e6");
    assert_eq!(field.order(0, 5, true, &[]).route, None, "it does not know yet where it is");
    assert_eq!(field.sense(1, 0).route, Some(Vec::new()));
    assert_eq!(field.robot.activity(), Activity::Paused);
    assert!(!field.order(2, 6, false, &[]).route.unwrap().is_empty());
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
fn cells_that_the_operator_adds_are_searched_and_end_a_rest() {
    let mut field = Field::new("budget_seconds = 1e6\nstop_when_expected_remaining = 2.0");
    field.sense(0, 0);
    assert_eq!(field.robot.activity(), Activity::Cleared, "little enough is expected");
    let added: Vec<u32> = vec![2, 3, 4, 5, 8, 9, 10, 11];
    assert!(field.robot.belief().probability(field.cell(3)).abs() < 1e-12);
    let effects = field.order(1, 0, false, &added);
    assert!(!effects.route.unwrap().is_empty(), "more is expected now");
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
    let kept = field.receive(1, mark.clone());
    assert_eq!((kept.kept.len(), &kept.published[..], &kept.route), (1, &[][..], &None), "{kept:?}");
    assert!(is_nothing(&field.receive(2, mark)));
    let moved = field.robot.belief().log_odds_nats(cell) - before;
    assert!((moved - Mark::STRENGTH_NATS).abs() < 1e-9, "{moved}");
}
