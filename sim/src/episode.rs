//! Whole episodes in this process: no socket, no thread, thousands of seeds.

use dragnet_agent::agent::{Agent, Orders};
use dragnet_proto::participant::MindError;
use dragnet_proto::scenario::Scenario;
use dragnet_search::belief::Belief;
use dragnet_search::measures::{Score, Truth};

use crate::crew::{Crew, LocalCrew};
use crate::simulation::{Attendance, End, Outcome, Rules, Simulation, Spectator};
use crate::world::World;

/// What an episode came to.
#[derive(Clone, Debug)]
pub struct Episode {
    /// Where the objects were.
    pub truth: Truth,
    /// The belief that all readings together support.
    pub belief: Belief,
    /// How it compares with the truth.
    pub score: Score,
    /// Way covered by each robot, cells.
    pub path_cells: Vec<f64>,
    /// What was measured on the way.
    pub outcome: Outcome,
}

impl Episode {
    /// The end of an episode.
    #[must_use]
    pub fn new(world: World, outcome: Outcome) -> Self {
        Self {
            truth: world.truth().clone(),
            score: world.score(),
            path_cells: world.path_cells().collect(),
            belief: world.into_merged(),
            outcome,
        }
    }
}

/// Runs a scenario with robots alone, no coordinator.
///
/// # Errors
/// Never, as long as robots of this process cannot fail.
pub fn run(scenario: &Scenario, seed: u64, end: End) -> Result<Episode, MindError> {
    let mut robots: Vec<Agent> = Orders::of_team(scenario, seed).into_iter().map(Agent::new).collect();
    let rules = Rules { end, coordinator: Attendance::Absent };
    run_with(scenario, seed, rules, &mut LocalCrew::new(&mut robots, None), &mut |_, _| ())
}

/// Runs a scenario with any crew, watched.
///
/// # Errors
/// If a participant cannot go on.
pub fn run_with<C: Crew>(
    scenario: &Scenario,
    seed: u64,
    rules: Rules,
    crew: &mut C,
    spectator: Spectator<'_>,
) -> Result<Episode, C::Error> {
    let (world, outcome) = Simulation::new(scenario, seed, rules, crew, spectator).run()?;
    Ok(Episode::new(world, outcome))
}
