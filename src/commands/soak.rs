//! `dragnet soak`: whole teams under faults, thousands of seeds, everything checked.

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

/// Seeds that are run before the time is looked at.
const ROUND: usize = 200;

/// Test teams under injected faults and check their invariants.
///
/// Each seed is another search on a small generated map: robots and a coordinator that lose, delay, repeat and overtake
/// messages, are cut off, in one direction or both, crash, and start again with or without their memory, with clocks that
/// are ahead, wheels that are slow, now and then one among them that lies about what it sees, and a person who pauses the
/// search, marks cells and adds some. After every step of every participant is checked that each reading counts once, that no
/// name is used twice, that nothing is told before it is kept, that what is declared stays declared unless the evidence
/// says otherwise, and that no robot waits for another; in the end, that all believe the same to the bit and the mission is
/// over. Nothing depends on the clock of this machine: a seed that fails once fails always.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet soak --seeds 2000
  dragnet soak --seeds 1000000..2000000 --minutes 60")]
pub(crate) struct Arguments {
    /// An episode for each of these seeds: N for 0 to N - 1, or A..B for A to B - 1
    #[arg(long, value_name = "N | A..B", default_value = "2000", allow_negative_numbers = true)]
    seeds: Seeds,
    /// Stop after so many minutes, however many seeds are left
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    minutes: Option<u32>,
    /// Episodes that run at a time [default: as many as there are cores]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: Option<u16>,
    /// Print one JSON object and nothing else
    #[arg(long)]
    json: bool,
}

/// What all seeds together came to.
#[derive(Default, serde::Serialize)]
struct Total {
    episodes: usize,
    observations: u64,
    /// Steps after which all was checked.
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
        self.faults += survived.bites;
    }

    fn text(&self, elapsed: Duration) -> String {
        let FaultCounts { network, .. } = self.faults;
        let rows = [
            ("messages on their way", network.sent),
            ("lost", network.lost),
            ("lost to a partition", network.cut),
            ("lost on a link of one direction", network.muted),
            ("arrived twice", network.duplicated),
            ("overtaken", network.reordered),
            ("robots that crashed for good", self.faults.gone),
            ("robots that started again with their memory", self.faults.returned_with_memory),
            ("of these, robots whose disks had been full", self.faults.full_disks),
            ("robots that started again without", self.faults.returned_without),
            ("coordinators that started again", self.faults.coordinator_returned),
            ("clocks that were ahead", self.faults.clocks),
            ("slow robots", self.faults.slow),
            ("robots that lied", self.faults.liars),
            ("lies that were refused", self.faults.lies_refused),
            ("questions that a robot answered from its disk", self.faults.repeated),
            ("commands of a person", self.faults.commands),
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
