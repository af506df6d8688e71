//! Searches in a house: what is behind a wall is seen from where it is in sight, and the search ends when all of it was.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use dragnet_agent::agent::Agent;
use dragnet_scenario::Scenario;
use dragnet_search::cell::{Cell, Position};
use dragnet_search::policy::PolicyName;

mod resting;

use resting::search;

/// Two rooms, each with a door, and a cell without one.
const MAP: &str = "\
..................
.#####.####.###...
.#...#.#..#.#.#...
.#...#.#..#.###...
.#.....#..#.......
.#####.##.#.......
..................
";

/// In the rooms' far corners, as row and column.
const OBJECTS: [(u32, u32); 2] = [(4, 2), (4, 8)];

fn scenario(rest: &str) -> Scenario {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("house.txt"), MAP).unwrap();
    let [(a, b), (c, d)] = OBJECTS;
    let text = format!(
        "name = 'house'\nmap = {{ file = 'house.txt', cell_meters = 5.0 }}\n\
         sensor = {{ radius = 4, noise_variance = 0.001, line_of_sight = true }}\nobjects = {{ cells = [[{a}, {b}], [{c}, {d}]] }}\n\
         mission = {{ budget_seconds = 7200.0, stop_when_expected_remaining = 0.001 }}\n\
         [robots]\nstart = [0, 0]\n{rest}"
    );
    Scenario::from_text(&folder.path().join("house.toml"), text).unwrap()
}

fn found(scenario: &Scenario, robot: &Agent) -> Vec<(u32, u32)> {
    let position = |cell: Cell| {
        let Position { row, column } = scenario.terrain().grid().position(cell);
        (row, column)
    };
    scenario.terrain().searched_cells().filter(|&cell| robot.is_found(cell)).map(position).collect()
}

#[test]
fn every_policy_finds_what_is_in_the_rooms_and_rests() {
    for policy in PolicyName::ALL.into_iter().filter(|&policy| policy != PolicyName::Random) {
        for robots in ["", "count = 3\n"] {
            let scenario = scenario(robots).with_policy(policy).unwrap();
            for seed in 0..3 {
                let (episode, robots) = search(&scenario, seed);
                assert!(episode.outcome.beliefs_equal, "{policy} {seed}");
                assert_eq!(found(&scenario, &robots[0]), OBJECTS, "{policy} {seed}");
                let ended = episode.outcome.ended.as_seconds();
                assert!(ended < 3600.0, "{policy} {seed}: it went on for {ended} s");
            }
        }
    }
}

#[test]
fn a_cell_that_no_robot_on_the_ground_can_see_into_is_told_and_a_drone_sees_it() {
    let ground = scenario("");
    let warnings: Vec<String> = ground.warnings().iter().map(ToString::to_string).collect();
    assert!(warnings.iter().any(|warning| warning.contains("1 of 90 searched cells")), "{warnings:?}");
    let enclosed = ground.terrain().grid().cell(Position { row: 4, column: 13 }).unwrap();
    let prior = ground.prior().log_odds_nats(enclosed);
    let (_, robots) = search(&ground, 0);
    assert!(!robots[0].is_found(enclosed));
    let drone = scenario("class = 'drone'\n[classes.drone]\nflies = true\n");
    assert!(drone.warnings().is_empty(), "{:?}", drone.warnings());
    let (_, robots) = search(&drone, 0);
    assert!(robots[0].belief().log_odds_nats(enclosed) < prior - 3.0, "it looked into it");
}
