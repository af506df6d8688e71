//! Whole episodes in this process: no socket, no thread, thousands of seeds.

use dragnet_agent::agent::{Agent, Orders};
use dragnet_proto::scenario::Scenario;
use dragnet_search::belief::Belief;
use dragnet_search::measures::{Score, Truth};

use crate::crew::{Crew, Robots};
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
    fn new(world: World, outcome: Outcome) -> Self {
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
#[must_use]
pub fn run(scenario: &Scenario, seed: u64, end: End) -> Episode {
    let agents = Orders::of_team(scenario, seed).into_iter().map(Agent::new).collect();
    let rules = Rules { end, coordinator: Attendance::Absent };
    match run_with(scenario, seed, rules, Robots::new(agents), &mut |_, _| ()) {
        Ok((episode, _)) => episode,
        Err(never) => match never {},
    }
}

/// Runs a scenario with any crew, watched. Returns the crew as the episode left it.
///
/// # Errors
/// If a participant cannot go on.
pub fn run_with<C: Crew>(
    scenario: &Scenario,
    seed: u64,
    rules: Rules,
    crew: C,
    spectator: Spectator<'_>,
) -> Result<(Episode, C), C::Error> {
    let (world, outcome, crew) = Simulation::new(scenario, seed, rules, crew, spectator).run()?;
    Ok((Episode::new(world, outcome), crew))
}
