//! `dragnet soak`: tests whole teams under faults over thousands of seeds.

use std::time::{Duration, Instant};

use dragnet_coordinator::mission::{CoordinatorConfig, Mission};
use dragnet_coordinator::node::CoordinatorNode;
use dragnet_experiments::seeds::Seeds;
use dragnet_experiments::{ExperimentError, jobs};
use dragnet_scenario::Scenario;
use dragnet_sim::soak::{self, FaultCounts, Survived};

use super::Failure;
use crate::terminal::progress::Bars;
use crate::terminal::{self, counted};

/// Seeds that run before the time limit is checked.
const ROUND: usize = 200;

/// Test teams under injected faults and check their invariants.
///
/// Each seed is a search on a small generated map. Messages are lost, delayed, duplicated and reordered; links fail in
/// one direction or both; robots and the coordinator crash and restart with or without their stored state; clocks run
/// ahead, wheels are slow, and sometimes a robot publishes false readings. An operator pauses the search, marks cells
/// and adds cells. After every step of every participant the checks are: each reading counts once; no name is used
/// twice; nothing is published before it is stored; declared objects stay declared unless the evidence contradicts
/// them; no robot waits for another. At the end, all beliefs are equal to the bit and the mission is over. Nothing
/// depends on this computer's clock: a seed that fails once always fails.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet soak --seeds 2000
  dragnet soak --seeds 1000000..2000000 --minutes 60")]
pub(crate) struct Arguments {
    /// Seeds, each for one episode: N for 0 to N - 1, or A..B for A to B - 1; at most 1000000 of them
    #[arg(long, value_name = "N | A..B", default_value = "2000", allow_negative_numbers = true)]
    seeds: Seeds,
    /// Time after which no further episodes start, even if seeds are left, minutes, at least 1
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    minutes: Option<u32>,
    /// Number of episodes to run in parallel, 1 to 1024 [default: the number of cores]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: Option<u16>,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

/// Totals over all seeds.
#[derive(Default, serde::Serialize)]
struct Total {
    episodes: usize,
    observations: u64,
    /// Number of checked steps.
    steps_checked: u64,
    faults: FaultCounts,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let start = Instant::now();
    let most = arguments.minutes.map(|minutes| Duration::from_mins(minutes.into()));
    let seeds: Vec<u64> = (0..arguments.seeds.count()).map(|place| arguments.seeds.at(place)).collect();
    let rounds = if most.is_some() { ROUND } else { seeds.len().max(1) };
    let mut total = Total::default();
    for seeds in seeds.chunks(rounds) {
        let done = jobs::run(seeds, arguments.threads, "episodes", &Bars, |&seed| survive(seed))?;
        for survived in &done.results {
            total.add(survived);
        }
        if most.is_some_and(|most| start.elapsed() >= most) {
            break;
        }
    }
    if arguments.json {
        return Ok(terminal::print_json(&total)?);
    }
    Ok(terminal::print(&total.text(start.elapsed()))?)
}

fn survive(seed: u64) -> Result<Survived, ExperimentError> {
    let coordinator = |scenario: &Scenario| -> Box<dyn dragnet_proto::state_machine::StateMachine> {
        Box::new(CoordinatorNode::new(Mission::new(CoordinatorConfig::of(scenario)), None))
    };
    soak::run(seed, coordinator).map_err(|violation| {
        ExperimentError::Run(format!(
            "seed {seed}: {violation}\nagain: dragnet soak --seeds {seed}..{}",
            seed + 1
        ))
    })
}

impl Total {
    fn add(&mut self, survived: &Survived) {
        self.episodes += 1;
        self.observations += survived.observations;
        self.steps_checked += survived.checked;
        self.faults += survived.fault_counts;
    }

    fn text(&self, elapsed: Duration) -> String {
        let FaultCounts { network, .. } = self.faults;
        let rows = [
            ("messages sent", network.sent),
            ("lost", network.lost),
            ("lost to a partition", network.cut),
            ("lost on a one-way link", network.muted),
            ("duplicated", network.duplicated),
            ("reordered", network.reordered),
            ("robots that crashed for good", self.faults.gone),
            ("robots that restarted with their stored state", self.faults.returned_with_memory),
            ("of these, robots whose disks had been full", self.faults.full_disks),
            ("robots that restarted without it", self.faults.returned_without),
            ("restarts of the coordinator", self.faults.coordinator_returned),
            ("clocks that were ahead", self.faults.clocks),
            ("slow robots", self.faults.slow),
            ("robots with false readings", self.faults.false_reporters),
            ("false readings that were rejected", self.faults.false_readings_rejected),
            ("requests that a robot answered from its disk", self.faults.repeated),
            ("commands of the operator", self.faults.commands),
        ];
        let rows = rows.map(|(what, count)| format!("{count:>12}  {what}\n"));
        format!(
            "{} in {:.1} s, {} observations, {} steps checked: all held\n\n{}",
            counted(self.episodes, "episode"),
            elapsed.as_secs_f64(),
            self.observations,
            self.steps_checked,
            rows.concat(),
        )
    }
}
