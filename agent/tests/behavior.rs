//! A robot's reactions to events, without clock or network.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;
use std::sync::Arc;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::message::{Activity, Audience, Intent, Message};
use dragnet_proto::state_machine::{Effects, Event};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::{Cell, Position};
use dragnet_search::evidence::Reading;
use dragnet_search::line_of_sight::LineOfSight;
use dragnet_search::observation::{Observation, Origin, RobotId};

const SECOND: u64 = 1_000_000_000;

/// Robots 1 and 2 of a team on an open map of 12 x 12 cells; robot 2 delays its first decision by a second.
struct Field {
    scenario: Scenario,
    robot: Agent,
}

impl Field {
    fn new(number: usize, mission: &str) -> Self {
        Self::with_sensor(number, mission, "radius = 2")
    }

    fn with_sensor(number: usize, mission: &str, sensor: &str) -> Self {
        let text = format!(
            "name = \"field\"\n[map]\nshape = \"all_traversable\"\nrows = 12\ncolumns = 12\n[sensor]\n{sensor}\n\
             [objects]\ncount = 3\n[robots]\ncount = 2\n[mission]\nstart_stagger_seconds = 1.0\n{mission}\n"
        );
        let scenario = Scenario::from_text(Path::new("field.toml"), text).unwrap();
        let robot = Agent::new(AgentConfig::of_team(&scenario, 0).remove(number - 1));
        Self { scenario, robot }
    }

    fn cell(&self, row: u32, column: u32) -> Cell {
        self.scenario.terrain().grid().cell(Position { row, column }).unwrap()
    }

    /// The robot is in a cell whose readings are all empty.
    fn sense(&mut self, seconds: u64, cell: Cell) -> Effects<Message> {
        let readings = vec![Reading { cell, value: 0.0, variance: 0.001 }];
        self.robot.react(MissionTime(seconds * SECOND), Event::Sensed { cell, readings })
    }

    fn receive(&mut self, seconds: u64, from: u16, message: Message) -> Effects<Message> {
        let from = Participant::Robot(RobotId::new(from).unwrap());
        self.robot.react(MissionTime(seconds * SECOND), Event::Received { from, message })
    }

    fn wake(&mut self, seconds: u64) -> Effects<Message> {
        self.robot.react(MissionTime(seconds * SECOND), Event::Woke)
    }
}

fn said(effects: &Effects<Message>) -> Vec<&Message> {
    let to_all = effects.published.iter().filter(|(audience, _)| *audience == Audience::All);
    to_all.map(|(_, message)| message).collect()
}

const ENDLESS: &str = "budget_seconds = 1e6";

#[test]
fn an_observation_is_published_and_followed_by_a_plan() {
    let mut field = Field::new(1, ENDLESS);
    let effects = field.sense(0, field.cell(0, 0));
    let path = effects.route.clone().unwrap();
    match said(&effects)[..] {
        [Message::Observation(observation), Message::Intent(intent)] => {
            assert_eq!((observation.origin, observation.sequence), (Origin::first(RobotId::FIRST), 0));
            assert_eq!(*intent.path, path);
        }
        ref other => panic!("{other:?}"),
    }
    // On the path it only observes; at the waypoint it decides anew.
    for (step, &cell) in path.iter().enumerate() {
        let effects = field.sense(15 * (step as u64 + 1), cell);
        assert_eq!(effects.route.is_some(), step + 1 == path.len());
    }
    assert_eq!(field.robot.decisions(), 2);
}

#[test]
fn the_second_robot_waits_until_it_can_know_the_first_ones_plan() {
    let mut field = Field::new(2, ENDLESS);
    assert_eq!(field.sense(0, field.cell(0, 0)).route, None);
    assert_eq!(field.robot.wake_at(), MissionTime(SECOND));
    assert!(field.wake(1).route.is_some_and(|route| !route.is_empty()));
}

/// Two robots in one cell: the second one's path, once it knows the first one's plan, if it does.
fn path_of_second(plan_heard_at: Option<u64>, made_at: u64) -> (Vec<Cell>, Option<Vec<Cell>>) {
    let mut field = Field::new(2, ENDLESS);
    let start = field.cell(0, 0);
    field.sense(0, start);
    let blind = Field::new(2, ENDLESS).decided_alone();
    let plan = Message::Intent(Intent {
        robot: RobotId::FIRST,
        incarnation: 0,
        decision: 1,
        time_ns: made_at * SECOND,
        path: blind.clone().into(),
    });
    if plan_heard_at == Some(0) {
        field.receive(0, 1, plan.clone());
    }
    let first = field.wake(1).route.unwrap();
    if let Some(late) = plan_heard_at.filter(|&time| time > 1) {
        assert_eq!(field.receive(late, 1, plan).route, None);
    }
    let next = field.sense(16, first[0]);
    (first, next.route)
}

