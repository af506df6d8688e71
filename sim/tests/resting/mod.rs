//! A search without a coordinator until all robots rest.

use dragnet_agent::agent::Agent;
use dragnet_scenario::Scenario;
use dragnet_sim::episode::{self, Episode};
use dragnet_sim::participants::LocalParticipants;
use dragnet_sim::simulation::{End, Membership, Rules};

/// The episode, and the robots at its end.
pub(crate) fn search(scenario: &Scenario, seed: u64) -> (Episode, Vec<Agent>) {
    let rules = Rules { end: End::Resting, coordinator: Membership::Absent };
    let mut robots = episode::team(scenario, seed, Agent::new);
    let mut participants = LocalParticipants::new(&mut robots, None);
    let episode = episode::run_with(scenario, seed, rules, &mut participants, &mut |_, _| ()).unwrap();
    (episode, robots)
}
