//! The description of an experiment without its scenarios: enough to order its trials and to make its tables.

use dragnet_sim::comparison::{Row, Setting, Trial};
use serde::{Deserialize, Serialize};

use crate::ExperimentError;
use crate::seeds::Seeds;
use crate::shard::Shard;

/// The cases and their seeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Design {
    /// Each case, without its scenario.
    pub settings: Vec<Setting>,
    /// The seeds of each case.
    pub seeds: Seeds,
}

impl Design {
    pub(crate) fn episode_count(&self) -> u64 {
        self.settings.len() as u64 * self.seeds.count()
    }

    /// The episodes of a shard, each with its index in the order, the index of its setting, and its seed. They are
    /// ordered by setting, then by seed.
    pub(crate) fn share(&self, shard: Shard) -> impl Iterator<Item = (u64, usize, u64)> {
        let (seeds, settings) = (self.seeds, self.settings.len());
        shard.places(self.episode_count()).map(move |place| {
            let setting = usize::try_from(place / seeds.count()).unwrap_or(settings);
            (place, setting, seeds.at(place % seeds.count()))
        })
    }

    /// A row for each setting, from the trials of all episodes in their order.
    #[must_use]
    pub fn rows(&self, trials: Vec<Trial>) -> Vec<Row> {
        debug_assert_eq!(trials.len() as u64, self.episode_count());
        let count = usize::try_from(self.seeds.count()).unwrap_or(usize::MAX);
        let mut trials = trials.into_iter();
        self.settings.iter().map(|setting| Row::new(setting, trials.by_ref().take(count).collect())).collect()
    }

    /// The label of the policy that others are compared with: the wanted one, or the first.
    ///
    /// # Errors
    /// If the experiment has no such policy.
    pub fn baseline<'a>(&'a self, wanted: Option<&str>) -> Result<&'a str, ExperimentError> {
        let policies = self.settings.iter().map(|setting| setting.policy.as_str());
        dragnet_sim::comparison::baseline(policies, wanted).map_err(|allowed| {
            ExperimentError::Input(format!("--baseline {}: {allowed}", wanted.unwrap_or_default()))
        })
    }
}