impl Field {
    /// The second robot's path when it has received nothing.
    fn decided_alone(mut self) -> Vec<Cell> {
        self.sense(0, self.cell(0, 0));
        self.wake(1).route.unwrap()
    }
}

#[test]
fn a_plan_that_is_known_sends_the_next_robot_elsewhere() {
    let blind = Field::new(2, ENDLESS).decided_alone();
    let (first, anew) = path_of_second(Some(0), 0);
    assert_ne!(first, blind);
    assert_eq!(anew, None);
}

#[test]
fn a_plan_that_comes_late_makes_the_later_planner_decide_anew() {
    let blind = Field::new(2, ENDLESS).decided_alone();
    let (first, anew) = path_of_second(Some(10), 0);
    assert_eq!(first, blind);
    assert_ne!(anew.unwrap(), blind[1..]);
    // If it was made later, the other robot yields.
    assert_eq!(path_of_second(Some(10), 9).1, None);
}

/// Drives a robot that starts in the corner along its routes until it rests; returns what it did, in order, and its cells.
fn drive(field: &mut Field, cell_seconds: u64) -> (Vec<Activity>, Vec<Cell>) {
    let (mut cell, mut route, mut now) = (field.cell(0, 0), Vec::new(), 0);
    let (mut did, mut cells) = (Vec::new(), vec![cell]);
    for _ in 0..200 {
        if let Some(new) = field.sense(now, cell).route {
            route = new;
            did.push(field.robot.activity());
        }
        if route.is_empty() {
            return (did, cells);
        }
        (cell, now) = (route.remove(0), now + cell_seconds);
        cells.push(cell);
    }
    panic!("it never rests");
}

#[test]
fn a_robot_with_a_base_is_back_when_its_budget_ends() {
    // Cells of 30 m, 15 s each: 28 cells with a tenth in reserve, or 20 without one.
    for (mission, most) in [
        ("budget_meters = 933.4\nreturn_to_base = true", 28),
        ("budget_seconds = 300.0\nreturn_to_base = true\nbudget_reserve = 0.0", 20),
    ] {
        let mut field = Field::new(1, mission);
        let (did, cells) = drive(&mut field, 15);
        assert_eq!(did.last(), Some(&Activity::Spent));
        assert_eq!(cells.last(), cells.first());
        assert!((most - 3..=most).contains(&(cells.len() - 1)), "{} of {most} cells", cells.len() - 1);
    }
}

#[test]
fn a_robot_with_a_base_comes_home_late_rather_than_never() {
    // Twice as slow as it should be, which no reserve covers.
    let mut field = Field::new(1, "budget_seconds = 300.0\nreturn_to_base = true");
    let (did, cells) = drive(&mut field, 30);
    assert_eq!((did.last(), cells.last()), (Some(&Activity::Spent), cells.first()));
    assert!(did.contains(&Activity::Returning), "{did:?}");
    assert!(cells.len() > 8, "{cells:?}");
}

#[test]
fn a_restarted_robot_goes_back_to_where_it_started_first() {
    let mut before = Field::new(1, "budget_meters = 900.0\nreturn_to_base = true");
    let path = before.sense(0, before.cell(0, 0)).route.unwrap();
    let start = before.cell(0, 0);
    let readings = vec![Reading { cell: start, value: 0.0, variance: 0.001 }];
    let origin = Origin::first(RobotId::FIRST);
    let mut stored = vec![Arc::new(Observation {
        origin,
        sequence: 0,
        time_ns: 0,
        from: start,
        readings,
        positions: Box::default(),
    })];
    for (step, &cell) in (1..).zip(&path) {
        stored.extend(before.sense(15 * step, cell).kept);
    }
    let mut field = Field::new(1, "budget_meters = 900.0\nreturn_to_base = true");
    for observation in &stored {
        field.robot.recall(observation);
    }
    let mut route = field.sense(600, *path.last().unwrap()).route.unwrap();
    let mut now = 600;
    while let Some(&cell) = route.first() {
        now += 15;
        let effects = field.sense(now, cell);
        route = effects.route.unwrap_or_else(|| route.split_off(1));
        assert!(now < 6000, "it never rests");
        if route.is_empty() {
            assert_eq!((cell, field.robot.activity()), (start, Activity::Spent));
        }
    }
}

