//! Performance of the policies: means over seeds.

use dragnet_scenario::Scenario;
use dragnet_search::policy::PolicyName;
use dragnet_sim::episode;
use dragnet_sim::simulation::End;

use crate::committed;

const SEEDS: std::ops::Range<u64> = 1000..1050;

fn mean_auc_f1(scenario: &Scenario, policy: PolicyName, budget_cells: u32) -> f64 {
    let scenario = scenario.with_policy(policy).unwrap().with_budget_cells(budget_cells).unwrap();
    let auc = |seed| {
        let episode = episode::run(&scenario, seed, End::AllFound).unwrap();
        episode.outcome.f1.mean_until(f64::from(budget_cells))
    };
    SEEDS.map(auc).sum::<f64>() / SEEDS.count() as f64
}

#[test]
fn path_beats_greedy_on_all_four_maps_at_both_densities() {
    for map in ["ice_cream_cone", "all_traversable", "open_asterisk", "figure_four"] {
        for density in [0.2, 0.01] {
            let scenario = committed(&format!("paper/{map}.toml")).with_density(density).unwrap();
            let path = mean_auc_f1(&scenario, PolicyName::Path, 300);
            let greedy = mean_auc_f1(&scenario, PolicyName::Greedy, 300);
            println!("{map} at {density}: path {path:.4}, greedy {greedy:.4}");
            assert!(path > greedy, "{map} at {density}: path {path}, greedy {greedy}");
        }
    }
}
