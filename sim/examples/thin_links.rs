//! How far ten robots drive until they have found all, over radios of 1 kbit/s each with 30 % loss, against a perfect network:
//! path length of the farthest, what is sent, and whether all beliefs are equal once nothing is lost any more.
//!
//! ```text
//! cargo run --release -p dragnet-sim --example thin_links -- 0 40 path tour
//! ```

use std::env;
use std::error::Error;
use std::path::Path;

use dragnet_scenario::Scenario;
use dragnet_sim::episode::{self, Episode};
use dragnet_sim::simulation::End;
use rayon::prelude::*;

const ROBOTS: u16 = 10;

/// The networks that are compared, the perfect one first.
const NETWORKS: [(&str, &str); 5] = [
    ("perfect", ""),
    ("30 % loss", "loss = 0.3"),
    ("1 kbit/s", "bytes_per_second = 125.0"),
    ("1 kbit/s, 30 % loss", "bytes_per_second = 125.0\nloss = 0.3"),
    ("250 bit/s, 30 % loss", "bytes_per_second = 31.25\nloss = 0.3"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [first, end, policies @ ..] = arguments.as_slice() else {
        return Err("usage: thin_links FIRST_SEED END_SEED POLICY...".into());
    };
    let seeds = first.parse::<u64>()?..end.parse::<u64>()?;
    for policy in policies {
        let mut perfect = Vec::new();
        for (name, network) in NETWORKS {
            let team = team(policy, network)?;
            let episodes: Vec<Episode> = seeds
                .clone()
                .into_par_iter()
                .map(|seed| episode::run(&team, seed, End::AllFound).map_err(|error| error.to_string()))
                .collect::<Result<_, _>>()?;
            let cells: Vec<f64> = episodes.iter().filter_map(|it| it.outcome.cells_to_full_recall).collect();
            if perfect.is_empty() {
                perfect.clone_from(&cells);
            }
            print(&format!("{policy}, {name}"), &cells, &perfect, &episodes);
        }
    }
    Ok(())
}

fn team(policy: &str, network: &str) -> Result<Scenario, String> {
    let text = format!(
        "name = \"team\"\n[map]\nshape = \"all_traversable\"\nrows = 60\ncolumns = 60\n\
         [objects]\ndensity = 0.01\n[robots]\ncount = {ROBOTS}\npolicy = \"{policy}\"\nstart = \"random\"\n\
         [mission]\nbudget_meters = 200000.0\nstop_when_expected_remaining = 0.0\n[network]\n{network}\n"
    );
    Scenario::from_text(Path::new("team.toml"), text).map_err(|error| error.to_string())
}

#[expect(clippy::print_stdout, reason = "its result")]
fn print(what: &str, cells: &[f64], perfect: &[f64], episodes: &[Episode]) {
    let count = cells.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let ratio = mean(cells) / mean(perfect);
    // Of a ratio of means over the same seeds, to first order.
    let errors: Vec<f64> =
        cells.iter().zip(perfect).map(|(cells, perfect)| (cells - ratio * perfect).powi(2)).collect();
    let error = (errors.iter().sum::<f64>() / (count * (count - 1.0))).sqrt() / mean(perfect);
    let equal = episodes.iter().filter(|episode| episode.outcome.beliefs_equal).count();
    println!(
        "{what}: {:.1} cells, {ratio:.3} ± {error:.3} of perfect ({count} of {} found all); beliefs equal after healing {equal}",
        mean(cells),
        episodes.len(),
    );
    let robot_seconds: f64 =
        episodes.iter().map(|it| it.outcome.ended.as_seconds() * f64::from(ROBOTS)).sum();
    let mut sum = episodes[0].outcome.traffic.clone();
    for episode in &episodes[1..] {
        sum += &episode.outcome.traffic;
    }
    for (kind, amount) in &sum.sent {
        println!(
            "    {kind:?}: {:.1} bytes each, {:.1} bytes a second and robot",
            amount.bytes as f64 / amount.messages as f64,
            amount.bytes as f64 / robot_seconds,
        );
    }
    println!(
        "    all: {:.1} bytes a second and robot; {} of {} messages replaced or dropped before they were sent",
        sum.bytes() as f64 / robot_seconds,
        sum.unsent,
        sum.unsent + sum.sent.values().map(|amount| amount.messages).sum::<u64>(),
    );
}