#[test]
fn a_budget_of_path_length_or_time_ends_the_search() {
    for (mission, moved_at) in [("budget_meters = 30.0", 15), ("budget_seconds = 15.0", 15)] {
        let mut field = Field::new(1, mission);
        let path = field.sense(0, field.cell(0, 0)).route.unwrap();
        let effects = field.sense(moved_at, path[0]);
        assert_eq!(effects.route, Some(Vec::new()), "{mission}");
        assert_eq!(field.robot.activity(), Activity::Spent);
    }
}

#[test]
fn a_robot_rests_when_nothing_is_left_and_goes_on_when_doubt_comes_back() {
    let mut field = Field::with_sensor(1, ENDLESS, "radius = 12\nnoise_variance = 0.0001");
    let clear = |field: &Field, value: f32| -> Vec<Reading> {
        let reading = |cell| Reading { cell, value, variance: 0.05 };
        field.scenario.terrain().grid().cells().map(reading).collect()
    };
    let (cell, readings) = (field.cell(6, 6), clear(&field, 0.0));
    let effects = field.robot.react(MissionTime(0), Event::Sensed { cell, readings });
    assert_eq!(effects.route, Some(Vec::new()));
    assert_eq!(field.robot.activity(), Activity::Cleared);
    let doubt = Observation {
        origin: Origin::first(RobotId::new(2).unwrap()),
        sequence: 0,
        time_ns: 0,
        from: cell,
        readings: clear(&field, 1.1),
        positions: Box::default(),
    };
    field.receive(5, 2, Message::Observation(doubt.into()));
    assert!(field.wake(10).route.is_some_and(|route| !route.is_empty()));
    assert_eq!(field.robot.activity(), Activity::Searching);
}

#[test]
fn a_robot_does_not_rest_while_its_last_observation_is_undecided() {
    let mut field = Field::with_sensor(1, ENDLESS, "radius = 12\nnoise_variance = 0.0001");
    let observe = |field: &Field, is_open: bool| -> Vec<Reading> {
        let open = field.cell(2, 2);
        let reading = |cell| {
            if cell == open && is_open {
                Reading::undecided(cell)
            } else {
                Reading { cell, value: 0.0, variance: 0.05 }
            }
        };
        field.scenario.terrain().grid().cells().map(reading).collect()
    };
    let (cell, readings) = (field.cell(6, 6), observe(&field, true));
    let effects = field.robot.react(MissionTime(0), Event::Sensed { cell, readings });
    let path = effects.route.clone().unwrap();
    assert!(!path.is_empty() && field.robot.activity() == Activity::Searching);
    let readings = observe(&field, false);
    let last = path[path.len() - 1];
    let effects = field.robot.react(MissionTime(300 * SECOND), Event::Sensed { cell: last, readings });
    assert_eq!(effects.route, Some(Vec::new()));
    assert_eq!(field.robot.activity(), Activity::Cleared);
}

#[test]
fn a_robot_that_rests_goes_on_at_once_when_it_sees_that_something_is_left() {
    let mut field = Field::with_sensor(1, ENDLESS, "radius = 12\nnoise_variance = 0.0001");
    let cell = field.cell(6, 6);
    let clear = |field: &Field, value: f32| -> Vec<Reading> {
        let reading = |cell| Reading { cell, value, variance: 0.05 };
        field.scenario.terrain().grid().cells().map(reading).collect()
    };
    let mut sees = |seconds: u64, value: f32| {
        let readings = clear(&field, value);
        let effects = field.robot.react(MissionTime(seconds * SECOND), Event::Sensed { cell, readings });
        (effects.route.as_ref().map(Vec::len), field.robot.activity())
    };
    assert_eq!(sees(0, 0.0), (Some(0), Activity::Cleared));
    assert_eq!(sees(20, 0.0), (None, Activity::Cleared), "it says nothing new");
    let (way, activity) = sees(40, 1.5);
    assert!(way > Some(0) && activity == Activity::Searching, "{way:?} {activity:?}");
}

