//! Decisions that must not change unnoticed: paths of one seed, as drawings.

use dragnet_scenario::Scenario;
use dragnet_search::cell::{Cell, Position};
use dragnet_search::policy::PolicyName;
use dragnet_sim::episode;
use dragnet_sim::participants::LocalParticipants;
use dragnet_sim::simulation::{End, Membership, Rules, StepContext};

use crate::scenario;

const COVE: &str = r#"
name = "cove"
[map]
shape = "ice_cream_cone"
rows = 14
columns = 14
[sensor]
radius = 2
[objects]
count = 4
[robots]
start = [6, 6]
[mission]
budget_meters = 1500.0
"#;

/// The cells that a robot entered, drawn: `#` blocked, `.` not entered, else the last digit of how many it had
/// entered when it first did.
fn track(scenario: &Scenario) -> String {
    let mut entered: Vec<Cell> = Vec::new();
    let agent_config = dragnet_agent::agent::AgentConfig::of_team(scenario, 1);
    let mut robots: Vec<_> = agent_config.into_iter().map(dragnet_agent::agent::Agent::new).collect();
    let rules = Rules { end: End::Resting, coordinator: Membership::Absent };
    let mut watch = |_, scene| {
        if let StepContext::Arrives { cell, .. } = scene {
            entered.push(cell);
        }
    };
    episode::run_with(scenario, 1, rules, &mut LocalParticipants::new(&mut robots, None), &mut watch)
        .unwrap();
    let grid = scenario.terrain().grid();
    let sign = |cell: Cell| match entered.iter().position(|&other| other == cell) {
        Some(place) => char::from_digit(u32::try_from(place % 10).unwrap(), 10).unwrap(),
        None if scenario.terrain().is_traversable(cell) => '.',
        None => '#',
    };
    let line =
        |row| (0..grid.columns()).map(|column| sign(grid.cell(Position { row, column }).unwrap())).collect();
    let lines: Vec<String> = (0..grid.rows()).rev().map(line).collect();
    lines.join("\n")
}

fn check(policy: PolicyName, expected: &str) {
    let given = track(&scenario(COVE).with_policy(policy).unwrap());
    assert!(given == expected.trim(), "{policy} walked\n{given}");
}

#[test]
fn greedy_walks_as_it_did() {
    check(
        PolicyName::Greedy,
        "
######..######
####...9..####
###....812.###
###.0..7...###
###.98765..###
###.2..54..###
###.3..43..###
####45012.####
#####6.2.#####
#####7.1.#####
#####890.#####
######..######
######..######
##############
",
    );
}

#[test]
fn path_walks_as_it_did() {
    check(
        PolicyName::Path,
        "
######..######
####...7..####
###..0.6...###
###..9.5...###
###43214543###
###5...3..2###
###67..2.01###
####890189####
#####0..7#####
#####1..6#####
#####2345#####
######..######
######..######
##############
",
    );
}

#[test]
fn nats_walks_as_it_did() {
    check(
        PolicyName::Nats,
        "
######..######
####...1..####
###..8903..###
###..7..6..###
###..6..5..###
###.45..4..###
###.3.123..###
####210.0.####
#####0.21#####
#####9.3.#####
#####874.#####
######65######
######..######
##############
",
    );
}
