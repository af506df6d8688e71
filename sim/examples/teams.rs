//! How far eight robots drive until they have found all: path length of the farthest, with all messages, with half of them
//! lost, and with one robot lost at a third of the search.
//!
//! ```text
//! cargo run --release -p dragnet-sim --example teams -- 2000 2020 path tour 'tour(evaluations=2000)'
//! ```

use std::env;
use std::error::Error;
use std::path::Path;

use dragnet_agent::agent::Agent;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::RobotId;
use dragnet_search::route::ShortestPathTree;
use dragnet_sim::episode::{self, Episode};
use dragnet_sim::faults::{Crash, Faults};
use dragnet_sim::participants::LocalParticipants;
use dragnet_sim::simulation::{End, Membership, Rules};
use dragnet_sim::world::World;
use rayon::prelude::*;

const ROBOTS: u16 = 8;

#[derive(Clone, Copy, PartialEq)]
enum Variant {
    AllMessages,
    HalfLost,
    OneDies,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [first, end, policies @ ..] = arguments.as_slice() else {
        return Err("usage: teams FIRST_SEED END_SEED POLICY...".into());
    };
    let seeds = first.parse::<u64>()?..end.parse::<u64>()?;
    let farthest = seeds.clone().into_par_iter().map(|seed| farthest_object(&team("\"path\"", 0.0)?, seed));
    print(
        "farthest object from the start",
        &farthest.collect::<Result<Vec<f64>, String>>()?,
        &mut Vec::new(),
    );
    for policy in policies {
        for (name, variant) in [
            ("all messages", Variant::AllMessages),
            ("half of all messages lost", Variant::HalfLost),
            ("one robot lost at a third", Variant::OneDies),
        ] {
            let searches = seeds.clone().into_par_iter().map(|seed| search_with(policy, variant, seed));
            let episodes = searches.collect::<Result<Vec<Episode>, String>>()?;
            let cells: Vec<f64> = episodes.iter().filter_map(|it| it.outcome.cells_to_full_recall).collect();
            let mut times: Vec<f64> = episodes
                .iter()
                .flat_map(|episode| &episode.outcome.decisions)
                .map(|time| time.as_secs_f64() * 1e3)
                .collect();
            print(&format!("{policy}, {name}"), &cells, &mut times);
        }
    }
    Ok(())
}

/// The mean of the searches that found all, with its standard error.
#[expect(clippy::print_stdout, reason = "its result")]
fn print(what: &str, cells: &[f64], times: &mut [f64]) {
    let count = cells.len() as f64;
    let mean = cells.iter().sum::<f64>() / count;
    let variance = cells.iter().map(|cells| (cells - mean).powi(2)).sum::<f64>() / (count - 1.0);
    println!("{what}: {mean:.2} ± {:.2} cells ({count} searches)", (variance / count).sqrt());
    times.sort_unstable_by(f64::total_cmp);
    if let [.., longest] = *times {
        println!("    decisions: median {:.1} ms, longest {longest:.0} ms", times[times.len() / 2]);
    }
}

fn team(policy: &str, loss: f64) -> Result<Scenario, String> {
    let text = format!(
        "name = \"team\"\n[map]\nshape = \"all_traversable\"\nrows = 60\ncolumns = 60\n\
         [objects]\ndensity = 0.01\n[robots]\ncount = {ROBOTS}\npolicy = {policy}\n\
         [mission]\nbudget_meters = 200000.0\nstop_when_expected_remaining = 0.0\n[network]\nloss = {loss:?}\n"
    );
    Scenario::from_text(Path::new("team.toml"), text).map_err(|error| error.to_string())
}

/// Distance of the farthest object from the cell that all robots start in, cells: no team is done much sooner.
fn farthest_object(team: &Scenario, seed: u64) -> Result<f64, String> {
    let world = World::new(team, seed);
    let start = world.body(RobotId::new(1).ok_or("robot 0")?).cell;
    let routes = ShortestPathTree::from(team.terrain(), team.connectivity(), start);
    let lengths = world.truth().objects().iter().map(|&object| f64::from(routes.length(object)));
    Ok(lengths.fold(0.0, f64::max))
}

fn search_with(policy: &str, variant: Variant, seed: u64) -> Result<Episode, String> {
    let team = team(&table(policy), if variant == Variant::HalfLost { 0.5 } else { 0.0 })?;
    let whole = search(&team, seed, Faults::default())?;
    if variant != Variant::OneDies {
        return Ok(whole);
    }
    let number = u16::try_from(1 + seed % u64::from(ROBOTS)).map_err(|error| error.to_string())?;
    let lost = Participant::Robot(RobotId::new(number).ok_or("robot 0")?);
    let crash = Crash { at: MissionTime(whole.outcome.ended.0 / 3), back: None };
    search(&team, seed, Faults { crashes: [(lost, crash)].into(), ..Faults::default() })
}

/// A policy as a value of TOML: `tour(evaluations=10)` as `{ name = "tour", evaluations=10 }`.
fn table(policy: &str) -> String {
    let (name, parameters) = policy.split_once('(').unwrap_or((policy, ""));
    let parameters = parameters.trim_end_matches(')');
    let separator = if parameters.is_empty() { "" } else { "," };
    format!("{{ name = \"{name}\"{separator} {parameters} }}")
}

fn search(team: &Scenario, seed: u64, faults: Faults) -> Result<Episode, String> {
    let rules = Rules { end: End::AllFound, coordinator: Membership::Absent };
    let mut robots = episode::team(team, seed, Agent::new);
    let mut participants = LocalParticipants::new(&mut robots, None);
    episode::run_with_faults(team, seed, rules, faults, &mut participants, &mut |_, _| ())
        .map_err(|error| error.to_string())
}