#[test]
fn a_heartbeat_is_due_every_period_in_turn_with_the_version_vector() {
    let mut field = Field::new(1, ENDLESS);
    field.sense(0, field.cell(0, 0));
    assert_eq!(field.robot.wake_at(), MissionTime(5 * SECOND));
    let effects = field.wake(6);
    match said(&effects)[..] {
        [Message::Heartbeat(heartbeat)] => {
            assert_eq!(heartbeat.versions.len(), 1);
            assert_eq!(
                (heartbeat.versions[0].origin.source, heartbeat.versions[0].next),
                (RobotId::FIRST.into(), 1)
            );
            assert_eq!(heartbeat.digest, field.robot.belief().digest());
            assert!(!heartbeat.intent.path.is_empty());
        }
        ref other => panic!("{other:?}"),
    }
    assert_eq!(field.robot.wake_at(), MissionTime(15 * SECOND));

    let mut second = Field::new(2, ENDLESS);
    second.sense(1, second.cell(0, 0));
    assert_eq!(second.robot.wake_at(), MissionTime(10 * SECOND));
    second.wake(10);
    assert_eq!(second.robot.wake_at(), MissionTime(20 * SECOND));
}

#[test]
fn a_participant_that_joins_soon_receives_a_heartbeat() {
    let mut field = Field::new(1, ENDLESS);
    field.sense(0, field.cell(0, 0));
    field.wake(5);
    field.robot.react(MissionTime(6 * SECOND), Event::Came);
    // A 32nd of a heartbeat and half of an eighth, and then in turn again.
    assert_eq!(field.robot.wake_at(), MissionTime(6 * SECOND + SECOND * 30 / 32));
    assert!(matches!(said(&field.wake(7))[..], [Message::Heartbeat(_)]));
    assert_eq!(field.robot.wake_at(), MissionTime(15 * SECOND));
}

#[test]
fn a_robot_that_is_off_its_plan_decides_anew() {
    let mut field = Field::new(1, ENDLESS);
    field.sense(0, field.cell(0, 0));
    let astray = field.cell(11, 11);
    assert!(field.sense(15, astray).route.is_some_and(|route| !route.is_empty()));
}

#[test]
fn a_clock_that_is_set_back_by_the_first_observation_delays_no_heartbeat() {
    let mut field = Field::new(1, ENDLESS);
    let woken = field.wake(500);
    assert_eq!((woken.published, woken.route), (vec![], None));
    field.sense(0, field.cell(0, 0));
    assert_eq!(field.robot.wake_at(), MissionTime(5 * SECOND));
}

#[test]
fn a_restarted_robot_restores_its_observations_and_reuses_no_name() {
    let mut field = Field::new(1, ENDLESS);
    let mut kept = Vec::new();
    let mut keep = |effects: Effects<Message>| kept.extend(effects.kept);
    keep(field.sense(0, field.cell(0, 0)));
    let origin = Origin::first(RobotId::new(2).unwrap());
    let readings = vec![Reading { cell: field.cell(9, 9), value: 1.0, variance: 0.001 }];
    let reported = Observation {
        origin,
        sequence: 0,
        time_ns: 0,
        from: field.cell(9, 9),
        readings,
        positions: Box::default(),
    };
    keep(field.receive(5, 2, Message::Observation(reported.into())));
    keep(field.sense(10, field.cell(0, 1)));
    assert_eq!(kept.len(), 3);
    let before = field.robot.belief().digest();

    let mut again = Field::new(1, ENDLESS);
    for observation in kept {
        again.robot.recall(&observation);
    }
    assert_eq!(again.robot.belief().digest(), before);
    let effects = again.sense(60, again.cell(0, 1));
    match said(&effects)[..] {
        [Message::Observation(observation), Message::Intent(_)] => {
            let expected = Origin { source: RobotId::FIRST.into(), incarnation: 60 * SECOND };
            assert_eq!((observation.origin, observation.sequence), (expected, 0));
        }
        ref other => panic!("{other:?}"),
    }
    let heartbeat = again.wake(70);
    let way = said(&heartbeat).iter().find_map(|message| match message {
        Message::Heartbeat(heartbeat) => Some((heartbeat.path_meters, heartbeat.versions.len())),
        _ => None,
    });
    assert_eq!(way, Some((again.scenario.terrain().cell_meters(), 3)));
}

