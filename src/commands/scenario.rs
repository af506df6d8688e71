//! Scenarios as changed by options of the command line.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fmt::Display;
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use dragnet_learn::policy::{PolicyName, Shipped};
use dragnet_scenario::file::PolicyField;
use dragnet_scenario::{Scenario, ScenarioError, Start};
use dragnet_search::subjects::Subjects;

use super::{Failure, complain};
use crate::terminal::counted;

/// The policy that takes weights.
const GNN: PolicyName = PolicyName::Learned(Shipped::General);

/// Reads a scenario.
pub(super) fn load(path: &Path) -> Result<Scenario, Failure> {
    Scenario::load(path).map_err(Failure::input)
}

/// A path as a shell takes it.
fn quoted(path: &str) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || "._-/+,:".contains(letter);
    if path.chars().all(is_plain) { path.to_owned() } else { format!("'{}'", path.replace('\'', "'\\''")) }
}

/// How probable it is that a subject is outside of the area, as people write it.
pub(super) fn percent_outside(subjects: Subjects) -> f64 {
    (1e6 * subjects.rest_of_world()).round() / 1e4
}

/// What is assumed of a map alone.
fn assumed(scenario: &Scenario) -> String {
    let (terrain, file) = (scenario.terrain(), scenario.source().path.display());
    let (grid, hours) =
        (terrain.grid(), scenario.mission().budget.time().unwrap_or_default().as_secs_f64() / 3600.0);
    let place = scenario
        .object_weights()
        .map_or("anywhere in the search area", |_| "as likely in each cell as the areas say");
    let percent = scenario.subjects().map_or(0.0, percent_outside);
    let elsewhere = if percent > 0.0 { format!(" ({percent} % elsewhere)") } else { String::new() };
    format!(
        "{file} is a map: cells of {} m ({} x {}), a sensor with a radius of {} cells, {} {place}{elsewhere}, {}, \
         policy {}, {hours} h; {}",
        terrain.cell_meters(),
        grid.rows(),
        grid.columns(),
        scenario.sensor().radius(),
        scenario.objects(),
        robots(scenario),
        policies(scenario),
        changing_assumptions(scenario),
    )
}

/// The number of robots, and over how many parts of the area they are spread.
fn robots(scenario: &Scenario) -> String {
    let starts = scenario.robots().iter().map(|robot| match robot.start {
        Start::Together { area } => area,
        Start::Scattered | Start::Cell(_) => 0,
    });
    let robots = counted(scenario.robots().len(), "robot");
    match starts.collect::<BTreeSet<usize>>().len() {
        0 | 1 => robots,
        parts => format!("{robots} that start in {parts} parts of it"),
    }
}

/// How a scenario of a map alone becomes a file.
pub(super) fn changing_assumptions(scenario: &Scenario) -> String {
    format!(
        "to change it: dragnet scenarios --write {}",
        quoted(&scenario.source().path.display().to_string())
    )
}

/// Reads scenarios, and prints their warnings. Their names must differ from each other and from those that are `taken`.
pub(super) fn load_each(paths: &[PathBuf], taken: &[&str]) -> Result<Vec<Scenario>, Failure> {
    let mut names: BTreeSet<String> = taken.iter().map(ToString::to_string).collect();
    let mut scenarios = Vec::new();
    for path in paths {
        let scenario = load(path)?;
        let name = scenario.name();
        if !names.insert(name.to_owned()) {
            let path = path.display();
            return Err(Failure::Input(format!(
                "{path}: the name {name:?} is taken, and results are named by it: give it another `name`"
            )));
        }
        warn(&scenario);
        scenarios.push(scenario);
    }
    Ok(scenarios)
}

/// Prints a scenario's warnings.
pub(super) fn warn(scenario: &Scenario) {
    if scenario.is_of_map() {
        complain("assumed", &assumed(scenario));
    }
    for warning in scenario.warnings() {
        complain("warning", &format!("{}: {warning}", scenario.source().path.display()));
    }
}

/// A scenario with the value of an option, if that is given.
pub(super) fn with<T: Clone + Display>(
    scenario: Scenario,
    flag: &str,
    value: Option<T>,
    change: impl Fn(&Scenario, T) -> Result<Scenario, ScenarioError>,
) -> Result<Scenario, Failure> {
    let Some(value) = value else { return Ok(scenario) };
    change(&scenario, value.clone()).map_err(|error| Failure::Input(format!("{flag} {value}: {error}")))
}

