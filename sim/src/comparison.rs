//! Policies against each other, over seeds: what is kept of an episode, and what episodes come to together.
//!
//! Of a scenario whose robots decide by one policy, its [`Setting`], each episode is a [`Trial`], and all of them a [`Row`].

mod latencies;
mod row;
mod setting;
mod trial;

use dragnet_proto::state_machine::ParticipantError;
use dragnet_scenario::Scenario;

use crate::episode;
pub use latencies::Latencies;
pub use row::{DecisionTimes, Estimate, FullRecall, MeanCurve, Row};
pub use setting::{Setting, digest};
pub use trial::Trial;

/// Runs an episode of a setting, until all robots rest or, unless the setting lets it go on, every object is found.
///
/// # Errors
/// Never, as long as robots of this process cannot fail.
pub fn run(setting: &Setting, scenario: &Scenario, seed: u64) -> Result<Trial, ParticipantError> {
    Ok(Trial::new(setting, seed, episode::run(scenario, seed, setting.end)?))
}
