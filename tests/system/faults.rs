//! Bad networks: nothing observed is lost, and in the end all believe the same.

use dragnet_sim::episode;
use dragnet_sim::network::Tally;
use dragnet_sim::simulation::End;

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
    // Each fault has bitten, many times.
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

/// Eight robots leave one cell of a 60 x 60 map; cells of the farthest until all is found.
fn mean_cells(robots: u32, loss: f64) -> f64 {
    let team = format!(
        "name = \"team\"\n[map]\nshape = \"all_traversable\"\nrows = 60\ncolumns = 60\n\
         [objects]\ndensity = 0.01\n[robots]\ncount = {robots}\npolicy = \"path\"\n\
         [mission]\nbudget_meters = 200000.0\nexpected_undeclared = 0.0\n[network]\nloss = {loss:?}\n"
    );
    let team = scenario(&team);
    let cells = |seed| {
        let episode = episode::run(&team, seed, End::AllFound).unwrap();
        assert!(episode.outcome.beliefs_equal, "seed {seed}");
        episode.outcome.cells_to_full_recall.unwrap()
    };
    let seeds = 2000..2020;
    seeds.clone().map(cells).sum::<f64>() / seeds.count() as f64
}

#[test]
fn eight_robots_are_five_and_a_half_times_as_fast_as_one_and_lost_messages_cost_little() {
    let one = mean_cells(1, 0.0);
    let (eight, eight_with_loss) = (mean_cells(8, 0.0), mean_cells(8, 0.5));
    println!("one {one}, eight {eight}, eight at 50 % loss {eight_with_loss}");
    assert!(eight <= one / 5.5, "{one} and {eight}: {}", one / eight);
    assert!(eight_with_loss <= one / 4.5, "{one} and {eight_with_loss}: {}", one / eight_with_loss);
}
