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

use dragnet_agent::agent::Agent;
use dragnet_proto::state_machine::ParticipantError;
use dragnet_scenario::Scenario;
use dragnet_search::observation::RobotId;
use dragnet_search::policy::Policy;

use crate::episode;
pub use difference::{Difference, Interval, Verdict, baseline, differences};
pub use latencies::Latencies;
pub use row::{CellsToRecall, DecisionTimes, Estimate, MeanCurve, Row};
pub use setting::{Setting, digest};
pub use trial::{PARTIAL_RECALLS, Trial, restricted};

/// Runs an episode of a setting, until all robots rest or, unless the setting says otherwise, every object is found.
///
/// # Errors
/// Never, since robots of this process cannot fail.
pub fn run(setting: &Setting, scenario: &Scenario, seed: u64) -> Result<Trial, ParticipantError> {
    Ok(Trial::new(setting, seed, episode::run(scenario, seed, setting.end)?))
}

/// Like [`run`], but each robot decides with the policy that `policy` makes for it, instead of the scenario's.
///
/// # Errors
/// Never, since robots of this process cannot fail.
pub fn run_with(
    setting: &Setting,
    scenario: &Scenario,
    seed: u64,
    mut policy: impl FnMut(RobotId) -> Box<dyn Policy + Send>,
) -> Result<Trial, ParticipantError> {
    let mut robots = episode::team(scenario, seed, |config| {
        let policy = policy(config.robot.id);
        Agent::with_policy(config, policy)
    });
    Ok(Trial::new(setting, seed, episode::run_robots(scenario, seed, setting.end, &mut robots)?))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use dragnet_learn::policy::build;

    use super::*;

    #[test]
    fn a_policy_of_the_callers_has_the_trial_of_the_scenarios() {
        let text = "name = 'a'\nmap = { shape = 'ice_cream_cone', rows = 14, columns = 14, cell_meters = 30.0 }\n\
                    sensor.radius = 2\nobjects.count = 4\nrobots = { count = 2, policy = 'greedy' }\n\
                    mission.budget_meters = 1800.0\n";
        let scenario = Scenario::from_text(Path::new("a.toml"), text.to_owned()).unwrap();
        let setting = Setting::new(&scenario, "greedy".to_owned());
        let without_times = |trial: Trial| Trial { decisions: Vec::new(), ..trial };
        for seed in 0..3 {
            let named = without_times(run(&setting, &scenario, seed).unwrap());
            let mut asked = Vec::new();
            let own = run_with(&setting, &scenario, seed, |robot| {
                asked.push(robot);
                let policy = &scenario.robots()[robot.index()].policy;
                build(policy.name, policy.parameters, None)
            });
            assert_eq!(without_times(own.unwrap()), named);
            assert_eq!(asked, scenario.robots().iter().map(|robot| robot.id).collect::<Vec<_>>());
        }
    }
}
