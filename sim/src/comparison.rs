//! Comparison of policies over seeds: the results of an episode, and summaries of episodes.
//!
//! For a scenario whose robots use one policy, its [`Setting`], each episode gives a [`Trial`], and all of them a
//! [`Row`].

pub mod bound;
mod difference;
mod latencies;
mod row;
mod setting;
mod trial;

use dragnet_proto::state_machine::ParticipantError;
use dragnet_scenario::Scenario;

use crate::episode;
pub use difference::{Difference, Interval, Verdict, baseline, differences};
pub use latencies::Latencies;
pub use row::{CellsToRecall, DecisionTimes, Estimate, MeanCurve, Row};
pub use setting::{Setting, digest};
pub use trial::{PARTIAL_RECALLS, Trial};

/// Runs an episode of a setting, until all robots rest or, unless the setting says otherwise, every object is found.
///
/// # Errors
/// Never, since robots of this process cannot fail.
pub fn run(setting: &Setting, scenario: &Scenario, seed: u64) -> Result<Trial, ParticipantError> {
    Ok(Trial::new(setting, seed, episode::run(scenario, seed, setting.end)?))
}
