//! Robots that are to return to their bases do, whatever their policy, budget and map.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;

use dragnet_scenario::Scenario;
use dragnet_search::generated::Generated;
use dragnet_search::policy::PolicyName;
use dragnet_sim::episode::{self, Episode};
use dragnet_sim::simulation::End;

fn scenario(seed: u64, policy: PolicyName, mission: &str) -> Scenario {
    let shape = Generated::ALL[usize::try_from(seed).unwrap() % Generated::ALL.len()].as_str();
    let (start, moves) = ([("'random'", 4), ("'scattered'", 8)])[usize::try_from(seed).unwrap() % 2];
    let text = format!(
        "name = 'home'\n[map]\nshape = '{shape}'\nrows = 20\ncolumns = 16\nseed = {seed}\ncell_meters = 10.0\n\
         connectivity = {moves}\n[objects]\ndensity = 0.02\n[robots]\ncount = 2\npolicy = '{policy}'\n\
         start = {start}\nrobot = [{{ number = 2, class = 'drone' }}]\n\
         [classes.drone]\nflies = true\nspeed_meters_per_second = 5.0\n[mission]\n{mission}\n"
    );
    Scenario::from_text(Path::new("home.toml"), text).unwrap()
}

fn search(scenario: &Scenario, seed: u64) -> Episode {
    episode::run(scenario, seed, End::Resting).unwrap()
}

#[test]
fn every_robot_is_back_at_its_base_within_its_budget() {
    let mut shares = Vec::new();
    for seed in 0..12 {
        for policy in PolicyName::ALL {
            let [meters, seconds] = [100.0 + 50.0 * seed as f64, 60.0 + 25.0 * seed as f64];
            for mission in [format!("budget_meters = {meters:?}"), format!("budget_seconds = {seconds:?}")] {
                let mission = format!("return_to_base = true\n{mission}");
                let episode = search(&scenario(seed, policy, &mission), seed);
                assert!(episode.at_start.iter().all(|&is_back| is_back), "{seed} {policy} {mission}");
                for cells in &episode.path_cells {
                    assert!(
                        !mission.contains("meters") || 10.0 * cells <= meters,
                        "{seed} {policy}: {cells}"
                    );
                }
                assert!(episode.outcome.ended.as_seconds() <= seconds || mission.contains("meters"));
                shares.push(10.0 * episode.path_cells[0] / meters);
            }
        }
    }
    // They do not stay at home for that.
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    assert!(mean > 0.4, "{mean}");
}

#[test]
fn without_being_told_robots_stay_where_their_search_ends() {
    let away = (0..10).filter(|&seed| {
        let episode = search(&scenario(seed, PolicyName::Path, "budget_meters = 200.0"), seed);
        episode.at_start.iter().any(|&is_back| !is_back)
    });
    assert!(away.count() > 5);
}

#[test]
fn a_robot_that_has_found_all_comes_home_too() {
    for seed in 0..10 {
        let told = "return_to_base = true\nbudget_meters = 100000.0";
        let episode = search(&scenario(seed, PolicyName::Tour, told), seed);
        let stayed = search(&scenario(seed, PolicyName::Tour, "budget_meters = 100000.0"), seed);
        assert!(episode.at_start.iter().all(|&is_back| is_back), "{seed}");
        assert_eq!(episode.outcome.cells_to_full_recall, stayed.outcome.cells_to_full_recall, "{seed}");
    }
}
