//! The behavior of a robot that keeps apart from its teammate.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::message::{Activity, Intent, Message};
use dragnet_proto::state_machine::{Effects, Event};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::{Cell, Position};
use dragnet_search::observation::{Observation, Origin, RobotId};

const SECOND: u64 = 1_000_000_000;
const MATE: RobotId = RobotId::new(2).unwrap();

/// Robots 1 and 2, 15 s a cell, on a map whose only object can be where its `prior` is above 0.
struct Field {
    scenario: Scenario,
    robot: Agent,
    mate_sequence: u64,
}

/// The object is in the east, and seen from one cell alone.
const OPEN: (&str, &str) = (".....##\n.......\n.....##\n", "0,0,0,0,0,0,0\n0,0,0,0,0,0,0.3\n0,0,0,0,0,0,0\n");
/// A corridor with a bay; the object is in the west.
const CORRIDOR: (&str, &str) = ("###.###\n.......\n", "0,0,0,0,0,0,0\n0.3,0,0,0,0,0,0\n");

impl Field {
    fn new((map, prior): (&str, &str), separation_meters: f64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("map.txt"), map).unwrap();
        std::fs::write(folder.path().join("prior.csv"), prior).unwrap();
        let text = format!(
            "name = 'a'\nmap.file = 'map.txt'\nprior.file = 'prior.csv'\nsensor.radius = 1\nobjects.count = 1\n\
             robots = {{ count = 2, separation_meters = {separation_meters:?} }}\nmission.budget_seconds = 1e6\n"
        );
        let scenario = Scenario::from_text(&folder.path().join("a.toml"), text).unwrap();
        let robot = Agent::new(AgentConfig::of_team(&scenario, 0).remove(0));
        Self { scenario, robot, mate_sequence: 0 }
    }

    fn cell(&self, (row, column): (u32, u32)) -> Cell {
        self.scenario.terrain().grid().cell(Position { row, column }).unwrap()
    }

    fn react(&mut self, seconds: u64, event: Event<Message>) -> Effects<Message> {
        self.robot.react(MissionTime(seconds * SECOND), event)
    }

    /// The route that the robot takes when it comes to a cell; `None` if it goes on.
    fn comes_to(&mut self, seconds: u64, cell: (u32, u32)) -> Option<Vec<(u32, u32)>> {
        let event = Event::Sensed { cell: self.cell(cell), readings: Vec::new() };
        let effects = self.react(seconds, event);
        self.route(effects)
    }

    fn wakes(&mut self, seconds: u64) -> Option<Vec<(u32, u32)>> {
        let effects = self.react(seconds, Event::Woke);
        self.route(effects)
    }

    fn route(&self, effects: Effects<Message>) -> Option<Vec<(u32, u32)>> {
        let position = |cell: Cell| {
            let Position { row, column } = self.scenario.terrain().grid().position(cell);
            (row, column)
        };
        effects.route.map(|route| route.into_iter().map(position).collect())
    }

    /// The teammate is in a cell.
    fn mate_comes_to(&mut self, seconds: u64, cell: (u32, u32)) {
        let observation = Observation {
            origin: Origin::first(MATE),
            sequence: self.mate_sequence,
            time_ns: seconds * SECOND,
            from: self.cell(cell),
            readings: Vec::new(),
            positions: Box::default(),
        };
        self.mate_sequence += 1;
        let message = Message::Observation(observation.into());
        self.react(seconds, Event::Received { from: Participant::Robot(MATE), message });
    }

    /// It is about to enter these cells.
    fn mate_plans(&mut self, seconds: u64, decision: u64, path: &[(u32, u32)]) {
        let path = path.iter().map(|&cell| self.cell(cell)).collect();
        let intent = Intent { robot: MATE, incarnation: 0, decision, time_ns: seconds * SECOND, path };
        let message = Message::Intent(intent);
        self.react(seconds, Event::Received { from: Participant::Robot(MATE), message });
    }
}

/// Along row 1 from column 1 to 5: from there the object's cell is in sight.
const STRAIGHT: [(u32, u32); 5] = [(1, 1), (1, 2), (1, 3), (1, 4), (1, 5)];

#[test]
fn it_goes_around_a_teammate_that_stands() {
    for separation_meters in [0.0, 20.0] {
        let mut field = Field::new(OPEN, separation_meters);
        field.mate_comes_to(0, (1, 3));
        let route = field.comes_to(1, (1, 0)).unwrap();
        assert_eq!(route.last(), Some(&(1, 5)), "{route:?}");
        assert_eq!(route.contains(&(1, 3)), separation_meters == 0.0, "{route:?}");
    }
}

#[test]
fn it_decides_again_before_it_meets_a_teammate_that_has_stopped() {
    let mut field = Field::new(OPEN, 20.0);
    assert_eq!(field.comes_to(0, (1, 0)).unwrap(), STRAIGHT);
    assert_eq!(field.comes_to(15, (1, 1)), None, "nobody is in its way");
    field.mate_comes_to(20, (1, 3));
    let route = field.comes_to(30, (1, 2)).unwrap();
    assert!(!route.contains(&(1, 3)) && route.last() == Some(&(1, 5)), "{route:?}");
}

#[test]
fn it_makes_way_for_who_decided_before_it_and_goes_on_after() {
    let mut field = Field::new(CORRIDOR, 20.0);
    field.mate_comes_to(0, (0, 1));
    field.mate_plans(0, 0, &[(0, 2), (0, 3), (0, 4), (0, 5)]);
    assert_eq!(field.comes_to(1, (0, 3)).unwrap(), [(1, 3)]);
    assert_eq!(field.robot.activity(), Activity::GivingWay);
    assert_eq!(field.comes_to(16, (1, 3)).unwrap(), []);
    assert_eq!(field.robot.activity(), Activity::Waiting);
    field.mate_comes_to(17, (0, 2));
    assert_eq!(field.wakes(40), None, "the teammate is about to pass");
    field.mate_comes_to(45, (0, 3));
    field.mate_comes_to(60, (0, 4));
    field.mate_comes_to(75, (0, 5));
    assert_eq!(field.wakes(100).unwrap(), [(0, 3), (0, 2), (0, 1)]);
    assert_eq!(field.robot.activity(), Activity::Searching);
}

/// It does not know of each other's plan until it is under way: who decided first goes on.
#[test]
fn of_two_that_meet_the_one_that_decided_later_makes_way() {
    for (decided, gives_way) in [(0, true), (2, false)] {
        let mut field = Field::new(CORRIDOR, 20.0);
        field.comes_to(1, (0, 5)).unwrap();
        field.comes_to(16, (0, 4));
        field.mate_comes_to(decided, (0, 1));
        field.mate_plans(decided, 0, &[(0, 2), (0, 3), (0, 4), (0, 5)]);
        let route = field.comes_to(31, (0, 3));
        assert_eq!(route == Some(vec![(1, 3)]), gives_way, "decided at {decided} s: {route:?}");
    }
}

#[test]
fn a_robot_that_is_held_tries_another_way() {
    for separation_meters in [0.0, 20.0] {
        let mut field = Field::new(OPEN, separation_meters);
        assert_eq!(field.comes_to(0, (1, 0)).unwrap(), STRAIGHT);
        assert_eq!(field.wakes(60), None, "it may only be slow");
        let is_held = separation_meters > 0.0;
        let route = field.wakes(64);
        assert_eq!(route.is_some(), is_held);
        assert!(route.is_none_or(|route| !route.contains(&(1, 1)) && route.last() == Some(&(1, 5))));
    }
}
