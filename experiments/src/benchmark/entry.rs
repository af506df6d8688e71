//! What decides on a track.

use std::path::Path;

use dragnet_files::read_at_most;
use dragnet_learn::policy::{PolicyName, Shipped};
use dragnet_scenario::Scenario;
use dragnet_scenario::file::PolicyField;
use dragnet_search::evidence::Digest;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_128;

use super::track::Track;
use crate::ExperimentError;
use crate::comparison::Case;

/// The maximum size of a weights file, bytes.
const MAX_WEIGHTS_BYTES: u64 = 1 << 30;

/// What decides: a policy of this program, or a callable of another.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Decider {
    /// A policy of this program.
    Policy {
        /// With its parameters, as `--policies` takes it; those that are not named have their defaults.
        policy: String,
        /// XXH3-128 of the weights file of a network, 32 hexadecimal digits.
        weights: Option<String>,
    },
    /// A callable in Python.
    Callable(Interface),
}

/// What a callable is shown, and how it acts: the options of the Python environments.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interface {
    /// Kind of its observations.
    pub observation: String,
    /// Their frame.
    pub frame: String,
    /// Kind of its actions.
    pub control: String,
}

/// A policy on the tables of a track.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its name in tables.
    pub name: String,
    /// What decides.
    pub decider: Decider,
}

impl Entry {
    /// An entry of a policy of this program; `gnn` takes these weights, if given.
    ///
    /// # Errors
    /// If the policy names weights itself, or the file cannot be read.
    pub fn of_policy(
        name: String,
        policy: &PolicyField,
        weights: Option<&Path>,
    ) -> Result<Self, ExperimentError> {
        if matches!(policy, PolicyField::Table(table) if table.weights.is_some()) {
            return Err(ExperimentError::Input(format!(
                "{policy}: a result names no file of weights, only their digest; allowed is the policy gnn with --weights"
            )));
        }
        let file = weights.filter(|_| is_general(policy));
        let weights = match (file, shipped(policy)) {
            (Some(file), _) => Some(digest_of_file(file)?),
            (None, Some(shipped)) => Some(Digest(xxh3_128(shipped.weights())).to_string()),
            (None, None) => None,
        };
        Ok(Self { name, decider: Decider::Policy { policy: policy.to_string(), weights } })
    }

    /// Every search of a track with this entry's policy; none of a callable, which decides elsewhere. Networks that are
    /// not part of the program are read from `weights`.
    ///
    /// # Errors
    /// If the policy is unknown, a parameter is out of its range, or the weights are not those of the entry.
    pub fn cases(&self, track: &Track, weights: Option<&Path>) -> Result<Vec<Case>, ExperimentError> {
        let Decider::Policy { policy, weights: digest } = &self.decider else { return Ok(Vec::new()) };
        let field: PolicyField = policy.parse().map_err(ExperimentError::input)?;
        let own = self.own_weights(&field, digest.as_deref(), weights)?;
        let changed = |scenario: &Scenario| match own {
            Some(file) => scenario.with_weights(file),
            None => scenario.with_policy(field.clone()),
        };
        let case = |scenario: &Scenario| {
            let scenario = changed(scenario)
                .map_err(|error| ExperimentError::Input(format!("policy {}: {error}", self.name)))?;
            Ok(Case::new(scenario, &self.name))
        };
        track.searches().iter().map(|search| case(&search.scenario)).collect()
    }

    /// The weights file, if the entry's network is not the one that is part of the program.
    fn own_weights<'a>(
        &self,
        policy: &PolicyField,
        digest: Option<&str>,
        file: Option<&'a Path>,
    ) -> Result<Option<&'a Path>, ExperimentError> {
        let part_of_program = Self::of_policy(self.name.clone(), policy, None)?;
        if part_of_program.decider == self.decider {
            return Ok(None);
        }
        let name = &self.name;
        let wanted = digest.unwrap_or("none");
        let Some(file) = file.filter(|_| is_general(policy)) else {
            return Err(ExperimentError::Input(format!(
                "policy {name}: weights of digest {wanted}, which are not those of this program; --weights names their file"
            )));
        };
        let found = digest_of_file(file)?;
        if digest == Some(found.as_str()) {
            return Ok(Some(file));
        }
        Err(ExperimentError::Input(format!(
            "--weights {}: weights of digest {found}; those of policy {name} have {wanted}",
            file.display()
        )))
    }
}

fn digest_of_file(file: &Path) -> Result<String, ExperimentError> {
    let bytes = read_at_most(file, MAX_WEIGHTS_BYTES)
        .map_err(|error| ExperimentError::Input(format!("--weights {}: {error}", file.display())))?;
    Ok(Digest(xxh3_128(&bytes)).to_string())
}

/// Whether a policy is the one that takes weights: one with parameters would lose them.
fn is_general(policy: &PolicyField) -> bool {
    matches!(policy, PolicyField::Name(name) if name == Shipped::General.as_str())
}

/// The network that a policy has if it is given none.
fn shipped(policy: &PolicyField) -> Option<Shipped> {
    let name = match policy {
        PolicyField::Name(name) => name,
        PolicyField::Table(table) => &table.name,
    };
    match name.parse() {
        Ok(PolicyName::Learned(shipped)) => Some(shipped),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use dragnet_learn::shape::Shape;
    use dragnet_learn::weights::{Recipe, Weights};

    use super::*;

    #[test]
    fn a_network_is_known_by_the_digest_of_its_weights_wherever_they_lie() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, value: f32| {
            let fill = |_: &str, shape: &[usize]| vec![value; shape.iter().product()];
            let weights = Weights::build(Shape::DEFAULT, Recipe::default(), fill).unwrap();
            std::fs::write(folder.path().join(name), weights.to_bytes().unwrap()).unwrap();
            folder.path().join(name)
        };
        let (mine, moved, other) = (write("a", 0.1), write("b", 0.1), write("c", 0.2));
        let gnn: PolicyField = "gnn".parse().unwrap();
        let entry = Entry::of_policy("gnn".to_owned(), &gnn, Some(&mine)).unwrap();
        let shipped = Entry::of_policy("gnn".to_owned(), &gnn, None).unwrap();
        assert_ne!(entry, shipped);
        let track = Track::named("smoke").unwrap();
        let cases = |entry: &Entry, file: Option<&Path>| entry.cases(&track, file).map(|cases| cases.len());
        assert_eq!(cases(&entry, Some(&moved)).unwrap(), 4);
        assert_eq!(cases(&shipped, None).unwrap(), 4);
        let refused = cases(&entry, Some(&other)).unwrap_err().to_string();
        assert!(refused.contains("those of policy gnn have"), "{refused}");
        let refused = cases(&entry, None).unwrap_err().to_string();
        assert!(refused.contains("--weights names their file"), "{refused}");
    }

    #[test]
    fn weights_are_given_by_their_option_alone() {
        let named: PolicyField = "gnn(weights=\"a.safetensors\")".parse().unwrap();
        let refused = Entry::of_policy("gnn".to_owned(), &named, None).unwrap_err().to_string();
        assert!(refused.contains("allowed is the policy gnn with --weights"), "{refused}");
    }
}