/// Its tour is not in its journal: it is a function of the observations that are.
#[test]
fn a_restarted_robot_plans_its_tour_anew_and_always_alike() {
    let of_tours = || Field::new(1, &format!("{ENDLESS}\n[robots.policy]\nname = \"tour\""));
    let mut field = of_tours();
    let mut kept = Vec::new();
    let mut route = Vec::new();
    for seconds in (0..40).step_by(5) {
        let at = if route.is_empty() { field.cell(0, 0) } else { route.remove(0) };
        let effects = field.sense(seconds, at);
        kept.extend(effects.kept);
        route = effects.route.unwrap_or(route);
    }
    assert_eq!(kept.len(), 8, "it has driven on");
    let restart = || {
        let mut again = of_tours();
        for observation in &kept {
            again.robot.recall(observation);
        }
        let at = kept[7].from;
        again.sense(60, at).route.unwrap()
    };
    let planned = restart();
    assert_eq!(planned, restart());
    // Back over what it has seen already would be a tour of a robot that has forgotten.
    let seen: Vec<Cell> = kept.iter().map(|observation| observation.from).collect();
    assert!(planned.len() > 1 && !seen.contains(planned.last().unwrap()), "{planned:?} after {seen:?}");
}

#[test]
fn a_robot_that_is_halted_stays_and_decides_anew_when_it_may_go_on() {
    let mut field = Field::new(1, ENDLESS);
    let planned = field.sense(0, field.cell(0, 0));
    assert!(planned.route.is_some_and(|route| !route.is_empty()));
    let halted = field.robot.react(MissionTime(SECOND), Event::Halted);
    let Effects { wake_at, activity, .. } = halted;
    let stays = Effects { route: Some(Vec::new()), wake_at, activity, ..Effects::default() };
    assert_eq!(halted, stays, "it says nothing");
    let released = field.robot.react(MissionTime(90 * SECOND), Event::Released);
    assert!(released.route.is_some_and(|route| !route.is_empty()));
}

#[test]
fn a_robot_whose_vehicle_cannot_enter_a_cell_goes_elsewhere() {
    let mut field = Field::new(1, ENDLESS);
    let here = field.cell(0, 0);
    let path = field.sense(0, here).route.unwrap();
    let waypoint = *path.last().unwrap();
    // What the vehicle finds in the cell that it leaves is no question.
    assert_eq!(field.sense(5, here).route, None);
    let fail = |field: &mut Field, seconds, blocked| {
        field.robot.react(MissionTime(seconds * SECOND), Event::RouteFailed { blocked });
        field.sense(seconds, here).route.unwrap()
    };
    let mut barred = vec![waypoint];
    for round in 0..4 {
        let route = fail(&mut field, 10 + round, vec![*barred.last().unwrap()]);
        assert!(
            !route.is_empty() && route.iter().all(|cell| !barred.contains(cell)),
            "{barred:?}: {route:?}"
        );
        barred.push(*route.last().unwrap());
    }
    // A vehicle that is boxed in blames no cell.
    assert!(!fail(&mut field, 20, Vec::new()).is_empty());
}

#[test]
fn a_robot_goes_to_where_its_vehicle_says_that_a_cell_is_seen_from() {
    let planned = |is_told: bool| {
        let mut field = Field::with_sensor(1, ENDLESS, "radius = 12");
        let (here, there) = (field.cell(5, 5), field.cell(5, 8));
        let grid = field.scenario.terrain().grid();
        if is_told {
            // Walls around the cell and those beside it to the east.
            let column = |cell| grid.position(cell).column;
            let line_of_sight = LineOfSight::from_fn(grid, 12, |from, offset| {
                grid.step(from, offset).is_some_and(|to| (column(from) < 8) != (column(to) < 8))
            });
            field.robot.react(MissionTime(0), Event::LineOfSight(line_of_sight));
        }
        // All else is known to be empty.
        let others = grid.cells().filter(|&cell| cell != there);
        let readings = others.map(|cell| Reading { cell, value: 0.0, variance: 0.001 }).collect();
        let route = field.robot.react(MissionTime(0), Event::Sensed { cell: here, readings }).route;
        route.unwrap().into_iter().map(|cell| grid.position(cell).column).collect::<Vec<_>>()
    };
    assert!(planned(false).iter().all(|&column| column < 8), "a look from there is good enough");
    assert_eq!(planned(true), [6, 7, 8]);
}
