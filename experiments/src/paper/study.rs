//! The comparisons of policies that the figures show, each on all four maps.

use dragnet_learn::policy::{PolicyName, Shipped};
use dragnet_scenario::Scenario;
use dragnet_search::policy::PolicyName as Exact;

use super::map::{Map, Size};
use crate::ExperimentError;
use crate::comparison::{Case, Experiment, Row};
use crate::progress::Progress;
use crate::seeds::Seeds;
use crate::shard::Shard;

/// Neither expert nor clone; `random` comes first in every comparison.
pub(super) const BASELINES: [PolicyName; 4] = [
    PolicyName::Exact(Exact::Random),
    PolicyName::Exact(Exact::Coverage),
    PolicyName::Exact(Exact::Nats),
    PolicyName::Exact(Exact::Guts),
];

/// The density of few objects in the paper.
const SPARSE: f64 = 0.01;

/// A comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Study {
    /// `greedy` and its clone on the map that this was trained on.
    Imitation,
    /// `greedy` and all its clones on maps of twice the side.
    Scale,
    /// `greedy` and all its clones at a twentieth of the density.
    Density,
    /// `path`, its clones, and `greedy`.
    PathExpert,
}

/// A completed study.
pub(super) struct Comparison {
    pub(super) study: Study,
    pub(super) seeds: Seeds,
    /// Ordered by map, then by policy as in [`Study::policies`].
    pub(super) rows: Vec<Row>,
}

/// The rows of one map.
#[derive(Clone, Copy)]
pub(super) struct Panel<'a> {
    pub(super) map: Map,
    study: Study,
    pub(super) rows: &'a [Row],
}

impl Study {
    /// The expert of the clones.
    pub(super) const fn expert(self) -> PolicyName {
        PolicyName::Exact(match self {
            Self::Imitation | Self::Scale | Self::Density => Exact::Greedy,
            Self::PathExpert => Exact::Path,
        })
    }

    /// The policies that are compared with the baselines and the expert.
    fn others(self, map: Map) -> Vec<PolicyName> {
        let learned = PolicyName::Learned;
        match self {
            Self::Imitation => vec![learned(map.greedy_clone())],
            Self::Scale | Self::Density => Map::ALL.map(|map| learned(map.greedy_clone())).to_vec(),
            Self::PathExpert => {
                let greedy = PolicyName::Exact(Exact::Greedy);
                vec![greedy, learned(Shipped::General), learned(Shipped::PathIceCreamCone)]
            }
        }
    }

    /// All policies that are compared on a map: the baselines first, so that the others are drawn over them.
    fn policies(self, map: Map) -> Vec<PolicyName> {
        BASELINES.into_iter().chain([self.expert()]).chain(self.others(map)).collect()
    }

    fn scenario(self, map: Map) -> Result<Scenario, ExperimentError> {
        match self {
            Self::Imitation | Self::PathExpert => map.scenario(Size::Thirty),
            Self::Scale => map.scenario(Size::Sixty),
            Self::Density => map.scenario(Size::Thirty)?.with_density(SPARSE).map_err(ExperimentError::run),
        }
    }

    fn cases(self) -> Result<Vec<Case>, ExperimentError> {
        let mut cases = Vec::new();
        for map in Map::ALL {
            let scenario = self.scenario(map)?;
            for policy in self.policies(map) {
                let scenario = scenario.with_policy(policy).map_err(ExperimentError::run)?;
                cases.push(Case::new(scenario, policy.as_str()));
            }
        }
        Ok(cases)
    }
}

/// Runs all studies, as one experiment.
pub(super) fn run(
    studies: &[Study],
    seeds: Seeds,
    threads: Option<u16>,
    progress: &dyn Progress,
) -> Result<Vec<Comparison>, ExperimentError> {
    let cases = studies.iter().map(|study| study.cases()).collect::<Result<Vec<_>, _>>()?;
    let counts: Vec<usize> = cases.iter().map(Vec::len).collect();
    let experiment = Experiment { cases: cases.into_iter().flatten().collect(), seeds };
    if experiment.cases.is_empty() {
        return Ok(Vec::new());
    }
    let trials = experiment.run(Shard::WHOLE, threads, progress)?.results;
    let mut rows = experiment.design().rows(trials).into_iter();
    let mut take = |count| rows.by_ref().take(count).collect();
    Ok(studies
        .iter()
        .zip(counts)
        .map(|(&study, count)| Comparison { study, seeds, rows: take(count) })
        .collect())
}

impl Comparison {
    /// In the order of [`Map::ALL`].
    pub(super) fn panels(&self) -> impl Iterator<Item = Panel<'_>> + Clone {
        let of_one_map = self.rows.chunk_by(|a, b| a.scenario == b.scenario);
        Map::ALL.into_iter().zip(of_one_map).map(|(map, rows)| Panel { map, study: self.study, rows })
    }
}

impl<'a> Panel<'a> {
    /// The row of one of the study's policies.
    #[expect(clippy::expect_used, reason = "each experiment asks for what it has run")]
    pub(super) fn row(self, policy: PolicyName) -> &'a Row {
        self.rows.iter().find(|row| row.policy == policy.as_str()).expect("a policy of the study")
    }

    pub(super) fn expert(self) -> &'a Row {
        self.row(self.study.expert())
    }

    pub(super) fn random(self) -> &'a Row {
        self.row(BASELINES[0])
    }

    /// In the order of tables: the expert, the policies compared with it, and the baselines last.
    pub(super) fn experts_first(self) -> impl Iterator<Item = &'a Row> {
        let (baselines, others) = self.rows.split_at(BASELINES.len());
        others.iter().chain(baselines)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_study_has_its_expert_all_baselines_and_no_policy_twice() {
        for study in [Study::Imitation, Study::Scale, Study::Density, Study::PathExpert] {
            for map in Map::ALL {
                let mut policies = study.policies(map);
                assert_eq!(policies[..BASELINES.len()], BASELINES);
                assert_eq!(policies[BASELINES.len()], study.expert());
                policies.sort_unstable();
                policies.dedup();
                assert_eq!(policies.len(), study.policies(map).len(), "{study:?}");
            }
        }
    }
}