/// Parses the name of a policy.
pub(super) fn policy_names() -> impl TypedValueParser<Value = PolicyName> {
    PossibleValuesParser::new(PolicyName::all().map(PolicyName::as_str))
        .try_map(|name| name.parse::<PolicyName>())
}

/// Parses the argument of an option by a function, and lists the names of the policies in its help.
#[derive(Clone)]
pub(super) struct PolicyParser<T>(pub(super) fn(&str) -> Result<T, String>);

/// Policies of one option, each with its parameters.
#[derive(Clone)]
pub(super) struct Policies(pub(super) Vec<PolicyField>);

/// Parses a policy with its parameters.
pub(super) const POLICY: PolicyParser<PolicyField> =
    PolicyParser(|text| text.parse().map_err(|error: dragnet_scenario::PolicyTextError| error.to_string()));

/// Parses policies that are separated by commas.
pub(super) const POLICIES: PolicyParser<Policies> =
    PolicyParser(|text| dragnet_scenario::policies(text).map(Policies));

impl<T: Clone + Send + Sync + 'static> TypedValueParser for PolicyParser<T> {
    type Value = T;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<T, clap::Error> {
        let text =
            value.to_str().ok_or_else(|| clap::Error::new(ErrorKind::InvalidUtf8).with_cmd(command))?;
        (self.0)(text).map_err(|reason| {
            let option = argument.map_or_else(String::new, |it| format!(" for '{it}'"));
            let message = format!("invalid value '{text}'{option}: {reason}\n");
            clap::Error::raw(ErrorKind::ValueValidation, message).with_cmd(command)
        })
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(PolicyName::all().map(|name| PossibleValue::new(name.as_str()))))
    }
}

/// Checks that weights, if given, are used by one of the policies of an option.
pub(super) fn check_weights(
    weights: Option<&Path>,
    flag: &str,
    policies: &[PolicyField],
) -> Result<(), Failure> {
    match weights {
        Some(file) if !policies.iter().any(takes_weights) => {
            let file = file.display();
            Err(Failure::Input(format!(
                "--weights {file}: no {flag} {GNN}; allowed is with {flag} {GNN} only"
            )))
        }
        _ => Ok(()),
    }
}

/// A scenario whose robots all use the policy of an option; `gnn` gets these weights, if given.
pub(super) fn with_policy(
    scenario: &Scenario,
    flag: &str,
    policy: &PolicyField,
    weights: Option<&Path>,
) -> Result<Scenario, Failure> {
    match weights {
        Some(file) if takes_weights(policy) => scenario
            .with_weights(file)
            .map_err(|error| Failure::Input(format!("--weights {}: {error}", file.display()))),
        _ => with(scenario.clone(), flag, Some(policy.clone()), Scenario::with_local_policy),
    }
}

/// Whether a policy takes the weights of another option: those of its own would be forgotten.
fn takes_weights(policy: &PolicyField) -> bool {
    matches!(policy, PolicyField::Name(name) if name == GNN.as_str())
}

/// The policies of a scenario's robots, each named once.
pub(super) fn policies(scenario: &Scenario) -> String {
    let mut names: Vec<PolicyName> = scenario.robots().iter().map(|robot| robot.policy.name).collect();
    names.sort_unstable();
    names.dedup();
    names.into_iter().map(PolicyName::as_str).collect::<Vec<_>>().join("+")
}

/// Reads a seed from the command line.
pub(super) fn parse_seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("allowed is a whole number from 0 to {}", u64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario(mission: &str) -> Scenario {
        let text = format!(
            "name = 'a'\nmap = {{ shape = 'all_traversable', rows = 5, columns = 5, cell_meters = 0.7 }}\n\
             sensor.radius = 2\nobjects.count = 1\n[robots]\ncount = 3\npolicy = 'path'\n\
             robot = [{{ number = 2, policy = 'greedy' }}]\n[mission]\n{mission}"
        );
        Scenario::from_text(Path::new("a.toml"), text).unwrap()
    }

    #[test]
    fn each_policy_of_a_team_is_named_once() {
        assert_eq!(policies(&scenario("budget_meters = 1.0")), "greedy+path");
    }
}
