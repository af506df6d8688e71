//! Teams whose robots keep apart, where they can hardly pass each other: the search ends with everything found, and no two are
//! ever in one cell. That they keep their distance between cells too is checked under faults, in `soak`.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::{BTreeMap, BTreeSet};

use dragnet_agent::agent::Agent;
use dragnet_scenario::{Scenario, Start};
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;
use dragnet_search::policy::PolicyName;
use dragnet_sim::episode;
use dragnet_sim::participants::LocalParticipants;
use dragnet_sim::simulation::{End, Membership, Rules, StepContext};

/// A corridor with dead ends, all one cell wide.
const COMB: &str = "\
.#.#.#.#.#.
.#.#.#.#.#.
.#.#.#.#.#.
...........
#.#.#.#.#.#
#.#.#.#.#.#
";

/// Two rooms, and a corridor of one cell between them.
const DUMBBELL: &str = "\
....#########....
....#########....
.................
....#########....
";

fn scenario(map: &str, mission: &str, robots: &str) -> Scenario {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("map.txt"), map).unwrap();
    let text = format!(
        "name = 'narrow'\nmap = {{ file = 'map.txt', cell_meters = 2.0 }}\nsensor = {{ radius = 1, noise_variance = 0.01 }}\n\
         objects.density = 0.05\nmission = {{ budget_seconds = 3600.0, speed_meters_per_second = 0.5, {mission} }}\n\
         [robots]\nseparation_meters = 1.5\n{robots}"
    );
    Scenario::from_text(&folder.path().join("narrow.toml"), text).unwrap()
}

/// Objects that the search still expects at its end, and its duration in seconds.
fn search(scenario: &Scenario, seed: u64) -> (f64, f64) {
    let mut robots = episode::team(scenario, seed, Agent::new);
    let mut cells: BTreeMap<RobotId, Cell> = BTreeMap::new();
    let mut spectator = |now, step| {
        let StepContext::Arrives { robot, cell, .. } = step else { return };
        cells.insert(robot, cell);
        let others = cells.iter().filter(|&(&other, _)| other != robot);
        assert!(others.into_iter().all(|(_, &it)| it != cell), "seed {seed}: robot {robot} at {now:?}");
    };
    let rules = Rules { end: End::Resting, coordinator: Membership::Absent };
    let mut participants = LocalParticipants::new(&mut robots, None);
    let episode = episode::run_with(scenario, seed, rules, &mut participants, &mut spectator).unwrap();
    (episode.expected_remaining, episode.outcome.ended.as_seconds())
}

#[test]
fn nobody_is_shut_in_whatever_the_policy() {
    for (map, robots) in [(COMB, 3), (COMB, 5), (DUMBBELL, 2), (DUMBBELL, 6)] {
        for policy in
            [PolicyName::Path, PolicyName::Tour, PolicyName::Nats, PolicyName::Greedy, PolicyName::Coverage]
        {
            for start in ["random", "scattered"] {
                let team = format!("count = {robots}\nstart = '{start}'\n");
                let scenario = scenario(map, "", &team).with_policy(policy).unwrap();
                for seed in 0..5 {
                    let (remaining, seconds) = search(&scenario, seed);
                    assert!(
                        remaining <= 0.05,
                        "{robots} robots, {policy}, {start}, seed {seed}: {remaining}"
                    );
                    assert!(seconds < 3600.0, "{robots} robots, {policy}, {start}, seed {seed}: {seconds} s");
                }
            }
        }
    }
}

/// The operator gives one place for all.
#[test]
fn robots_with_one_start_stand_beside_each_other_and_each_comes_home() {
    let scenario = scenario(DUMBBELL, "return_to_base = true", "count = 4\nstart = [1, 1]\n");
    let starts: BTreeSet<Cell> = scenario
        .robots()
        .iter()
        .filter_map(|robot| match robot.start {
            Start::Cell(cell) => Some(cell),
            _ => None,
        })
        .collect();
    assert_eq!(starts.len(), 4);
    for seed in 0..5 {
        let episode = episode::run(&scenario, seed, End::Resting).unwrap();
        assert_eq!(episode.at_start, [true; 4], "seed {seed}");
        assert!(episode.expected_remaining <= 0.05, "seed {seed}");
    }
}
