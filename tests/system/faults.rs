//! Bad networks: no observation is lost, and in the end all beliefs are equal.

use dragnet_agent::agent::Agent;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::RobotId;
use dragnet_sim::episode::{self, Episode};
use dragnet_sim::faults::{Crash, Faults};
use dragnet_sim::network::Tally;
use dragnet_sim::participants::LocalParticipants;
use dragnet_sim::simulation::{End, Membership, Rules};

use crate::scenario;

const STORM: &str = r#"
name = "storm"
[map]
shape = "all_traversable"
rows = 12
columns = 12
[objects]
density = 0.1
[robots]
count = 4
policy = "path"
[mission]
budget_seconds = 900.0
[network]
loss = 0.4
delay_seconds = 0.5
jitter_seconds = 20.0
duplication = 0.3
reorder = 0.3
reorder_seconds = 60.0
[[network.partitions]]
from_seconds = 60.0
to_seconds = 300.0
groups = [[1, 2], [3]]
"#;

#[test]
fn after_every_storm_all_beliefs_are_equal_to_the_bit() {
    let storm = scenario(STORM);
    let mut total = Tally::default();
    for seed in 0..300 {
        let episode = episode::run(&storm, seed, End::Resting).unwrap();
        assert!(episode.outcome.beliefs_equal, "seed {seed}");
        assert_eq!(episode.belief.digest(), episode.outcome.digest);
        let Tally { sent, lost, cut, duplicated, reordered, .. } = episode.outcome.network;
        total.sent += sent;
        total.lost += lost;
        total.cut += cut;
        total.duplicated += duplicated;
        total.reordered += reordered;
    }
    // Each fault has occurred many times.
    for count in [total.lost, total.cut, total.duplicated, total.reordered] {
        assert!(count > 10_000, "{total:?}");
    }
}

#[test]
fn the_same_seed_gives_the_same_storm() {
    let storm = scenario(STORM);
    let run = |seed| {
        let episode = episode::run(&storm, seed, End::Resting).unwrap();
        (episode.outcome.digest, episode.outcome.ended, episode.path_cells, episode.outcome.network)
    };
    assert_eq!(run(7), run(7));
    assert_ne!(run(7).0, run(8).0);
}

/// Robots that leave one cell of a 60 x 60 map where one cell in a hundred holds an object.
fn team(robots: u32, loss: f64) -> Scenario {
    scenario(&format!(
        "name = \"team\"\n[map]\nshape = \"all_traversable\"\nrows = 60\ncolumns = 60\n\
         [objects]\ndensity = 0.01\n[robots]\ncount = {robots}\npolicy = \"path\"\n\
         [mission]\nbudget_meters = 200000.0\nstop_when_expected_remaining = 0.0\n[network]\nloss = {loss:?}\n"
    ))
}

fn search(team: &Scenario, seed: u64, faults: Faults) -> Episode {
    let rules = Rules { end: End::AllFound, coordinator: Membership::Absent };
    let mut robots = episode::team(team, seed, Agent::new);
    let mut participants = LocalParticipants::new(&mut robots, None);
    let episode =
        episode::run_with_faults(team, seed, rules, faults, &mut participants, &mut |_, _| ()).unwrap();
    assert!(episode.outcome.beliefs_equal, "seed {seed}");
    episode
}

/// Path length of the farthest robot until all objects are found, a mean.
fn mean_cells(cells: impl Fn(u64) -> Episode) -> f64 {
    let seeds = 2000..2020;
    let all: f64 = seeds.clone().map(|seed| cells(seed).outcome.cells_to_full_recall.unwrap()).sum();
    all / seeds.count() as f64
}

/// A robot of the team is lost after a third of the search.
fn search_with_a_death(team: &Scenario, seed: u64) -> Episode {
    let third = MissionTime(search(team, seed, Faults::default()).outcome.ended.0 / 3);
    let lost = Participant::Robot(RobotId::new(u16::try_from(1 + seed % 8).unwrap()).unwrap());
    let crashes = [(lost, Crash { at: third, back: None })].into();
    search(team, seed, Faults { crashes, ..Faults::default() })
}

#[test]
fn eight_robots_need_little_more_than_an_eighth_of_the_path_also_when_half_is_lost_or_one_dies() {
    let (one, eight, lossy) = (team(1, 0.0), team(8, 0.0), team(8, 0.5));
    let alone = mean_cells(|seed| search(&one, seed, Faults::default()));
    let check = |what, cells: f64, least: f64| {
        let times = alone / cells;
        println!("{what}: {cells} cells, {times:.2} times as fast as one with {alone}");
        assert!(times >= least, "{what}: {times} times as fast");
    };
    check("eight", mean_cells(|seed| search(&eight, seed, Faults::default())), 6.5);
    check("half of all messages lost", mean_cells(|seed| search(&lossy, seed, Faults::default())), 6.0);
    check("one lost at a third", mean_cells(|seed| search_with_a_death(&eight, seed)), 6.0);
}
