//! How long a drone and two rovers search until all is found, beside three rovers and three drones: 60 x 60 cells, 1 %, all
//! from one cell, restricted means in seconds.
//!
//! ```text
//! cargo run --release -p dragnet-sim --example unlike_teams -- 2000 2050 path tour
//! ```

use std::env;
use std::error::Error;
use std::path::Path;

use dragnet_agent::agent::Agent;
use dragnet_scenario::Scenario;
use dragnet_sim::episode;
use dragnet_sim::participants::LocalParticipants;
use dragnet_sim::simulation::{End, Membership, Rules};
use rayon::prelude::*;

/// A search that is not done by then counts as so long, seconds.
const BUDGET_SECONDS: f64 = 14_400.0;
const TEAMS: [(&str, [&str; 3]); 3] = [
    ("a drone and two rovers", ["drone", "rover", "rover"]),
    ("three rovers", ["rover", "rover", "rover"]),
    ("three drones", ["drone", "drone", "drone"]),
];

#[expect(clippy::print_stdout, reason = "its result")]
fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [first, end, policies @ ..] = arguments.as_slice() else {
        return Err("usage: unlike_teams FIRST_SEED END_SEED POLICY...".into());
    };
    let seeds = first.parse::<u64>()?..end.parse::<u64>()?;
    for shape in ["all_traversable", "ice_cream_cone"] {
        for policy in policies {
            for (name, classes) in TEAMS {
                let scenario = scenario(shape, policy, classes)?;
                let searches = seeds.clone().into_par_iter().map(|seed| seconds(&scenario, seed));
                let seconds = searches.collect::<Result<Vec<f64>, String>>()?;
                let (mean, error) = mean_and_error(&seconds);
                let reached = seconds.iter().filter(|&&seconds| seconds < BUDGET_SECONDS).count();
                println!(
                    "{shape}, {policy}, {name}: {mean:.0} ± {error:.0} s ({reached} of {})",
                    seconds.len()
                );
            }
        }
    }
    Ok(())
}

fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

fn scenario(shape: &str, policy: &str, classes: [&str; 3]) -> Result<Scenario, String> {
    let robots: Vec<String> = (1..)
        .zip(classes)
        .map(|(number, class)| format!("{{ number = {number}, class = '{class}' }}"))
        .collect();
    let text = format!(
        "name = 'unlike'\nmap = {{ shape = '{shape}', rows = 60, columns = 60, cell_meters = 10.0 }}\n\
         objects.density = 0.01\n[robots]\ncount = 3\npolicy = '{policy}'\nrobot = [{}]\n\
         [classes.rover]\nspeed_meters_per_second = 2.0\n\
         [classes.drone]\nspeed_meters_per_second = 6.0\nflies = true\n\
         sensor = {{ radius = 8, noise_variance = 0.02 }}\n\
         [mission]\nbudget_seconds = {BUDGET_SECONDS:?}\nstop_when_expected_remaining = 0.0\n",
        robots.join(", ")
    );
    Scenario::from_text(Path::new("unlike.toml"), text).map_err(|error| error.to_string())
}

fn seconds(scenario: &Scenario, seed: u64) -> Result<f64, String> {
    let rules = Rules { end: End::AllFound, coordinator: Membership::Absent };
    let mut robots = episode::team(scenario, seed, Agent::new);
    let mut participants = LocalParticipants::new(&mut robots, None);
    let episode = episode::run_with(scenario, seed, rules, &mut participants, &mut |_, _| ());
    let outcome = episode.map_err(|error| error.to_string())?.outcome;
    let is_reached = outcome.cells_to_full_recall.is_some();
    Ok(if is_reached { outcome.ended.as_seconds().min(BUDGET_SECONDS) } else { BUDGET_SECONDS })
}
