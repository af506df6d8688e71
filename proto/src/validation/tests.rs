use dragnet_search::cell::{Cell, Position};
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::{Ends, Origin};

use super::*;

const SECOND: u64 = 1_000_000_000;

/// One robot of 2 m/s with a sensor radius of 2 cells, on cells of 10 m, the middle column blocked except in the south.
fn limits() -> Limits {
    let terrain = Terrain::from_ascii("...#...\n...#...\n.......", 10.0).unwrap();
    let text = "name = 'a'\nmap = { shape = 'all_traversable', rows = 3, columns = 3 }\nobjects.count = 1\nsensor.radius = 1\n\
                mission = { budget_seconds = 60.0, max_clock_skew_seconds = 60.0 }\n";
    let scenario = Scenario::from_text(std::path::Path::new("a.toml"), text.to_owned()).unwrap();
    let sensor = Sensor::new(2, 0.005, dragnet_search::sensor::Noise::Gaussian).unwrap();
    let [robot] = scenario.robots() else { panic!("one robot") };
    let class = Class { sensor: Arc::new(sensor), ..(*robot.class).clone() };
    Limits::new(Arc::new(terrain), [(RobotId::FIRST, Arc::new(class))], Duration::from_mins(1))
}

fn cell(row: u32, column: u32) -> Cell {
    limits().terrain.grid().cell(Position { row, column }).unwrap()
}

fn observed(sequence: u64, seconds: u64, from: Cell, readings: Vec<Reading>) -> Observation {
    Observation {
        origin: Origin::first(RobotId::FIRST),
        sequence,
        time_ns: seconds * SECOND,
        from,
        readings,
        positions: Box::default(),
    }
}

fn reading(row: u32, column: u32, value: f32, variance: f32) -> Reading {
    Reading { cell: cell(row, column), value, variance }
}

/// This one alone is known of its origin.
const fn only(observation: &Observation) -> Ends<'_> {
    Ends { first: observation, last: observation }
}

#[test]
fn an_observation_is_validated_by_map_team_and_sensor() {
    let limits = limits();
    let check = |observation: &Observation, expected| {
        assert_eq!(limits.check(&Arc::new(observation.clone()), None), expected, "{observation:?}");
    };
    let from = cell(0, 0);
    let sees = |readings: Vec<Reading>| observed(0, 0, from, readings);
    // Two cells away the sensor's variance is 0.02.
    check(&sees(vec![reading(0, 0, 0.1, 0.001), reading(1, 1, 0.9, 0.02)]), Ok(()));
    check(&sees(vec![reading(1, 1, 0.9, 5.0)]), Ok(()));
    check(&sees(vec![reading(1, 2, 0.9, 5.0)]), Err(Rejection::OutOfSight));
    check(&sees(vec![reading(1, 1, 0.9, 0.019)]), Err(Rejection::TooPrecise));
    check(&sees(vec![reading(1, 1, 2.2, 0.02)]), Err(Rejection::TooFarOff));
    check(&sees(vec![reading(1, 1, -1.2, 0.02)]), Err(Rejection::TooFarOff));
    check(&sees(vec![reading(0, 0, 0.1, 0.001), reading(0, 0, 0.1, 0.001)]), Err(Rejection::Repeated));
    check(&observed(0, 0, cell(1, 3), Vec::new()), Err(Rejection::Blocked));
    let located = |row, column, meters| {
        let position = ObjectPosition::new(cell(row, column), meters, [1.0, 0.0, 1.0]).unwrap();
        Observation { positions: [position].into(), ..sees(Vec::new()) }
    };
    // Far from the robot, in its cell and beside it.
    check(&located(2, 5, [55.0, 25.0]), Ok(()));
    check(&located(2, 5, [41.0, 34.0]), Ok(()));
    check(&located(2, 5, [39.0, 25.0]), Err(Rejection::Misplaced));
    check(&located(2, 5, [25.0, 55.0]), Err(Rejection::Misplaced));
    let mut stranger = sees(Vec::new());
    stranger.origin.source = RobotId::new(2).unwrap().into();
    check(&stranger, Err(Rejection::Stranger));
}

#[test]
fn a_robot_gets_no_further_than_its_speed_carries_it() {
    let limits = limits();
    let check = |seconds, column, expected| {
        let before = observed(0, 100, cell(0, 0), Vec::new());
        let next = observed(1, seconds, cell(0, column), Vec::new());
        assert_eq!(
            limits.check(&Arc::new(next.clone()), Some(only(&before))),
            expected,
            "{column} cells by {seconds} s"
        );
    };
    // One cell in 5 s, and two because its position within its cell is unknown.
    check(105, 1, Ok(()));
    check(100, 2, Ok(()));
    check(100, 3, Err(Rejection::TooFast));
    check(115, 5, Ok(()));
    check(115, 6, Err(Rejection::TooFast));
    check(99, 0, Err(Rejection::Backwards));
}

#[test]
fn a_standing_robot_cannot_observe_for_ever() {
    let limits = limits();
    let first = observed(0, 0, cell(0, 0), Vec::new());
    let mut last = first.clone();
    for sequence in 1..1000 {
        // A hundred observations per second, for ten seconds.
        let mut next = observed(sequence, 0, cell(0, 0), Vec::new());
        next.time_ns = sequence * SECOND / 100;
        if limits.check(&Arc::new(next.clone()), Some(Ends { first: &first, last: &last }))
            == Err(Rejection::TooOften)
        {
            break;
        }
        last = next;
    }
    assert_eq!(last.sequence, OBSERVATIONS_AT_ONCE);
}

#[test]
fn observations_in_the_future_are_not_accepted_yet() {
    let limits = limits();
    let check =
        |seconds| limits.check_date(MissionTime(10 * SECOND), &observed(0, seconds, cell(0, 0), Vec::new()));
    assert_eq!(check(70), Ok(()));
    assert_eq!(check(71), Err(Rejection::Future));
}

#[test]
fn nobody_but_robots_of_the_team_observes() {
    let stranger = RobotId::new(2).unwrap();
    for source in [Source::Operator, stranger.into()] {
        let origin = Origin { source, incarnation: 0 };
        let observation = Observation { origin, ..observed(0, 5, cell(0, 0), Vec::new()) };
        assert_eq!(limits().check(&Arc::new(observation), None), Err(Rejection::Stranger));
        assert!(!limits().counts(source));
    }
}
